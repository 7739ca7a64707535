#include "sweep/sweep_part.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <iterator>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <utility>

#include "results/json.hpp"
#include "results/output_file.hpp"
#include "sweep/sweep_table.hpp"
#include "text/number.hpp"
#include "viscobar/results/io_error.hpp"

namespace viscobar {

namespace fs = std::filesystem;

SweepPart part_of(std::string_view text) {
  const std::size_t slash = text.find('/');
  const auto number = number_in<std::size_t>(text.substr(0, slash));
  const auto of = slash == text.npos ? std::nullopt : number_in<std::size_t>(text.substr(slash + 1));
  if (!number || !of || *number < 1 || *number > *of)
    throw std::invalid_argument(
        fmt::format("--part: {} is no part of a sweep; the third of sixteen is 3/16, the first 1/16", text));
  return {*number, *of};
}

std::optional<SweepPart> part_in_job() {
  constexpr std::pair<const char*, const char*> variables[] = {{"OMPI_COMM_WORLD_RANK", "OMPI_COMM_WORLD_SIZE"},
                                                               {"PMI_RANK", "PMI_SIZE"},
                                                               {"PMIX_RANK", "SLURM_STEP_NUM_TASKS"}};
  for (const auto& [rank, size] : variables) {
    const char *own = std::getenv(rank), *all = std::getenv(size);
    const auto number = own ? number_in<std::size_t>(own) : std::nullopt;
    const auto of = all ? number_in<std::size_t>(all) : std::nullopt;
    if (number && of && *number < *of) return SweepPart{*number + 1, *of};
  }
  return std::nullopt;
}

std::vector<SweepRow> rows_beside(const fs::path& directory, const SweepFile& sweep, const SweepPart& part,
                                  const std::function<void(const std::string&)>& complain) {
  std::vector<fs::path> tables;
  const bool whole = part.of == 1;
  if (!whole) tables.push_back(directory / "sweep.h5");
  std::error_code error;
  for (const fs::directory_entry& entry : fs::directory_iterator(directory, error)) {
    const std::string name = entry.path().filename();
    if (name.starts_with("part-") && (whole || !name.ends_with(fmt::format("-of-{}", part.of))))
      tables.push_back(entry.path() / "sweep.h5");
  }
  std::ranges::sort(tables);
  std::vector<SweepRow> rows;
  for (const fs::path& table : tables) {
    if (!fs::is_regular_file(table)) continue;
    try {
      std::ranges::move(SweepTable(table, sweep.plan, sweep.identity(), SweepTable::Access::read).read(),
                        std::back_inserter(rows));
    } catch (const IoError& failure) {
      complain(fmt::format("{}; its rows are not taken, and its cases run here", failure.what()));
    }
  }
  return rows;
}

bool are_whole(const fs::path& directory, std::size_t parts, const SweepPlan& plan) {
  for (std::size_t number = 1; number <= parts; ++number) {
    const SweepPart part{number, parts};
    const fs::path summary = directory / part.name() / "sweep.json";
    if (!fs::is_regular_file(summary)) return false;
    const auto json = nlohmann::json::parse(file_content(summary), nullptr, false);
    const auto done = json.is_object() ? json.find("done") : json.end();
    if (done == json.end() || !done->is_number_unsigned() || done->get<std::size_t>() < part.count(plan.size()))
      return false;
  }
  return true;
}

}  // namespace viscobar

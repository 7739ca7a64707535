#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <nlohmann/json.hpp>
#include <numeric>
#include <optional>
#include <stdexcept>
#include <thread>

#include "cli/commands.hpp"
#include "cli/interrupt.hpp"
#include "cli/messages.hpp"
#include "cli/progress.hpp"
#include "results/output_file.hpp"
#include "results/result_directory.hpp"
#include "sweep/ranks.hpp"
#include "sweep/sweep_page.hpp"
#include "sweep/sweep_results.hpp"
#include "sweep/sweep_workers.hpp"

namespace viscobar::cli {

namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point start) { return std::chrono::duration<double>(Clock::now() - start).count(); }

/// How far the sweep is, on the terminal. The time left follows from the costs that were estimated and the time that
/// the finished cases took.
class SweepProgress {
 public:
  SweepProgress(std::span<const double> costs, std::span<const std::size_t> order, std::size_t kept)
      : costs_(costs), done_(kept) {
    for (const std::size_t i : order) left_ += costs[i];
  }

  void count(const SweepRow& row) {
    ++done_;
    if (!row.completed) ++failed_;
    left_ -= costs_[row.index];
    finished_ += costs_[row.index];
  }

  void show() {
    if (Clock::now() < next_) return;
    next_ = Clock::now() + std::chrono::milliseconds(200);
    std::string line = fmt::format("{} of {} cases", done_, costs_.size());
    if (failed_ > 0) line += fmt::format(", {} failed", failed_);
    if (finished_ > 0.0) line += fmt::format("  {} left", duration(seconds_since(started_) * left_ / finished_));
    status_.show(line);
  }

 private:
  std::span<const double> costs_;
  std::size_t done_, failed_ = 0;
  double left_ = 0.0, finished_ = 0.0;
  Clock::time_point started_ = Clock::now(), next_ = started_ + std::chrono::milliseconds(500);
  StatusLine status_;
};

nlohmann::ordered_json description(const SweepFile& sweep, const SweepResults& results, std::size_t kept,
                                   std::size_t workers, double integration, double seconds) {
  nlohmann::ordered_json json;
  json["title"] = sweep.title;
  json["scene"] = sweep.scene_source;
  json["keys"] = nlohmann::ordered_json::array();
  for (const VariedKey& key : sweep.plan.keys) json["keys"].push_back(key.key);
  json["combine"] = sweep.plan.combine == Combine::zip ? "zip" : "grid";
  json["cases"] = sweep.plan.size();
  json["done"] = results.size();
  json["kept"] = kept;
  json["run"] = results.size() - kept;
  auto& failed = json["failed"] = nlohmann::ordered_json::array();
  for (const SweepRow* row : results.rows())
    if (!row->completed) failed.push_back({{"index", row->index}, {"error", row->error}});
  json["workers"] = workers;
  json["integration_seconds"] = integration;
  json["wall_seconds"] = seconds;
  return json;
}

std::string table(const SweepFile& sweep, const SweepResults& results, std::size_t kept, const fs::path& directory,
                  double seconds) {
  std::string text = heading(sweep.title, "Sweep") + "\n";
  text += row("cases", kept == 0
                           ? fmt::format("{} of {}", results.size(), sweep.plan.size())
                           : fmt::format("{} of {}, {} of them from before", results.size(), sweep.plan.size(), kept));
  if (const std::size_t failed = results.failed(); failed > 0) text += row("failed", fmt::format("{}", failed));
  text += row("whole sweep", fmt::format("{:.3g} s", seconds));
  constexpr std::size_t most_rows = 30;
  const auto rows = results.rows();
  if (!rows.empty()) {
    text += "\n" + viscobar::text(sweep_text_table(sweep, rows, most_rows));
    if (rows.size() > most_rows) text += fmt::format("  and {} more\n", rows.size() - most_rows);
    text += "\n";
  }
  text += row("page", (directory / "sweep.html").string());
  return text +
         row("rows", fmt::format("{}, {}", (directory / "sweep.h5").string(), (directory / "sweep.csv").string()));
}

}  // namespace

SweepCommand::SweepCommand(CLI::App& app)
    : Command(app, "sweep",
              "Run a scene for many values of its keys, on all cores, or under mpirun on many "
              "machines; the same command goes on with a sweep that was stopped"),
      output_(command_) {
  command_.add_option("sweep", file_, "The sweep file (TOML): a scene, and what varies in it")
      ->required()
      ->type_name("SWEEP");
  command_.get_option("--output")
      ->description(
          "Directory of the rows; finished rows of the same sweep are kept (default: the sweep's name with \".out\", "
          "in the working directory)");
  command_.add_option("--set", overrides_, "Replace a value of the scene in all cases (repeatable)")
      ->type_name("TABLE.KEY=VALUE")
      ->allow_extra_args(false);
  command_
      .add_option(
          "--error", error_,
          "Choose what the scene leaves open so that each case keeps this error, such as 1e-4 or \"0.01 %\"; the "
          "same as --set accuracy.error=...")
      ->type_name("ERROR");
  command_.add_flag("--json", json_, "Print one JSON document on standard output, and nothing else there");
  command_
      .add_option("--threads", threads_,
                  "Number of simultaneous cases (default: one a core); under mpirun each rank runs one")
      ->type_name("N")
      ->check(CLI::Range(1, 4096));
}

int SweepCommand::operator()() const {
  const auto started = Clock::now();
  std::optional<Ranks> ranks;
  if (started_by_mpi()) ranks.emplace(interrupt_asked);
  const bool several = ranks && ranks->size() > 1;
  // Until there are rows there is nothing to save. A worker hears of the end from the manager.
  several && !ranks->is_manager() ? catch_interrupts() : end_on_interrupt();
  if (several && !ranks->is_manager()) return ranks->serve(), success;
  if (several && threads_ > 0)
    throw std::invalid_argument("--threads: under mpirun every rank but the first runs one case at a time; give -n");

  std::vector<std::string> overrides = overrides_;
  if (!error_.empty()) overrides.push_back("accuracy.error=" + error_);
  const SweepFile sweep = read_sweep(file_, overrides);
  std::vector<double> costs;
  if (several) costs = ranks->plan(sweep);
  // This one also says why, where no case can run.
  if (std::all_of(costs.begin(), costs.end(), [](double cost) { return cost == 0.0; }))
    costs = plan_cases(sweep, threads_);
  const fs::path directory = output_.where.empty() ? fs::path(file_).stem() += ".out" : fs::path(output_.where);
  catch_interrupts();
  SweepResults results(directory, sweep, warn);
  const std::size_t kept = results.size();
  std::vector<std::size_t> order = dispatch_order(costs);
  std::erase_if(order, [&](std::size_t i) { return results.has(i); });
  // It has the checksums of tables that are about to change.
  if (!order.empty()) fs::remove(directory / "sweep.json");

  double integration = 0.0;
  std::optional<SweepProgress> progress;
  if (!json_ && !output_.quiet && on_terminal()) progress.emplace(costs, order, kept);
  const SweepWork work{sweep, order,
                       [&](const SweepRow& row) {
                         results.add(row);
                         integration += row.integration_seconds;
                         if (progress) progress->count(row);
                       },
                       [&] {
                         results.refresh_tables();
                         if (progress) progress->show();
                       },
                       interrupt_asked};
  const std::size_t threads = threads_ > 0 ? threads_ : std::max(1u, std::thread::hardware_concurrency());
  const std::size_t workers = several ? static_cast<std::size_t>(ranks->size()) - 1 : threads;
  const bool finished =
      order.empty() || (several ? ranks->run(work) : run_on_threads(work, std::min(threads, order.size())));
  progress.reset();
  results.close();
  const std::string page = sweep_page(sweep, results.rows());
  write_atomically(directory / "sweep.html", page);

  FileChecksums checksums = results.checksums();
  checksums["sweep.html"] = Checksum::of(page);
  const std::string json =
      sealed_summary(description(sweep, results, kept, workers, integration, seconds_since(started)), checksums);
  write_atomically(directory / "sweep.json", json);
  if (json_)
    print(json);
  else if (!output_.quiet)
    print(table(sweep, results, kept, directory, seconds_since(started)));
  for (const SweepRow* row : results.rows())
    if (!row->completed) complain(fmt::format("case {}: {}", row->index, row->error));
  if (!finished) {
    complain(fmt::format("interrupted with {} of {} cases done; the same command goes on", results.size(),
                         sweep.plan.size()));
    return stopped;
  }
  return results.failed() == 0 ? success : run_failed;
}

}  // namespace viscobar::cli

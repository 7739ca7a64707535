#include "sweep/sweep_results.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <utility>
#include <variant>

#include "results/csv.hpp"
#include "results/output_file.hpp"
#include "sweep/sweep_table.hpp"
#include "viscobar/results/versions.hpp"

namespace viscobar {

SweepResults::SweepResults(const std::filesystem::path& directory, const SweepFile& sweep,
                           const std::function<void(const std::string&)>& complain)
    : directory_(directory, ResultKind::sweep),
      plan_(sweep.plan),
      table_(std::make_unique<SweepTable>(directory / "sweep.h5", sweep.plan, sweep.identity())),
      rows_(sweep.plan.size()) {
  for (SweepRow& row : table_->read()) keep(std::move(row));
  if (!complain) return;
  const std::string file = (directory / "sweep.h5").string();
  if (const auto& damaged = table_->damaged(); !damaged.empty())
    complain(fmt::format("{}: {} of the rows are damaged, and their cases are run again: {}{}", file, damaged.size(),
                         fmt::join(std::span(damaged).first(std::min<std::size_t>(damaged.size(), 10)), ", "),
                         damaged.size() > 10 ? ", ..." : ""));
  if (table_->build() != versions().build && done_ > 0)
    complain(
        fmt::format("{}: begun by another build of viscobar ({}, this is {}): the last digits of its rows may differ "
                    "from those that follow",
                    file, table_->build(), versions().build));
}

SweepResults::~SweepResults() = default;

std::vector<const SweepRow*> SweepResults::rows() const {
  std::vector<const SweepRow*> finished;
  for (const auto& row : rows_)
    if (row) finished.push_back(&*row);
  return finished;
}

void SweepResults::keep(SweepRow row) {
  ++done_;
  if (!row.completed) ++failed_;
  const std::size_t index = row.index;
  rows_[index] = std::move(row);
}

void SweepResults::add(const SweepRow& row) {
  table_->write(row);
  keep(row);
}

void SweepResults::refresh_tables() {
  // Does it when it is time; says when it is time again.
  const auto now_and_then = [](Clock::time_point& next, Clock::duration least, auto&& action) {
    const auto begin = Clock::now();
    if (begin < next) return;
    action();
    const auto end = Clock::now();
    next = end + std::max(least, 50 * (end - begin));
  };
  now_and_then(next_commit_, Clock::duration::zero(), [&] { table_->commit(); });
  if (written_ != done_) now_and_then(next_, std::chrono::seconds(2), [&] { write_tables(directory_.path()); });
}

void SweepResults::write_tables(const std::filesystem::path& folder) {
  const std::vector<const SweepRow*> finished = rows();
  for (const auto& [name, text] :
       {std::pair{"sweep.csv", sweep_csv(plan_, finished)}, {"timings.csv", timings_csv(finished)}}) {
    write_atomically(folder / name, text);
    checksums_[name] = Checksum::of(text);
  }
  written_ = done_;
}

void SweepResults::close(const std::filesystem::path& folder) {
  table_->close();
  write_tables(folder);
}

namespace {

std::string cell(double value) { return std::isnan(value) ? "" : fmt::format("{}", value); }
std::string cell(std::int64_t value) { return fmt::format("{}", value); }
std::string cell(const std::string& text) { return csv_text(text); }

}  // namespace

std::string sweep_csv(const SweepPlan& plan, std::span<const SweepRow* const> rows) {
  std::string text = "index";
  const auto add = [&](std::string_view next) {
    text += ',';
    text += next;
  };
  for (const VariedKey& key : plan.keys) add(key.key);
  add("completed");
  add("error");
  for (const QuantityColumn& column : quantity_columns()) add(column.name);
  const std::vector<std::string> further = plan.further_columns();
  for (const std::string& name : further) add(name);
  text += '\n';
  for (const SweepRow* row : rows) {
    text += cell(static_cast<std::int64_t>(row->index));
    const std::vector<std::size_t> chosen = plan.choice(row->index);
    for (std::size_t k = 0; k < plan.keys.size(); ++k)
      std::visit([&](const auto& list) { add(cell(list[chosen[k]])); }, plan.keys[k].values);
    add(row->completed ? "1" : "0");
    add(cell(row->error));
    for (std::size_t k = 0; k < quantities + further.size(); ++k) add(cell(row->column(k)));
    text += '\n';
  }
  return text;
}

std::string timings_csv(std::span<const SweepRow* const> rows) {
  std::string text = "index,seconds,integration_seconds\n";
  for (const SweepRow* row : rows)
    fmt::format_to(std::back_inserter(text), "{},{},{}\n", row->index, row->seconds, row->integration_seconds);
  return text;
}

}  // namespace viscobar

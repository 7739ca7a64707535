#include "sweep/sweep_results.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <variant>

#include "input/unit_of_key.hpp"
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
  const auto now_and_then = [this](double& next, double least, auto&& action) {
    const double begin = clock_.seconds();
    if (begin < next) return;
    action();
    const double end = clock_.seconds();
    next = end + std::max(least, 50.0 * (end - begin));
  };
  now_and_then(next_commit_, 0.0, [&] { table_->commit(); });
  if (written_ != done_) now_and_then(next_, 2.0, [&] { write_tables(directory_.path()); });
}

void SweepResults::write_tables(const std::filesystem::path& folder) {
  const std::vector<const SweepRow*> finished = rows();
  for (const auto& [name, text] : {std::pair{"sweep.csv", csv_of(sweep_columns(plan_), finished)},
                                   {"timings.csv", csv_of(timing_columns(), finished)}}) {
    write_atomically(folder / name, text);
    checksums_[name] = Checksum::of(text);
  }
  written_ = done_;
}

void SweepResults::close(const std::filesystem::path& folder) {
  table_->close();
  write_tables(folder);
}

std::vector<Column<const SweepRow*>> sweep_columns(const SweepPlan& plan) {
  using Row = const SweepRow*;
  std::vector<Column<Row>> columns = {{"index", "case", [](Row row) { return Cell(row->index); }}};
  for (std::size_t k = 0; k < plan.keys.size(); ++k) {
    const auto value = [&plan, k](Row row) {
      const std::size_t chosen = plan.choice(row->index)[k];
      return std::visit([&](const auto& list) { return cell(list[chosen]); }, plan.keys[k].values);
    };
    columns.push_back({plan.keys[k].key, plan.keys[k].key, value, {}, false, 6});
    columns.back().unit = unit_of_key(plan.keys[k].key, {}).value_or(UnitPowers{});
  }
  columns.push_back({"completed", "completed", [](Row row) { return Cell(std::size_t{row->completed}); }});
  columns.push_back({"error", "error", [](Row row) { return cell(row->error); }});
  const std::vector<QuantityColumn> numbers = plan.columns();
  for (std::size_t k = 0; k < numbers.size(); ++k) {
    columns.push_back({numbers[k].name, numbers[k].name,
                       [k](Row row) { return std::isnan(row->column(k)) ? Cell() : Cell(row->column(k)); }});
    columns.back().unit = unit_powers(numbers[k].unit).value_or(UnitPowers{});
  }
  return columns;
}

std::vector<Column<const SweepRow*>> timing_columns() {
  using Row = const SweepRow*;
  return {{"index", "case", [](Row row) { return Cell(row->index); }},
          {"seconds", "seconds", [](Row row) { return Cell(row->seconds); }},
          {"integration_seconds", "integration", [](Row row) { return Cell(row->integration_seconds); }}};
}

}  // namespace viscobar

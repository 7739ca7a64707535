#include "io/sweep_results.hpp"

#include <algorithm>
#include <utility>

#include "io/output_file.hpp"
#include "io/sweep_csv.hpp"
#include "io/sweep_table.hpp"

namespace viscobar {

SweepResults::SweepResults(const std::filesystem::path& directory, const SweepFile& sweep)
    : directory_(directory, ResultKind::sweep),
      plan_(sweep.plan),
      table_(std::make_unique<SweepTable>(directory / "sweep.h5", sweep.plan, sweep.identity())),
      rows_(sweep.plan.size()) {
  for (SweepRow& row : table_->read()) keep(std::move(row));
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
  if (written_ == done_ || Clock::now() < next_) return;
  const auto begin = Clock::now();
  write_tables();
  const auto end = Clock::now();
  next_ = end + std::max<Clock::duration>(std::chrono::seconds(2), 20 * (end - begin));
}

void SweepResults::write_tables() {
  const std::vector<const SweepRow*> finished = rows();
  write_atomically(directory_.path() / "sweep.csv", sweep_csv(plan_, finished));
  write_atomically(directory_.path() / "timings.csv", timings_csv(finished));
  written_ = done_;
}

void SweepResults::close() {
  table_->close();
  write_tables();
}

}  // namespace viscobar

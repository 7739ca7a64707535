#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "report/columns.hpp"
#include "results/result_directory.hpp"
#include "results/summary.hpp"
#include "run/stopwatch.hpp"
#include "viscobar/sweep/sweep.hpp"

namespace viscobar {

class SweepTable;

/// The rows of a sweep: in memory, in sweep.h5 each as it comes, in sweep.csv and timings.csv every few seconds.
/// Rows of sweep.h5 that are damaged count as not there.
class SweepResults {
 public:
  /// Goes on with the rows that the directory has of the same sweep, or begins.
  /// Faults of files there that are not in the way go to `complain`.
  /// @throws std::invalid_argument when the directory has another sweep, or files and no result
  /// @throws IoError
  SweepResults(const std::filesystem::path& directory, const SweepFile& sweep,
               const std::function<void(const std::string&)>& complain = {});
  ~SweepResults();

  bool has(std::size_t index) const { return rows_[index].has_value(); }
  std::size_t size() const { return done_; }
  std::size_t failed() const { return failed_; }
  std::vector<const SweepRow*> rows() const;

  void add(const SweepRow& row);
  /// To be called often: brings the rows to the disk, and writes the CSV files, when there is something new and they
  /// have been left alone long enough for each of the two to take at most a fiftieth of the time.
  void refresh_tables();
  void close(const std::filesystem::path& folder);

  const FileChecksums& checksums() const { return checksums_; }

 private:
  void keep(SweepRow row);
  void write_tables(const std::filesystem::path& folder);

  const ResultDirectory directory_;
  const SweepPlan& plan_;
  std::unique_ptr<SweepTable> table_;
  std::vector<std::optional<SweepRow>> rows_;
  std::size_t done_ = 0, failed_ = 0;
  std::optional<std::size_t> written_;  // rows in the CSV files
  FileChecksums checksums_;
  WallClock clock_;
  double next_ = 0.0, next_commit_ = 0.0;  // on it
};

/// The columns of sweep.csv and of the table for people: index, varied keys, completed (1 or 0), error, plan.columns().
/// They refer to the plan.
std::vector<Column<const SweepRow*>> sweep_columns(const SweepPlan& plan);
/// Those of timings.csv, which are apart, so that the rows do not depend on the machine's load.
std::vector<Column<const SweepRow*>> timing_columns();

}  // namespace viscobar

#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "io/hdf5_handle.hpp"
#include "viscobar/analysis/sweep.hpp"

namespace viscobar {

/// One field of a row of `rows`.
struct TableField {
  enum class Kind { real, whole, flag, text };
  std::string name;
  Kind kind;
  std::size_t bytes, offset;
};

/// The fields of a sweep's row: index, the varied keys, completed, error, the quantities.
std::vector<TableField> table_fields(const SweepPlan& plan);

/// sweep.h5, a row for each case, in the order of the cases:
///
///     rows     compound: index, varied keys, completed, error, quantities
///     timings  compound: seconds, integration_seconds
///     done     1 where the row is there
///     identity text that decides about the results
///
/// The file has its full size from the beginning and nothing in it moves: a row is written in its place, and marked as
/// done after that. So it is sound whenever the program is killed, and does not depend on the order in which the cases
/// end. @throws IoError
class SweepTable {
 public:
  /// Opens the table in a directory, or makes it.
  /// @throws std::invalid_argument when the one that is there is of another sweep
  SweepTable(const std::filesystem::path& file, const SweepPlan& plan, const std::string& identity);

  /// The rows that were there at the beginning.
  std::vector<SweepRow> read() const;

  /// When it returns the row survives the end of the program, whatever ends it.
  void write(const SweepRow& row);
  void close();

 private:
  void create(const std::string& identity) const;

  std::filesystem::path path_;
  const SweepPlan& plan_;
  std::vector<TableField> fields_;
  std::size_t row_bytes_ = 0;
  Hdf5File file_;
  Hdf5Type row_type_, timing_type_;
  Hdf5Dataset rows_, timings_, done_;
  std::vector<char> buffer_;
};

}  // namespace viscobar

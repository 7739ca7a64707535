#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "results/field/hdf5_handle.hpp"
#include "text/checksum.hpp"
#include "viscobar/sweep/sweep.hpp"

namespace viscobar {

struct TableField {
  std::string name;
  hid_t type;
  std::size_t bytes;
};

/// sweep.h5, a row for each case, in the order of the cases:
///
///     rows      compound: index, varied keys, completed, error, quantities
///     timings   compound: seconds, integration_seconds
///     checksums of the row and its timings
///     done      1 where the row is there
///     identity  text that decides about the results
///     build     of the program that made the table
///
/// The file has its full size from the beginning and nothing in it moves: a row is written in its place, and marked as
/// done once it is on the disk. So it is sound whenever the program or the machine stops, and does not depend on the
/// order in which the cases end. Whether it is what was written is known by its checksums, before HDF5 reads it
/// (SweepFrame). @throws IoError
class SweepTable {
 public:
  enum class Access { write, read };
  /// Opens the table in a directory; to write it, makes it where there is none.
  /// @throws std::invalid_argument when the one that is there is of another sweep, or of a version without checksums
  /// @throws IoError when it is damaged beside its rows
  SweepTable(const std::filesystem::path& file, const SweepPlan& plan, const std::string& identity,
             Access access = Access::write);

  /// The rows that are there, but for damaged ones: marked as done, and not what was written.
  std::vector<SweepRow> read() const;
  const std::vector<std::size_t>& damaged() const { return damaged_; }
  const std::string& build() const { return build_; }

  /// Keeps a row until commit(): HDF5 takes as long for one as for hundreds.
  void write(const SweepRow& row);
  /// Brings the rows kept so far to the disk and then marks them as done.
  void commit();
  void close();

 private:
  void create(const std::string& identity) const;
  void sync() const;

  std::filesystem::path path_;
  const SweepPlan& plan_;
  std::vector<TableField> fields_;  // index, the varied keys, completed, error, the quantities
  Hdf5File file_;
  Hdf5Type row_type_, timing_type_;
  Hdf5Dataset rows_, timings_, checksums_, done_;
  Checksum identity_;
  std::string build_;
  std::vector<std::size_t> damaged_;
  struct Timings {
    double seconds, integration_seconds;
  };
  struct {  // since the last commit
    std::vector<hsize_t> indices;
    std::string rows;
    std::vector<Timings> timings;
    std::vector<std::uint64_t> checksums;
  } pending_;
};

}  // namespace viscobar

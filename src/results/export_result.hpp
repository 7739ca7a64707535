#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace viscobar {

enum class ExportFormat {
  csv,  ///< u.csv and v.csv: first line t and the nodes' x, then a line per output time; and ends.csv
  npy   ///< x.npy, t.npy, u.npy, v.npy (times x nodes), ends.npy (times x the columns of ends.csv)
};

/// Writes field.h5 and ends.csv of a run as files that need no HDF5, block by block, to `target`, which is created
/// where needed. A run that was stopped gives the rows it has. Returns the files written.
/// @throws std::invalid_argument when `result` holds no run
/// @throws IoError
std::vector<std::filesystem::path> export_result(const std::filesystem::path& result, ExportFormat format,
                                                 const std::filesystem::path& target);

}  // namespace viscobar

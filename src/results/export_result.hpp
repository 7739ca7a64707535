#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace viscobar {

enum class ExportFormat {
  csv,   ///< u.csv, v.csv, stress.csv: first line t and each column's x, then a line per output time; the tables
  xdmf,  ///< field.h5 with a dataset for each time and field.xdmf, for readers such as meshio
  npy    ///< x.npy, t.npy, u.npy, v.npy (times x nodes), stress.npy (times x elements), a table as times x columns
};

/// Writes field.h5, ends.csv and energy.csv of a run, as far as they are there, as files that need no HDF5, block by
/// block, to `target`, which is created where needed. A run that was stopped gives the rows it has. Returns the files
/// written.
/// @throws std::invalid_argument when `result` holds no run
/// @throws IoError
std::vector<std::filesystem::path> export_result(const std::filesystem::path& result, ExportFormat format,
                                                 const std::filesystem::path& target);

}  // namespace viscobar

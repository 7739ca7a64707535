#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

namespace viscobar {

/// Content of a directory of results: for each summary there (of a run, a comparison, a limit or precision study, or
/// the table of a sweep) what was computed, whether it is complete and its key numbers; and every file with its size.
/// Given one of the summaries, of that one alone. As one JSON document and for the terminal.
/// @throws std::invalid_argument when there is no result
/// @throws IoError when a summary cannot be read
std::string result_json(const std::filesystem::path& place);
std::string result_text(const std::filesystem::path& place);

/// True if files of a result are what was written.
enum class FileState {
  sound,
  damaged,
  missing,
  unchecked,  ///< nothing tells what it should be
  foreign     ///< not one of the result
};

struct VerifiedFile {
  std::string name;  ///< within the directory
  std::uintmax_t bytes = 0;
  FileState state = FileState::foreign;
  std::string reason;  ///< where there is one to give
};

/// Reads every file of a result and compares it with the checksums that were taken while it was written: of a run or a
/// study those of its summary, of a sweep those of its rows, of an unfinished run those of its checkpoint, up to it.
/// Files of a run that is not finished beside a whole result are named `unfinished/...`.
/// @throws std::invalid_argument when there is no result
/// @throws IoError when a file cannot be read
std::vector<VerifiedFile> verify_result(const std::filesystem::path& directory);

/// @throws IoError that names a damaged file of a result and says that nothing was `done`. What is missing is only not
/// read.
void check_sound(const std::filesystem::path& directory, std::string_view done);

/// The worst of them: damaged when one is damaged or missing, unchecked when one is that, else sound.
FileState verdict(const std::vector<VerifiedFile>& files);

/// As one JSON document (`directory`, `verdict`, `files`), and as a table for the terminal.
std::string verification_json(const std::filesystem::path& directory, const std::vector<VerifiedFile>& files);
std::string verification_text(const std::filesystem::path& directory, const std::vector<VerifiedFile>& files);

enum class ExportFormat {
  csv,  ///< u.csv, v.csv, stress.csv: first line t and each column's x, then a line per output time; the tables
  xdmf  ///< field.h5 with a dataset for each time and field.xdmf, for readers such as meshio
};

/// Writes field.h5, ends.csv and energy.csv of a run, as far as they are there, as files that need no HDF5, block by
/// block, to `target`, which is created where needed. A run that was stopped gives the rows it has. Returns the files
/// written.
/// @throws std::invalid_argument when `result` holds no run
/// @throws IoError
/// @throws ExportStopped where `stop`, asked between two blocks, says so; nothing is changed then
std::vector<std::filesystem::path> export_result(const std::filesystem::path& result, ExportFormat format,
                                                 const std::filesystem::path& target,
                                                 const std::function<bool()>& stop = {});
struct ExportStopped {};

}  // namespace viscobar

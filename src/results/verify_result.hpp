#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace viscobar {

/// Whether files of a result are what was written.
enum class FileState {
  sound,
  damaged,
  missing,
  unchecked,  ///< nothing tells what it should be
  foreign     ///< not one of the result
};

/// What was found out about a file of a result.
struct VerifiedFile {
  std::string name;  ///< within the directory
  std::uintmax_t bytes = 0;
  FileState state = FileState::unchecked;
  std::string reason;  ///< where there is one to give
};

/// Reads every file of a result and compares it with the checksums that were taken while it was written: of a run or a
/// study those of its summary, of a sweep those of its rows, of an unfinished run those of its checkpoint, up to it.
/// Files of a run that is not finished beside a whole result are named `unfinished/...`.
/// @throws std::invalid_argument when there is no result
/// @throws IoError when a file cannot be read
std::vector<VerifiedFile> verify_result(const std::filesystem::path& directory);

/// The worst of them: damaged when one is damaged or missing, unchecked when one is that, else sound.
FileState verdict(const std::vector<VerifiedFile>& files);

/// As one JSON document (`directory`, `verdict`, `files`), and as a table for the terminal.
std::string verification_json(const std::filesystem::path& directory, const std::vector<VerifiedFile>& files);
std::string verification_text(const std::filesystem::path& directory, const std::vector<VerifiedFile>& files);

}  // namespace viscobar

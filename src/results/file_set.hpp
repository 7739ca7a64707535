#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "input/seal.hpp"

namespace viscobar {

/// New files that replace those of the same names in a directory together: after a fault or a kill the next user of the
/// directory finds all of the old ones, or all of the new.
///
///     DIR/.viscobar.NAME         the files while they are written
///     DIR/.viscobar.NAME.whole   all of them, on the disk, on their way to their places; settle() ends what a kill
///     left
///
/// JSON files, which tell of the others, take their places last. Pictures of the one that is replaced go, but for those
/// that the new one names. @throws IoError
class FileSet {
 public:
  FileSet(std::filesystem::path directory, const std::string& name);
  /// Removes what did not take its place.
  ~FileSet();
  FileSet(const FileSet&) = delete;
  FileSet& operator=(const FileSet&) = delete;

  /// The folder to write the files in; their names may have a folder of their own.
  const std::filesystem::path& folder() const { return part_; }
  void write(const std::string& name, std::string_view text) const;
  /// Has a file in the directory removed as the others take their places.
  void drop(const std::string& name) const { write(name + dropped, {}); }
  void take_places();

  /// Moves what a kill has left on its way; does nothing where there is none.
  static void settle(const std::filesystem::path& directory, const std::string& name);
  /// True if a name in a directory is of the folder of a set.
  static bool is_folder(std::string_view name) { return name.starts_with(".viscobar.") && name != ".viscobar.lock"; }

 private:
  static constexpr const char* dropped = ".dropped";
  std::filesystem::path directory_, part_;
  std::string name_;
};

/// Pictures that a summary tells of, by their names in its directory, and that are not among the new files.
std::vector<std::string> replaced_figures(const std::filesystem::path& summary, const FileChecksums& by);

}  // namespace viscobar

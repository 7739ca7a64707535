#include "results/file_set.hpp"

#include <algorithm>
#include <system_error>
#include <utility>

#include "results/output_file.hpp"
#include "viscobar/results/io_error.hpp"

namespace viscobar {

namespace {

namespace fs = std::filesystem;

fs::path part_folder(const fs::path& directory, const std::string& name) { return directory / (".viscobar." + name); }
fs::path whole_folder(const fs::path& directory, const std::string& name) {
  return directory / (".viscobar." + name + ".whole");
}

/// Regular files in a folder and its folders, JSON files last.
std::vector<fs::path> files_to_move(const fs::path& folder) {
  std::vector<fs::path> files;
  std::error_code error;
  for (auto entry = fs::recursive_directory_iterator(folder, error); entry != fs::recursive_directory_iterator();
       entry.increment(error))
    if (!error && entry->is_regular_file()) files.push_back(entry->path());
  if (error) throw IoError(folder, "cannot be read: " + error.message());
  std::ranges::sort(files);
  std::ranges::stable_partition(files, [](const fs::path& file) { return file.extension() != ".json"; });
  return files;
}

void remove_folder(const fs::path& folder) {
  std::error_code error;
  fs::remove_all(folder, error);
  if (error) throw IoError(folder, "cannot be removed: " + error.message());
}

}  // namespace

FileSet::FileSet(fs::path directory, const std::string& name)
    : directory_(std::move(directory)), part_(part_folder(directory_, name)), name_(name) {
  settle(directory_, name_);
  remove_folder(part_);
  make_directories(part_);
}

FileSet::~FileSet() {
  std::error_code ignored;
  fs::remove_all(part_, ignored);
}

void FileSet::write(const std::string& name, std::string_view text) const {
  make_directories((part_ / name).parent_path());
  write_atomically(part_ / name, text);
}

void FileSet::take_places() {
  for (const fs::path& file : files_to_move(part_))
    if (file.extension() == ".json")
      for (const std::string& name : replaced_figures(directory_ / file.filename(), files_of(file_content(file))))
        drop(name);
  for (const fs::path& file : files_to_move(part_)) {
    const fs::path place = directory_ / file.lexically_relative(part_);
    check_replaceable(place);
    sync_file(file);
  }
  sync_directory(part_);
  move_file(part_, whole_folder(directory_, name_));
  settle(directory_, name_);
}

void FileSet::settle(const fs::path& directory, const std::string& name) {
  const fs::path whole = whole_folder(directory, name);
  if (!fs::is_directory(fs::symlink_status(whole))) return;
  try {
    for (const fs::path& file : files_to_move(whole)) {
      fs::path place = directory / file.lexically_relative(whole);
      make_directories(place.parent_path());
      if (place.extension() == dropped) {
        remove_file(place.replace_extension());
        remove_file(file);
      } else {
        move_file(file, place);
      }
    }
  } catch (const IoError& error) {
    throw IoError(whole, std::string(error.what()) +
                             "; the new result is whole there, and the next command that uses this directory moves it "
                             "to its place");
  }
  remove_folder(whole);
  sync_directory(directory);
}

std::vector<std::string> replaced_figures(const fs::path& summary, const FileChecksums& by) {
  std::vector<std::string> names;
  if (!fs::is_regular_file(summary)) return names;
  const std::string text = file_content(summary);
  if (seal_of(text) != Seal::sound) return names;
  for (const auto& [name, checksum] : files_of(text))
    if (fs::path(name).parent_path() == "figures" && !by.contains(name)) names.push_back(name);
  return names;
}

}  // namespace viscobar

#include "results/result_directory.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <stdexcept>
#include <string>
#include <system_error>
#include <vector>

#include "input/input_text.hpp"
#include "results/checkpoint_file.hpp"
#include "results/file_set.hpp"
#include "results/json.hpp"
#include "results/output_file.hpp"
#include "results/result_info.hpp"
#include "viscobar/results/io_error.hpp"

namespace viscobar {

namespace {

namespace fs = std::filesystem;

constexpr const char *unfinished = "unfinished", *finished = "finished";

fs::file_type type(const fs::path& file) {
  std::error_code error;
  return fs::symlink_status(file, error).type();
}

std::string regular_content(const fs::path& file) {
  if (type(file) != fs::file_type::regular) return {};
  return file_content(file);
}

bool has_result(const fs::path& directory, const ResultFiles& files) {
  const std::string text = regular_content(directory / files.first);
  const auto held = [&](std::string_view word) { return text.find(word) != text.npos; };
  const auto marks = split(files.marks, ' ');
  return files.table() ? std::ranges::any_of(marks, held) : std::ranges::all_of(marks, held);
}

bool holds_whole_run(const fs::path& directory) {
  return has_result(directory, files_of(ResultKind::run)) && is_complete(directory / "summary.json");
}

/// Remains of a command that was killed before it had a summary, or parts of a sweep.
bool begun(const fs::directory_entry& entry) {
  const std::string name = entry.path().filename();
  if (name == DirectoryLock::file_name || FileSet::is_folder(name)) return true;
  if (name.starts_with("part-") && name.find("-of-") != name.npos && fs::is_directory(entry.path())) return true;
  return std::ranges::any_of(result_kinds(), [&](const ResultFiles& files) {
    const auto part_of = [&](std::string_view file) { return name == fmt::format("{}.part", file); };
    return part_of(files.first) || std::ranges::any_of(split(files.others, ' '), part_of);
  });
}

/// Nothing may be in the way that is not ours to replace, and nothing that cannot be replaced.
void check_files(const fs::path& directory, const ResultFiles& files) {
  const bool ours = has_result(directory, files);
  const auto check = [&](std::string_view name) {
    const fs::path file = directory / name;
    const fs::file_type there = type(file);
    if (there == fs::file_type::not_found) return;
    if (there != fs::file_type::regular)
      throw std::invalid_argument(fmt::format("{} is {}, not a file of a result; nothing was changed", file.string(),
                                              there == fs::file_type::symlink ? "a symbolic link" : "no regular file"));
    if (!ours)
      throw std::invalid_argument(
          fmt::format("{} holds files and no result of viscobar (no {} of its own); nothing was overwritten, choose "
                      "another directory, or remove {}",
                      directory.string(), files.first, file.string()));
    if (::faccessat(AT_FDCWD, file.c_str(), W_OK, AT_EACCESS) != 0)
      throw IoError(file, "cannot be written: " + std::generic_category().message(errno) + "; nothing was changed");
  };
  check(files.first);
  std::ranges::for_each(split(files.others, ' '), check);
}

const fs::path& checked_name(const fs::path& directory) {
  const fs::path normal = fs::absolute(directory).lexically_normal();
  const fs::path named = normal.has_filename() ? normal : normal.parent_path();
  if (named.filename() == unfinished && holds_whole_run(named.parent_path()))
    throw std::invalid_argument(fmt::format("{} is where a run into {} has its files until it is finished; give that",
                                            directory.string(), named.parent_path().string()));
  return directory;
}

void check_inner(const fs::path& inner) {
  if (type(inner) == fs::file_type::not_found) return;
  const ResultFiles& files = files_of(ResultKind::run);
  const auto is_begun = [&] { return std::all_of(fs::directory_iterator(inner), fs::directory_iterator(), begun); };
  if (type(inner) != fs::file_type::directory ||
      !(has_result(inner, files) || fs::exists(inner / ResultDirectory::final_summary) || is_begun()))
    throw std::invalid_argument(inner.string() +
                                " is not of viscobar, and in the way of a run; nothing was changed, choose another "
                                "directory");
}

void check_place(const fs::path& directory, ResultKind kind) {
  std::error_code error;
  const fs::file_type there = fs::status(directory, error).type();
  if (there == fs::file_type::not_found) return;
  if (there == fs::file_type::none)
    throw std::invalid_argument(directory.string() + ": " + error.message() + "; choose another place for the results");
  if (there != fs::file_type::directory)
    throw std::invalid_argument(directory.string() + " is not a directory; choose another place for the results");
  const auto files = [&] { return fs::directory_iterator(directory, error); };
  if (std::ranges::none_of(result_kinds(),
                           [&](const ResultFiles& of_kind) { return has_result(directory, of_kind); }) &&
      !std::all_of(begin(files()), end(files()), begun))
    throw std::invalid_argument(directory.string() +
                                " holds files and no result of viscobar (no summary.json); nothing was overwritten, "
                                "choose another directory");
  if (error) throw IoError(directory, "cannot be read: " + error.message());
  check_files(directory, files_of(kind));
  if (kind != ResultKind::run) return;
  for (const char* name : {unfinished, finished}) check_inner(directory / name);
  if (type(directory / unfinished) == fs::file_type::directory) check_files(directory / unfinished, files_of(kind));
}

const fs::path& created(const fs::path& directory, ResultKind kind) {
  check_place(checked_name(directory), kind);
  make_directories(directory);
  return directory;
}

// A file that was moved before a kill is not there any more: doing it again does the rest.
void take_places(const fs::path& directory) {
  const fs::path from = directory / finished;
  if (type(from) != fs::file_type::directory) return;
  if (type(from / ResultDirectory::final_summary) == fs::file_type::regular) {
    const FileChecksums written = files_of(regular_content(from / ResultDirectory::final_summary));
    // First the one that says the run is going on: nothing may be called completed meanwhile.
    if (fs::exists(from / "summary.json")) {
      for (const std::string& name : replaced_figures(directory / "summary.json", written))
        remove_file(directory / name);
      move_file(from / "summary.json", directory / "summary.json");
    }
    for (const std::string_view name : split(files_of(ResultKind::run).others, ' ')) {
      if (!fs::exists(from / name)) continue;
      if (name.starts_with("checkpoint"))
        fs::remove(from / name);
      else
        move_file(from / name, directory / name);
    }
    if (fs::is_directory(from / "figures")) {
      fs::create_directory(directory / "figures");
      for (const auto& entry : fs::directory_iterator(from / "figures"))
        move_file(entry.path(), directory / "figures" / entry.path().filename());
      fs::remove(from / "figures");
    }
    // Files of the earlier result that the later run did not write.
    for (const std::string_view name : split(files_of(ResultKind::run).others, ' '))
      if (!name.starts_with("checkpoint") && !written.contains(std::string(name)) &&
          type(directory / name) == fs::file_type::regular)
        remove_file(directory / name);
    move_file(from / ResultDirectory::final_summary, directory / "summary.json");
  }
  std::error_code ignored;
  fs::remove(from, ignored);
}

void take_all_places(const fs::path& directory) {
  take_places(directory);
  for (const ResultFiles& files : result_kinds()) FileSet::settle(directory, fs::path(files.summary).stem());
  FileSet::settle(directory, "export");
}

// Does so unless somebody else is about it.
void settle_place(const fs::path& place) {
  std::error_code error;
  const auto waits = [](const fs::directory_entry& entry) {
    return entry.path().filename() == finished || entry.path().extension() == ".whole";
  };
  if (std::none_of(fs::directory_iterator(place, error), fs::directory_iterator(), waits)) return;
  try {
    const DirectoryLock lock(place);
    take_all_places(place);
  } catch (const std::exception&) {  // in use, or not ours to write to: it is read as it is
  }
}

/// Nobody writes them any more once the directory is locked, and a run that goes on from a checkpoint makes none.
void remove_parts(const fs::path& directory, const ResultFiles& files) {
  const auto remove = [&](std::string_view name) {
    const fs::path part = directory / fmt::format("{}.part", name);
    if (type(part) == fs::file_type::regular) remove_file(part);
  };
  remove(files.first);
  std::ranges::for_each(split(files.others, ' '), remove);
}

}  // namespace

ResultDirectory::ResultDirectory(const fs::path& directory, ResultKind kind)
    : directory_(directory), unfinished_(directory / unfinished), lock_(created(directory, kind)) {
  take_all_places(directory_);
}

ResultDirectory::ResultDirectory(const fs::path& directory)
    : directory_(checked_name(directory)), unfinished_(directory_ / unfinished), lock_(directory) {
  take_places(directory_);
  for (const fs::path& place : {directory_, unfinished_}) remove_parts(place, files_of(ResultKind::run));
}

// A run that could not begin leaves nothing.
ResultDirectory::~ResultDirectory() { ::rmdir(unfinished_.c_str()); }

fs::path ResultDirectory::place_of_new_run() const {
  if (!holds_whole_run(directory_)) return directory_;
  remove_checkpoints(directory_);  // a run that was killed when it was whole may have left them
  make_directories(unfinished_);
  return unfinished_;
}

void check_run_files(const fs::path& place, const FileChecksums& written) {
  for (const auto& [name, checksum] : written)
    if (type(place / name) != fs::file_type::regular)
      throw IoError(place / name, "was removed or replaced while it was written");
}

void ResultDirectory::replace_by_finished() const {
  // A file that is missing later has been moved already; one that is missing now has been removed by somebody.
  check_run_files(unfinished_, files_of(regular_content(unfinished_ / final_summary)));
  move_file(unfinished_, directory_ / finished);
  try {
    take_places(directory_);
  } catch (const IoError& error) {
    throw IoError(directory_ / finished, std::string(error.what()) +
                                             "; the new result is whole there, and the next command that uses this "
                                             "directory moves it to its place");
  }
}

bool is_complete(const fs::path& summary) {
  const auto json = nlohmann::json::parse(regular_content(summary), nullptr, false);
  return json.is_object() && json.value("completed", nlohmann::json()) == true;
}

void check_result_directory(const fs::path& directory, ResultKind kind) { check_place(checked_name(directory), kind); }

void settle_result_directory(const fs::path& directory) {
  // Exports have folders of their own there.
  for (const fs::path& place : {directory, directory / "csv", directory / "xdmf"}) settle_place(place);
}

bool clear_whole_run(const fs::path& directory) {
  settle_result_directory(directory);
  if (!holds_whole_run(directory) || fs::exists(directory / unfinished) || !has_checkpoint(directory)) return false;
  check_sound(directory, "removed");
  const DirectoryLock lock(directory);
  remove_checkpoints(directory);
  return true;
}

fs::path place_of_stopped_run(const fs::path& directory) {
  if (!holds_whole_run(directory)) return directory;
  if (type(directory / unfinished) == fs::file_type::directory) return directory / unfinished;
  throw std::invalid_argument(directory.string() + " holds no checkpoint: the run there is complete");
}

}  // namespace viscobar

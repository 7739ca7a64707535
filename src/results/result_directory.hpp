#pragma once

#include <filesystem>

#include "results/directory_lock.hpp"
#include "results/result_kind.hpp"
#include "results/summary.hpp"

namespace viscobar {

/// A directory of results, of which this object is the only user until it ends.
///
/// A run may find in it:
///
///     summary.json, not completed       a run that goes on or has stopped; with checkpoint.bin it can be resumed
///     summary.json, completed           a whole result
///     the same, and `unfinished`        a later run, in the state of the first line; the whole result stays as it was
///     `finished`                        that run is whole, and its files are on their way here: killed in the midst of
///                                       it, the next user of the directory ends that
///
/// @throws std::invalid_argument when there are files that are not of a result of viscobar: they are never touched
/// @throws IoError when it is in use, or does not take files
class ResultDirectory {
 public:
  ResultDirectory(const std::filesystem::path& directory, ResultKind kind);
  /// For a run that goes on from a checkpoint, which has the checksums of the files.
  explicit ResultDirectory(const std::filesystem::path& directory);
  ~ResultDirectory();

  /// Where a run that begins puts its files: here, or in `unfinished` where there is a whole result.
  std::filesystem::path place_of_new_run() const;
  /// Gives the files in `unfinished`, where the final summary is final_summary, the place of those here.
  void replace_by_finished() const;

  /// False on a file system without locks.
  bool locked() const { return lock_.held(); }
  const std::filesystem::path& path() const { return directory_; }

  static constexpr const char* final_summary = "summary.final.json";

 private:
  std::filesystem::path directory_, unfinished_;  // the latter for the destructor, which may not ask for memory
  DirectoryLock lock_;
};

/// True if that is a summary, of a run or a study, that says it is complete.
bool is_complete(const std::filesystem::path& summary);

/// Throws what the constructor would for that directory, and makes nothing.
void check_result_directory(const std::filesystem::path& directory, ResultKind kind);

/// Ends what a kill has left half done while the files of a finished run took their places, unless somebody else is
/// about it. Readers call it first.
void settle_result_directory(const std::filesystem::path& directory);

/// @throws IoError when one of the files that a run has written is not there
void check_run_files(const std::filesystem::path& place, const FileChecksums& written);

/// Removes the checkpoints of a run that was killed when its result was whole but for that; whether there were any.
/// @throws IoError when it is in use, or not what was written
bool clear_whole_run(const std::filesystem::path& directory);

/// Where the run in a directory of results has its files that can be resumed: there, or in `unfinished` where there is
/// a whole result. @throws std::invalid_argument when there is nothing but a whole result
std::filesystem::path place_of_stopped_run(const std::filesystem::path& directory);

}  // namespace viscobar

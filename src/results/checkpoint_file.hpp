#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "results/growing_files.hpp"
#include "run/archive.hpp"
#include "viscobar/results/outcome.hpp"
#include "viscobar/run/run.hpp"

namespace viscobar {

void members(Like<CheckpointEvery> auto& every, auto&& each) { each(every.clock, every.interval); }

/// All that a recorded run needs to go on: the scene as understood, the motion, how much of each growing file belongs
/// to it, and what the report and the summary have collected. At the beginning of a run there is a scene only.
struct RunCheckpoint {
  std::string description;          ///< of the scene
  std::vector<std::string> chosen;  ///< its keys that the program chose
  std::optional<CheckpointEvery> schedule;
  std::optional<Checkpoint> motion;
  GrowingFiles::Mark files;
  std::string collected;      ///< archive of what report and summary are made of
  std::vector<double> times;  ///< of the checkpoints so far, this one included
  double wall_seconds = 0.0;  ///< of the run so far

  static void members(auto& self, auto&& each) {
    each(self.description, self.chosen, self.schedule, self.motion, self.files, self.collected, self.times,
         self.wall_seconds);
  }
};

/// The bytes of a checkpoint:
///
///     "viscobar" | format 4 | length of what follows up to the checksum | version, build | payload | CRC-64
///
/// each number of 8 bytes. The length finds every truncation, the Checksum other damage.
std::string encoded(const RunCheckpoint& checkpoint);

/// Content with what stands around it, and back. @throws ArchiveError when it is not what was sealed
std::string sealed(std::string_view content);
std::string_view unsealed(std::string_view bytes);

/// @throws ArchiveError that says what is wrong with the bytes
RunCheckpoint decoded(std::string_view bytes);

/// Puts a checkpoint into a directory of results: under another name first, synced, then renamed; the one before is
/// kept beside it. @throws IoError, with the checkpoints that were there still there
void write_checkpoint(const std::filesystem::path& directory, const RunCheckpoint& checkpoint);

/// The newest sound one, which with CheckFiles::yes is one whose part of the growing files is still what it was: they
/// are read for that. `complaint` says what is wrong with a newer one; empty when nothing is.
enum class CheckFiles { no, yes };
struct FoundCheckpoint {
  RunCheckpoint checkpoint;
  std::string complaint;
};
/// @throws std::invalid_argument when the directory holds none
/// @throws IoError when none of those there can be read
FoundCheckpoint read_checkpoint(const std::filesystem::path& directory, CheckFiles check = CheckFiles::no);

/// True if there is one, sound or not.
bool has_checkpoint(const std::filesystem::path& directory);
/// A damaged one must not take the place of the sound one before it.
void remove_newest_checkpoint(const std::filesystem::path& directory);
void remove_checkpoints(const std::filesystem::path& directory);

}  // namespace viscobar

#pragma once

#include <chrono>
#include <cstddef>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "viscobar/input/scene_file.hpp"
#include "viscobar/results/outcome.hpp"

namespace viscobar {

/// Observers and options of record_run().
struct RecordOptions {
  /// After each step.
  std::function<void(double time, std::size_t steps)> progress;
  /// After each step: whether to end the run, as interrupted. It leaves a checkpoint where it is; with a schedule in
  /// simulated time the last one of that stays.
  std::function<bool()> stop;
  /// Checkpoints while the run goes on; none otherwise. A resumed run keeps its own.
  std::optional<CheckpointEvery> checkpoint;
  /// After each contact change.
  std::function<void(const Event& event)> event;
  /// At each output time.
  std::function<void(const Snapshot& snapshot)> snapshot;
  /// At these times, which may be others than the output times, and in no file. A resumed run has none.
  std::vector<double> watch_times;
  std::function<void(const Snapshot& snapshot)> watch;  ///< gets the motion there
  /// When a run is over, before its summary and report are written: may add an estimate of its error, and warnings.
  std::function<void(Outcome& outcome)> estimate;
  /// Called with the stages of a run to an accuracy before its solution.
  std::function<void(const std::string& what)> message;
  /// For each warning, once, as soon as it arises.
  std::function<void(const std::string& warning)> warning;
  /// Each picture of the report also as figures/NAME.svg.
  bool figures = false;
  /// Start of the wall clock.
  std::chrono::steady_clock::time_point started = std::chrono::steady_clock::now();
};

/// The result of record_run(), besides the files.
struct RunRecord {
  Outcome outcome;                  ///< how far it came
  double began = 0.0;               ///< time from which it went on
  std::string summary;              ///< summary.json as written
  std::optional<Case> run;          ///< case that was run, where record_to_accuracy() chose it
  std::filesystem::path directory;  ///< where its files are: the one given, or `unfinished` in it
};

/// Runs a sound case and writes ends.csv, events.csv, field.h5, field.xdmf, summary.json and report.html to
/// `directory`, which is created where needed. The files grow with the run and are readable at any time; memory does
/// not grow with the number of output times. If the directory holds a complete result, that stays until the new one
/// is complete: the files grow in its folder `unfinished`, and stay there when the run stops early.
/// @throws std::invalid_argument when the directory holds anything but an earlier result; nothing was changed
/// @throws IoError when the directory is in use, or files cannot be created; later failures are in the outcome
RunRecord record_run(const SceneFile& scene, const std::filesystem::path& directory, const RecordOptions& options = {});

/// record_run(), and an estimate of the error of what was run, in outcome and summary, from runs on coarser meshes that
/// take no longer than twice the run itself; absent where they would, or fail. The files are the same.
RunRecord record_with_estimate(const SceneFile& scene, const std::filesystem::path& directory,
                               const RecordOptions& options = {});

/// Runs a scene that asks for an error: chooses what the scene leaves open (see solve()), records the solution as
/// record_run(), with the estimate in outcome and summary, and again with better settings while the estimate does not
/// keep what is asked for and there are any. The finest solution stays. A scene that asks for nothing is recorded as it
/// is. When it is stopped before a solution was begun, nothing is written, and the summary says no more than that.
RunRecord record_to_accuracy(const SceneFile& scene, const std::filesystem::path& directory,
                             const RecordOptions& options = {});

/// The scene of an unfinished run in a directory of results, from its checkpoint.
/// @throws std::invalid_argument when there is no checkpoint
/// @throws IoError when no checkpoint there can be read
SceneFile scene_of_checkpoint(const std::filesystem::path& directory);

/// Continues an unfinished run of a scene from its newest sound checkpoint. Anything beyond it is cut off the files,
/// which end, bit for bit, as those of a run that made the same checkpoints and was never stopped. A checkpoint is
/// sound if this build of the program made it, and its checksum and those of the files at its time are right. Faults of
/// a newer checkpoint are passed to `complain`, if given.
/// @throws std::invalid_argument when there is no checkpoint, or one of another scene
/// @throws IoError when none there is sound; nothing is changed
RunRecord resume_run(const SceneFile& scene, const std::filesystem::path& directory, const RecordOptions& options = {},
                     const std::function<void(const std::string&)>& complain = {});

/// resume_run(), and for a scene that asks for an error the estimate of it, for which the whole run is made once more,
/// in memory, beside those that the estimate needs: the checkpoint holds the state, not the way to it. The settings are
/// those that were chosen.
RunRecord resume_to_accuracy(const SceneFile& scene, const std::filesystem::path& directory,
                             const RecordOptions& options = {},
                             const std::function<void(const std::string&)>& complain = {});

}  // namespace viscobar

#pragma once

#include <chrono>
#include <cstddef>
#include <filesystem>
#include <functional>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "viscobar/io/scene_file.hpp"

namespace viscobar {

/// Thrown from a progress observer to end a run early; what was reached is kept.
class Interrupted : public std::runtime_error {
 public:
  Interrupted() : std::runtime_error("interrupted") {}
};

/// How a run ended.
enum class Ending {
  completed,   ///< at the end of its time
  failed,      ///< the integrator or the disk gave up
  refused,     ///< the method does not fit the system: the user's input
  interrupted  ///< by Interrupted
};

/// How far a run came.
struct Outcome {
  Ending ending = Ending::completed;  ///< how the run ended
  std::string error;                  ///< empty when completed
  double reached_time = 0.0;          ///< these three are counted by listening, so they are known however the run ended
  std::size_t steps = 0;              ///< of the method
  std::size_t events = 0;             ///< contact changes
  std::optional<Statistics> statistics;  ///< absent when the run was ended from outside
  double wall_seconds = 0.0;             ///< of all, reading and writing included
  std::vector<std::string> warnings;     ///< of what the run met: chatter
};

/// What the caller of record_run() wants to hear, and since when it counts.
struct RecordOptions {
  /// After each step; may throw Interrupted.
  std::function<void(double time, std::size_t steps)> progress;
  /// After each contact change.
  std::function<void(const Event& event)> event;
  /// As soon as there is something to warn of, once each.
  std::function<void(const std::string& warning)> warning;
  /// Start of the wall clock.
  std::chrono::steady_clock::time_point started = std::chrono::steady_clock::now();
};

/// What record_run() leaves besides the files.
struct RunRecord {
  Outcome outcome;      ///< how far it came
  std::string summary;  ///< summary.json as written
};

/// Runs a sound case and writes ends.csv, events.csv, field.h5, field.xdmf, summary.json and report.html to
/// `directory`, which is created where needed. The files grow with the run and are readable at any time; memory does
/// not grow with the number of output times.
/// @throws std::invalid_argument when the directory holds anything but an earlier result
/// @throws IoError when the files cannot be created; later failures are in the outcome
RunRecord record_run(const SceneFile& scene, const std::filesystem::path& directory, const RecordOptions& options = {});

}  // namespace viscobar

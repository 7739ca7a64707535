#pragma once

#include <chrono>
#include <cstddef>
#include <filesystem>
#include <functional>
#include <optional>
#include <stdexcept>
#include <string>

#include "viscobar/io/scene_file.hpp"

namespace viscobar {

/// Thrown from a progress observer to end a run early; what was reached is kept.
class Interrupted : public std::runtime_error {
 public:
  Interrupted() : std::runtime_error("interrupted") {}
};

enum class Ending {
  completed,
  failed,      ///< the integrator or the disk gave up
  refused,     ///< the method does not fit the system: the user's input
  interrupted  ///< by Interrupted
};

/// How far a run came.
struct Outcome {
  Ending ending = Ending::completed;
  std::string error;          ///< empty when completed
  double reached_time = 0.0;  ///< these three are counted by listening, so they are known however the run ended
  std::size_t steps = 0;
  std::size_t events = 0;
  std::optional<Statistics> statistics;  ///< absent when the run was ended from outside
  double wall_seconds = 0.0;
};

struct RecordOptions {
  /// After each step; may throw Interrupted.
  std::function<void(double time, std::size_t steps)> progress;
  /// After each contact change.
  std::function<void(const Event& event)> event;
  /// Each picture of the report also as figures/NAME.svg.
  bool figures = false;
  /// Start of the wall clock.
  std::chrono::steady_clock::time_point started = std::chrono::steady_clock::now();
};

/// What record_run() leaves besides the files.
struct RunRecord {
  Outcome outcome;
  std::string summary;  ///< summary.json as written
};

/// Runs a sound case and writes ends.csv, events.csv, field.h5, field.xdmf, summary.json and report.html to
/// `directory`, which is created where needed. The files grow with the run and are readable at any time; memory does
/// not grow with the number of output times.
/// @throws std::invalid_argument when the directory holds anything but an earlier result
/// @throws IoError when the files cannot be created; later failures are in the outcome
RunRecord record_run(const SceneFile& scene, const std::filesystem::path& directory, const RecordOptions& options = {});

}  // namespace viscobar

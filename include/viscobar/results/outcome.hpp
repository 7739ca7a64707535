#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "viscobar/case/accuracy.hpp"
#include "viscobar/run/run.hpp"

namespace viscobar {

/// How a run ended.
enum class Ending {
  completed,   ///< at the end of its time
  failed,      ///< the integrator or the disk gave up
  refused,     ///< the method does not fit the system: the user's input
  interrupted  ///< from outside
};

/// How far a run came.
struct Outcome {
  Ending ending = Ending::completed;                    ///< how the run ended
  std::string error;                                    ///< empty when completed
  double reached_time = 0.0;                            ///< this and the next two are known however the run ended
  std::size_t steps = 0;                                ///< of the method
  std::size_t events = 0;                               ///< contact changes
  std::vector<std::vector<ChangeSensitivity>> changes;  ///< of each contact change, where directions are asked for
  std::vector<double> checkpoints;  ///< times at which checkpoints were made, in all parts of a run that was stopped
  std::optional<Statistics> statistics;         ///< absent when the run could not begin
  double wall_seconds = 0.0;                    ///< of all, reading and writing included
  std::vector<std::string> warnings;            ///< such as chatter
  std::optional<ErrorEstimate> error_estimate;  ///< where one was made
  std::string no_estimate;                      ///< why none was made, in half a sentence; empty: nobody asked
};

/// How often a recorded run makes a checkpoint.
struct CheckpointEvery {
  /// The clock that the interval is measured by.
  enum class Clock {
    simulated,  ///< `interval` in simulated time: a resumed run gives the same bits as one never stopped
    wall        ///< `interval` in seconds: bounds the time lost
  };
  Clock clock = Clock::simulated;  ///< clock of the interval
  double interval = 0.0;           ///< positive
};

}  // namespace viscobar

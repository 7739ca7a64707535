#pragma once

#include <optional>
#include <string>

#include "hard/catalogue.hpp"

namespace viscobar::hard {

/// Outcome of a scene by a method.
struct Outcome {
  enum class Kind {
    right,    ///< every judgement within its tolerance
    wrong,    ///< an answer, and one that an oracle rejects
    error,    ///< stopped, with a message
    refused,  ///< not started, with a message: the method does not take the scene
    killed    ///< by the watchdog, or crashed
  };
  Kind kind = Kind::killed;
  std::string message;  ///< the error's, or the oracle that was closest to its tolerance
  double ratio = 0.0;   ///< of that oracle: error / tolerance
  std::size_t steps = 0, changes = 0;
  double cpu_seconds = 0.0;  ///< references included
};

/// Absent if the outcome is the one of the catalogue: right, refused, or the error that it names. Else the difference.
std::optional<std::string> complaint(const HardScene& scene, MethodName method, const Outcome& outcome);

/// The scene as the method gets it. @throws SceneError
Case load(const HardScene& scene, MethodName method, Mass mass);

/// The methods that the scene is meant for.
std::vector<MethodName> methods_for(const HardScene& scene);

/// The masses of the scene that make a difference to the method.
std::vector<Mass> masses_for(const HardScene& scene, MethodName method);

/// CPU seconds that a run of the tests gets: a third of a test's time, which runs it on up to four masses.
constexpr unsigned patience = VISCOBAR_TEST_TIMEOUT / 3;

/// Runs and judges in a process of its own, which has so much CPU time: neither a crash nor a hang goes further.
Outcome run_guarded(const HardScene& scene, MethodName method, Mass mass, unsigned cpu_seconds = patience);

}  // namespace viscobar::hard

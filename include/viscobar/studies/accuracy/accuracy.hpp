#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <string>

#include "viscobar/case/accuracy.hpp"
#include "viscobar/case/case.hpp"

namespace viscobar {

/// Thrown by a study whose `stop` said so.
struct StudyStopped {};

/// Settings that keep the error of a neighbouring case, for another one to begin with. They are a guess: what they save
/// is runs, and the estimate is made as without them. The step of a scheme is none of them: to look for it on coarse
/// meshes costs less than a step that is somewhat finer than needed.
struct AccuracyStart {
  std::size_t elements = 0;         ///< J; 0: not known
  std::optional<double> tolerance;  ///< relative, of adaptive methods
  std::optional<double> epsilon;    ///< where something is penalised
};
/// The settings of a solution.
AccuracyStart start_at(const Case& solution);

/// A case to be solved to an error that is asked for. What `request.given` names stays as it is in `scene`; the rest is
/// chosen.
struct AccuracyStudy {
  Case scene;                                       ///< sound
  AccuracyRequest request;                          ///< error that is asked for
  bool resumed = false;                             ///< nothing is chosen anew: the scene has what was chosen
  std::optional<AccuracyStart> start;               ///< where a neighbour's search ended; absent: from coarse meshes
  std::size_t threads = 0;                          ///< runs side by side; 0: one a core
  std::size_t most_elements = 20'000;               ///< of a mesh that is tried
  double most_seconds = 60.0;                       ///< on the clock, for the search of a mesh
  std::function<void(const std::string&)> message;  ///< told what is being done; may be empty
  std::function<bool()> stop;                       ///< asked after each step; may be empty
};

/// The finest solution.
struct AccuracyResult {
  Case run;                ///< with what was chosen; record() runs it
  ErrorEstimate estimate;  ///< of its solution
};

/// Chooses method, mass, elements, penalty and tolerance, runs, estimates the error, and goes on until the estimate
/// keeps what is asked for or `estimate.doubt` says why it cannot.
///
///     total = space + penalty + time,   about 65, 10 and 25 % of the request,
///
/// each from runs that differ in one setting: h and 2h, two penalties, two tolerances.
/// @throws std::invalid_argument where the goal has no limit, or the case nothing of its kind (no obstacle)
/// @throws IntegrationError when no run came to its end
/// @throws StudyStopped
AccuracyResult solve(const AccuracyStudy& study);

}  // namespace viscobar

#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "viscobar/case/recording.hpp"

namespace viscobar {

/// Turns the steps of a scheme into a recording on the output times of a case. Between two steps the displacement is
/// the cubic Hermite polynomial of both states, the velocity its derivative (errors O(dt^4) and O(dt^3) where the
/// motion is smooth), the reactions are linear; a step that ends at an output time is kept as it is.
///
///     Recorder recorder(run, "mine");
///     recorder.step(0.0, u, v);
///     while (t < run.end) { ...; recorder.step(t, u, v, reaction_left); }
///     return recorder.recording();
///
/// u and v hold the J+1 nodes of run.mesh(), or the two ends alone: then only end traces are compared.
class Recorder {
 public:
  Recorder(const Case& run, std::string label);  ///< for the output times and the mesh of `run`

  /// The state after a step; times increase strictly, the first one is 0.
  /// @throws std::invalid_argument for another order, a wrong size or a value that is not finite
  void step(double t, std::span<const double> u, std::span<const double> v, double reaction_left = 0.0,
            double reaction_right = 0.0);

  /// A contact change, in order of time. A scheme that reports none is compared without contact times.
  void change(const Event& event);

  /// The next output time that a step has to reach; absent when all have been reached.
  std::optional<double> next() const;

  /// The recording. @throws std::logic_error when the steps did not reach the end
  Recording recording();

 private:
  struct Step {
    double t = 0.0;
    std::vector<double> u, v;
    double reaction_left = 0.0, reaction_right = 0.0;
  };
  void check(double t, std::span<const double> u, std::span<const double> v) const;
  void keep(const Step& to, double t);

  std::vector<double> times_;
  std::optional<Step> latest_;
  Recording recording_;
};

/// Why a recording cannot be compared on a case; absent when it can. Velocities, reactions and events may be missing.
std::optional<std::string> fault(const Recording& recording, const Case& run);

}  // namespace viscobar

#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "viscobar/case/case.hpp"

namespace viscobar {

/// Quantity of interest: the quantity whose error is meant.
enum class Goal {
  displacement,   ///< u, maximum over nodes and output times
  end_traces,     ///< u(0,t) and u(L,t), maximum over output times
  contact_times,  ///< the times of the contact changes at the ends, the worst of them
  impulse,        ///< int R dt of an end up to the end of the run, the worse end
  peak_reaction,  ///< max |R| of an end, the worse end; only where it has a limit, see peak_remark()
  end_velocity    ///< u'(0,t) and u'(L,t), maximum over output times
};
/// In the order of Goal.
inline constexpr Goal all_goals[] = {Goal::displacement, Goal::end_traces,    Goal::contact_times,
                                     Goal::impulse,      Goal::peak_reaction, Goal::end_velocity};
std::string_view name(Goal goal);     ///< in a scene file
std::string_view meaning(Goal goal);  ///< in words

/// The error that a user can bear, and what the scene leaves to choose.
struct AccuracyRequest {
  double error = 1e-4;           ///< > 0, in the unit of `of`; or a share of its largest value
  bool relative = false;         ///< true if `error` is a share
  Goal of = Goal::displacement;  ///< quantity whose error is bounded

  /// Settings that the scene itself gives; they are kept.
  struct Given {
    bool elements = false;     ///< mesh.elements
    bool mass = false;         ///< mesh.mass
    bool method = false;       ///< method.name
    bool epsilon = false;      ///< contact.epsilon
    bool restitution = false;  ///< contact.restitution
    bool tolerance = false;    ///< method.relative_tolerance
    bool step = false;         ///< method.step
  } given;                     ///< keys that are there
};

/// How far a result is from the motion of the bar itself, with a rigid obstacle, in the unit of `of`. Not a bound but
/// an estimate, out of runs that differ in one setting each (docs/accuracy-on-request.md).
struct ErrorEstimate {
  /// A run that was made for the estimate.
  struct Run {
    std::size_t elements = 0;       ///< J
    std::optional<double> setting;  ///< relative tolerance, or time step; absent for methods without either
    std::optional<double> epsilon;  ///< absent where nothing is penalised
    double seconds = 0.0;           ///< of its integration
    std::size_t changes = 0;        ///< contact changes
    bool search = false;            ///< made for the search of a mesh alone; the estimate does not need it
  };

  Goal of = Goal::displacement;      ///< quantity whose error is estimated
  double total = 0.0;                ///< sum of the next three
  double space = 0.0;                ///< of the mesh
  double penalty = 0.0;              ///< of an obstacle that gives way
  double time = 0.0;                 ///< of the integration
  double largest = 0.0;              ///< largest value of that quantity
  std::optional<double> requested;   ///< in the same unit; absent: nothing was asked for
  bool kept = false;                 ///< total <= requested, and nothing in `doubt`
  std::string doubt;                 ///< why the estimate is not to be trusted; empty: it is
  std::optional<double> order;       ///< observed power of h, where the estimate relies on it
  double effectivity = 1.0;          ///< estimate / error is at most this, where the error has the order in theory
  std::vector<std::string> reasons;  ///< why method, mesh, penalty and tolerance are what they are, a sentence each
  std::vector<Run> runs;             ///< made for the estimate, from coarse to fine
  double seconds = 0.0;              ///< that they took together, on the clock
};

/// Why nothing of the kind can be asked of a sound setup, with the key accuracy.of: no obstacle at an end, or a peak
/// that has no limit. Absent where it can.
std::optional<Finding> fault(const AccuracyRequest& request, const Setup& setup);

}  // namespace viscobar

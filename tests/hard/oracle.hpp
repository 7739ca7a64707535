#pragma once

#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "support/maximum_norm.hpp"
#include "viscobar/case/recording.hpp"

/// Judges of the runs of hard scenes. An oracle knows something about the solution that does not come from the
/// method at work, and says by how much the run misses it and by how much it may.
namespace viscobar::hard {

struct Judgement {
  std::string what;
  double error = 0.0, tolerance = 0.0;

  /// Error in units of the tolerance; of a tolerance 0, which asks for equality to the bit, 0 or infinite.
  double ratio() const;
};

/// A run that came to its end.
struct Trial {
  const Case& run;
  const Recording& result;
};

using Oracle = std::function<std::vector<Judgement>(const Trial&)>;

/// Promised error of the displacement: 100 (relative max|u| + absolute) for an adaptive method, ten times the 1e-12 of
/// the exponential method, and for a scheme the accumulated rounding of its steps.
double promised(const Trial& trial, double largest);

/// Invariants of every run: complete and finite; contact changes in order, closing and opening in turn; no pull of an
/// obstacle without dashpot; no penetration of an exact obstacle; the energy account closed.
std::vector<Judgement> invariants(const Trial& trial);

/// Another method that shares as little as possible with this one (see oracle.cpp); where a scene magnifies a change
/// of its initial data, the promise is multiplied by as much, measured by the reference.
enum class Sensitivity { benign, measured };
Oracle agreement(Sensitivity sensitivity = Sensitivity::benign);

/// u(x,t) in closed form. A scheme may be off by dt T max|u_tt|, twice what its first step of order one costs.
Oracle exact(SpaceTimeFunction u, double largest_acceleration = 0.0);

/// The first contact change closes after an undisturbed flight: to rounding, for a scheme to its step.
Oracle first_contact(double time);

/// Contact changes, all of them, with |u_t| or (at a graze) the acceleration that turns an error of u into one of time.
struct Crossing {
  double time = 0.0, speed = 0.0, acceleration = 0.0;
};
Oracle changes(std::vector<Crossing> crossings);

/// No contact change, ever.
Oracle untouched();

/// u(x,t) = u(L - x, t), and every change of one end with one of the other.
Oracle mirrored();

/// The state at the end, u(x).
Oracle settled(SpaceFunction u, double tolerance);

/// Nothing is dissipated, of an energy of the order of `scale`; a scheme may turn the bar round a step too deep, at the
/// cost of `per_change` times its step.
Oracle energy_held(double scale, double per_change = 0.0);

/// The penetration of a long undamped bar into its penalty (exact::ImpactLaw), to what the mesh makes of it: half an
/// element's mass stands in the way of the first contact, for a time h / c, at the speed of the impact.
Oracle impact_law();

/// A point that falls under g = 1 from rest at 0 onto a spring of the given epsilon at -gap (density 1), in closed
/// form. A change of its height by du changes every later bounce by 2 du / v, v the speed there, and the promise counts
/// as often.
Oracle bouncing(double gap, double epsilon);

/// The answer of another case, times a factor, to `tolerance` of its largest displacement.
Oracle scaled(std::function<Case(Case)> base, double factor, double tolerance);

}  // namespace viscobar::hard

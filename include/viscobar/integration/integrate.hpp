#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string_view>

#include "viscobar/dynamics/bar_system.hpp"
#include "viscobar/dynamics/penalty_law.hpp"
#include "viscobar/run/run.hpp"
#include "viscobar/scene/scene.hpp"

namespace viscobar {

/// The methods that a scene can ask for by name: those of this header, the exact solution of an undamped bar
/// (characteristics.hpp), and the fully discrete schemes (schemes.hpp).
/// src/case/method_table.cpp has a row for each.
enum class MethodName {
  cvode,
  ida,
  arkode,
  odeint,
  rigid,
  exponential,
  characteristics,
  fully_discrete,
  finite_difference
};

/// In the order of the enumeration.
inline constexpr MethodName all_methods[] = {MethodName::cvode,
                                             MethodName::ida,
                                             MethodName::arkode,
                                             MethodName::odeint,
                                             MethodName::rigid,
                                             MethodName::exponential,
                                             MethodName::characteristics,
                                             MethodName::fully_discrete,
                                             MethodName::finite_difference};

/// The error that the tolerances bound.
enum class ErrorControl {
  global,  ///< the error of the solution: the bound on each step's error is tightened in proportion
  local    ///< the error of each step, as in SUNDIALS
};

/// Tolerances of an adaptive method: the error of the displacement field is measured against
/// relative * max|u| + absolute in the maximum norm over the nodes, that of the velocity field likewise with max|v|,
/// the maxima over the nodes and over the time passed.
struct Tolerance {
  double relative = 1e-6;  ///< of the largest displacement, and of the largest velocity
  /// Allowed in addition; the same number for both fields, whatever their units. Absent: relative / 1000 of the scene's
  /// own displacement and velocity, see allowance().
  std::optional<double> absolute{};
  ErrorControl control = ErrorControl::global;  ///< error that both tolerances bound

  /// The same with another relative tolerance; the absolute one keeps its ratio to it.
  Tolerance with_relative(double other) const {
    return {other, absolute ? std::optional(*absolute * (other / relative)) : std::nullopt, control};
  }
};

/// The absolute part of a tolerance, for each field.
struct Allowance {
  double displacement = 0.0;  ///< of u
  double velocity = 0.0;      ///< of v
};

/// Tolerance::absolute for both, where it is given; else relative / 1000 times U and U c / L, with tau = min(L / c,
/// end)
///
///     U = max( max |u_0 - its mean|, tau max |u_1|, tau^2 max_x |f| / rho, tau |F| / (rho c), |d| ),
///
/// the load, forces on the ends and their motion by means over time; L where all vanish. `end` is the time at which the
/// run ends.
Allowance allowance(const Tolerance& tolerance, const BarSystem& system, double end);

/// Families of multistep formulas; `automatic` chooses by leg (docs/methods.md).
enum class Formulas { automatic, adams, bdf };

/// Variable-order, variable-step multistep method of SUNDIALS' CVODE.
struct Cvode {
  Penalty penalty;                          ///< of the contacts
  Tolerance tolerance;                      ///< of the solution
  Formulas formulas = Formulas::automatic;  ///< multistep
};

/// Backward differentiation on the residual form rho M v' + eta K v + E K u - M f - R = 0 by SUNDIALS' IDA; takes
/// massless nodes, also without viscosity, where their rows are algebraic.
struct Ida {
  Penalty penalty;      ///< of the contacts
  Tolerance tolerance;  ///< of the solution
};

/// Implicit Runge-Kutta method of order 5 by SUNDIALS' ARKODE (ESDIRK547L2SA2 of Kennedy and Carpenter: seven stages,
/// all but the first with the same matrix, stiffly accurate and L-stable); takes massless nodes, also without
/// viscosity. A one-step method: no order has to be built up again after a contact change.
struct Arkode {
  Penalty penalty;      ///< of the contacts
  Tolerance tolerance;  ///< of the solution
};

/// Steppers of Boost.Odeint; `automatic` is the cheaper of rosenbrock4 and dopri5 (docs/methods.md).
enum class Stepper {
  automatic,
  rosenbrock4,  ///< linearly implicit, order 4
  dopri5        ///< explicit, order 5
};
std::string_view name(Stepper stepper);  ///< in a scene file

/// Boost.Odeint's formulas on u' = w, rho M w' = F. No formula is one of the SUNDIALS methods; forces and tridiagonal
/// factors are the same. Refuses massless nodes without viscosity, whose rows are algebraic.
struct Odeint {
  Penalty penalty;                       ///< of the contacts
  Tolerance tolerance;                   ///< of the solution
  Stepper stepper = Stepper::automatic;  ///< which
};

/// The stepper and the number of steps that Odeint would take for a system and a given time.
struct OdeintPlan {
  Stepper stepper = Stepper::dopri5;  ///< never automatic
  double least_steps = 0.0;           ///< that stability requires
  double longest_step = 0.0;          ///< at which no mode of the mesh grows; 0: of no matter
  std::optional<Finding> refusal;     ///< why the method does not fit
};
/// Chooses the stepper and counts its steps. O(n).
OdeintPlan plan(const BarSystem& system, double duration, const Odeint& method);

/// Matrix exponentials between contact changes located to rounding. Cost O(n^2) a sub-step and O(n^3) a contact state:
/// for small meshes, and as the reference of the other methods.
struct Exponential {
  static constexpr std::size_t most_unknowns = 400;  ///< that its dense matrices are meant for

  Penalty penalty;  ///< of the contacts
};

/// The limit epsilon = 0: a closed contact holds its node at -gap, its reaction is the residual of the node's row,
/// and it opens when the reaction reaches zero. A node with mass has an impact where it closes, v+ = -e v, the other
/// rows keeping their momentum (see collide()); bounces that accumulate end in rest. By ARKODE's
/// formulas; by CVODE's of Adams where nothing dissipates and every node has mass. No span obstacle.
struct Rigid {
  Tolerance tolerance;       ///< of the solution
  double restitution = 0.0;  ///< e in [0, 1], of contact nodes with mass
};

/// Integrates the penalised system from `start` at times.front() to times.back(), and calls the observers.
///
/// `times` are the output times: finite, strictly increasing, at least two. They never change the trajectory.
/// @throws IntegrationError, which has the statistics up to the failure
/// @throws Unfit when the method does not take the system, std::invalid_argument when the arguments make no run
Statistics integrate(const BarSystem& system, const StartingPoint& start, std::span<const double> times,
                     const Cvode& method, const Observers& observers);
/// As above.
Statistics integrate(const BarSystem& system, const StartingPoint& start, std::span<const double> times,
                     const Ida& method, const Observers& observers);
/// As above.
Statistics integrate(const BarSystem& system, const StartingPoint& start, std::span<const double> times,
                     const Arkode& method, const Observers& observers);
/// As above.
Statistics integrate(const BarSystem& system, const StartingPoint& start, std::span<const double> times,
                     const Odeint& method, const Observers& observers);
/// As above.
Statistics integrate(const BarSystem& system, const StartingPoint& start, std::span<const double> times,
                     const Exponential& method, const Observers& observers);
/// As above.
Statistics integrate(const BarSystem& system, const StartingPoint& start, std::span<const double> times,
                     const Rigid& method, const Observers& observers);

}  // namespace viscobar

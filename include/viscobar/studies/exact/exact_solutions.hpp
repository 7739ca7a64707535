#pragma once

#include <numbers>
#include <optional>
#include <vector>

#include "viscobar/case/recording.hpp"
#include "viscobar/scene/scene.hpp"

/// Contact problems of rho u_tt - E u_xx - eta u_xxt = f with known solutions, each with its scene, to measure methods
/// against. Reactions are those of Snapshot: forces of the obstacles, not negative.
namespace viscobar::exact {

/// Unstrained bar that flies at -speed into an obstacle at its left end: until closing() = gap / speed the motion of
/// any bar, u = -speed t.
struct RigidFlight {
  Bar bar;             ///< any
  double speed = 1.0;  ///< > 0, towards the obstacle
  double gap = 0.1;    ///< of the obstacle at the left end

  double closing() const { return gap / speed; }           ///< time of the touch, up to which the solution holds
  double u(double, double t) const { return -speed * t; }  ///< at any x
  double v(double, double) const { return -speed; }        ///< at any x and t
  Scene scene() const;                                     ///< its bar, ends and initial data
};

/// The same flight of an undamped bar (viscosity 0), through the impact: with c = sqrt(E / rho) it is pressed against
/// the obstacle with E speed / c for 2 L / c and leaves unstrained at +speed. After the closing, s = t - gap / speed,
///
///     u = -gap - speed min(s, x/c) + speed max(0, s - (2 L - x)/c).
struct ElasticImpact {
  Bar bar;             ///< of viscosity 0
  double speed = 1.0;  ///< > 0, towards the obstacle
  double gap = 0.1;    ///< of the obstacle at the left end

  double wave_speed() const { return bar.wave_speed(); }                        ///< c
  double closing() const { return gap / speed; }                                ///< time of the touch
  double opening() const { return closing() + 2 * bar.length / wave_speed(); }  ///< 2 L / c later
  double u(double x, double t) const;                                           ///< displacement
  double v(double x, double t) const;                                           ///< velocity
  /// E speed / c in contact, else 0.
  double reaction(double t) const { return t > closing() && t < opening() ? bar.modulus * speed / wave_speed() : 0.0; }
  double energy() const { return 0.5 * bar.density * bar.length * speed * speed; }  ///< rho L speed^2 / 2, kept
  Scene scene() const;                                                              ///< its bar, ends and initial data
};

/// Undamped bar of length, density and modulus 1 over an obstacle of gap 0, right end fixed, released from the uniform
/// strain u_0 = (1 - x)/2, has period 3 and at the obstacle
///
///     u(0,t) = 1/2 - t/2 on [0,1),   0 on [1,2) with reaction 1/2,   (t - 2)/2 on [2,3);   energy 1/8
///
/// [Dabaghi, Petrov, Pousin, Renard, ESAIM: M2AN 48 (2014)].
struct PeriodThree {
  static constexpr double period = 3.0;    ///< of the motion
  static constexpr double closing = 1.0;   ///< in the first period
  static constexpr double opening = 2.0;   ///< in the first period
  static constexpr double energy = 0.125;  ///< kept

  static double end_displacement(double t);  ///< u(0,t)
  static double reaction(double t);          ///< of the obstacle
  static Scene scene();                      ///< its bar, ends and initial data
};

/// Penetration d(t) of a long bar that meets the penalised obstacle, reaction = d / epsilon, at -speed, t from the
/// first touch on. The bar answers to a force with the impedance Z(s) = sqrt(rho (E + eta s)), so that in Laplace space
///
///     d^(s) = V epsilon Z / (s (1 + epsilon s Z)).
///
/// eta = 0: d = V epsilon' (1 - exp(-t / epsilon')), epsilon' = epsilon sqrt(rho E). eta > 0: the inversion integral,
/// drawn in on the singularities, is exact up to a quadrature to rounding,
///
///     d = V epsilon sqrt(rho E)  +  sum_k V e^{s_k t} / (s_k + epsilon^2 rho eta s_k^4 / 2)
///         + (V epsilon / pi) int_{E/eta}^inf e^{-xt} z / (x (1 + epsilon^2 x^2 z^2)) dx,    z^2 = rho (eta x - E),
///
/// s_k the two roots of epsilon^2 rho s^2 (E + eta s) = 1 with epsilon s Z = -1. As epsilon -> 0, with tau = (epsilon
/// sqrt(rho eta))^{2/3}, the largest penetration is 0.8580 V tau at t = 1.645 tau. It holds until the other end is
/// heard of: t < 2 L / c, and t << rho L^2 / eta for the precursor that viscosity sends.
struct ImpactLaw {
  Bar bar;                ///< long
  double speed = 1.0;     ///< V > 0
  double epsilon = 1e-4;  ///< reaction = d / epsilon
  double gap = 0.1;       ///< of the scene

  double penetration(double t) const;  ///< d(t)
  double rate(double t) const;         ///< d'(t)

  /// A maximum of d.
  struct Peak {
    double time = 0.0;         ///< from the first touch on
    double penetration = 0.0;  ///< d there
  };
  /// The first maximum; absent where d rises to its final V epsilon sqrt(rho E) without one, as for eta = 0.
  std::optional<Peak> peak() const;

  double closing() const { return gap / speed; }                        ///< time of the touch in the scene
  Scene scene() const { return RigidFlight{bar, speed, gap}.scene(); }  ///< a flight that ends in this contact
};

/// Contact of a viscous bar at one or both ends, smooth between the changes, exact for every eta > 0. An end with
/// s = sin(omega t) has the given opening g = s_+^3 and reaction r = ((-s)_+)^2, complementary by construction: it is
/// open in the first half of each period and closed in the second. The stress that this needs is p(t) with
/// eta p' + E p = -r, p(0) = 0, and
///
///     u = sum over ends  (g - gap) A + p phi,
///     f = sum over ends  rho (g'' A + p'' phi) - (E (g - gap) + eta g') A'' + r phi'',
///
/// with A = 1, phi = x - x^2 / (2 L) where one end is free, and A = 1 - 3 y^2 + 2 y^3, phi = L (y - 2 y^2 + y^3),
/// y = x / L, for two obstacles; x counts from the end in question.
struct ManufacturedContact {
  /// An end with an obstacle.
  struct End {
    double gap = 0.25;                    ///< of the obstacle
    double omega = 2 * std::numbers::pi;  ///< the contact has the period 2 pi / omega

    double opening(double t) const;   ///< g
    double reaction(double t) const;  ///< r
  };
  Bar bar{1.0, 1.0, 1.0, 0.5};      ///< of viscosity > 0
  std::optional<End> left = End{};  ///< absent: free
  std::optional<End> right;         ///< absent: free

  double u(double x, double t) const;  ///< displacement
  double v(double x, double t) const;  ///< velocity
  double f(double x, double t) const;  ///< the load that makes it a solution
  /// r of the left end.
  double reaction_left(double t) const { return left ? left->reaction(t) : 0.0; }
  /// r of the right end.
  double reaction_right(double t) const { return right ? right->reaction(t) : 0.0; }
  /// Contact changes in (0, end), in order of time; they graze, velocity 0.
  std::vector<Event> changes(double end) const;
  Scene scene() const;  ///< its bar, ends, load and initial data
};

/// An exact solution of a scene, whatever its kind: what recordings are measured against.
struct Solution {
  Scene scene;                  ///< that it solves
  SpaceTimeFunction u;          ///< displacement
  SpaceTimeFunction v;          ///< velocity
  TimeFunction reaction_left;   ///< empty: zero
  TimeFunction reaction_right;  ///< empty: zero
};
Solution solution(const ElasticImpact& impact);         ///< of its own scene
Solution solution(const ManufacturedContact& contact);  ///< of its own scene

/// The same motion from t0 on, as a scene that begins there. Its load must be a GeneralLoad, or none.
Solution later(Solution solution, double t0);

/// The solution itself as a solver, to stand beside others in a cross-check: sampled at nodes and output times.
Solver solver(Solution solution);

/// How far a recording is from an exact solution: maxima over its times, of the L2 norms over the bar (of the nodal
/// interpolant) and at the ends, and the L1 norm in time of the reactions' error (by the trapezoidal rule), which
/// exists also where the reaction jumps. What a recording does not have counts as 0.
struct Error {
  double displacement_l2 = 0.0;  ///< max over time of the L2 norm
  double velocity_l2 = 0.0;      ///< max over time of the L2 norm
  double end_trace = 0.0;        ///< max over time of the worse end's |u - u_exact|
  double reaction_l1 = 0.0;      ///< the worse end
};
Error error(const Recording& recording, const Solution& solution);  ///< at the recording's own times

}  // namespace viscobar::exact

#pragma once

#include <algorithm>
#include <span>
#include <vector>

#include "dynamics/derivative/derivative.hpp"
#include "dynamics/energy_terms.hpp"
#include "integration/layout.hpp"
#include "viscobar/integration/integrate.hpp"

namespace viscobar {

/// Error accumulation: the error of a run by steps that keep their bound, in multiples of that bound:
/// local errors add up, an undamped bar forgets none of them, and a bounce multiplies what was there before it.
/// Measured in docs/methods.md.
struct Accumulation {
  double dissipating, conserving, per_change;
};
inline constexpr Accumulation multistep_accumulation{150.0, 1000.0, 6.0};
/// One-step methods advance the more accurate of the two solutions whose difference is their error estimate.
inline constexpr Accumulation one_step_accumulation{2.0, 10.0, 1.0};

/// Steps that the motion bounds are wrong by 11 tolerances of a derivative at most, and mostly by a hundredth of one.
/// Measured in 299 runs of tests/sensitivity, each step's error estimate over the largest derivative of its run so far.
inline constexpr double derivative_slack = 10.0;

/// The promise of docs/methods.md: errors of the solution stay below this multiple of the tolerance.
inline constexpr double promised_multiple = 100.0;

/// Error weights of Tolerance: 1 / (relative max|u| + absolute) for each entry of u, likewise for w, 0 for dependent
/// entries and the energy account. The maxima run over the time passed, so that a bar at rest for a moment does not ask
/// for absurd accuracy. A node of mass m on the spring k of a closed contact turns an error of u into one of w, omega =
/// sqrt(k / m) times as large: its u may be wrong by what w may be, divided by omega.
///
/// A step that is right for the motion is right for a derivative where the motion stirs it, but a bar that flies
/// without strain is passed over in steps of any length. So a step may be wrong by `derivative_slack` tolerances of a
/// derivative at most: more than errors of a sound step come to, for which the steps are those of the run without.
class ErrorWeights {
 public:
  ErrorWeights(const PenalisedSystem& system, const Layout& layout, const Tolerance& tolerance, double end,
               const Accumulation& accumulation, std::span<Derivative* const> derivatives = {})
      : system_(system),
        layout_(layout),
        tolerance_(tolerance),
        absolute_(allowance(tolerance, system.bar(), end)),
        massive_begin_(system.bar().inertia().massive_begin()),
        massive_end_(system.bar().inertia().massive_end()),
        inertia_(system.bar().bar().density * system.bar().bar().length),
        accumulated_(dissipates(system.contacts()) ? accumulation.dissipating : accumulation.conserving),
        per_change_(accumulation.per_change),
        clearances_(system.contacts().collides() ? system.contacts().size() : 0),
        heights_(clearances_.size()) {
    for (const Derivative* derivative : derivatives) derivatives_.push_back({derivative->relative_scale(end)});
  }

  /// `weights` are those of the last call, or 0.
  void fill(std::span<const double> y, std::span<double> weights);
  /// Takes the state into the maxima, and no more: for a method that asks for the two weights of the fields alone.
  void notice(std::span<const double> y);
  double weight_of_displacement() const;                            ///< of u, but where a spring has its own
  double weight_of_velocity() const { return 1.0 / resolved_w(); }  ///< of w with mass
  /// The local tolerance is the requested one divided by what errors accumulate to after that many contact changes.
  void tighten(std::size_t changes) {
    if (tolerance_.control == ErrorControl::global)
      tightening_ = accumulated_ + per_change_ * static_cast<double>(changes);
  }
  /// Errors of w of that size, an oscillation that is passed over, do not count; 0 for none.
  void pass_over(double oscillation) { passed_over_ = oscillation; }
  double largest_displacement() const { return largest_u_; }
  double largest_velocity() const { return largest_w_; }
  double displacement_tolerance() const;
  /// Tolerance of the node of contact i that collides, beside its own motion: a bar may fly far whose end bounces low.
  double tolerance_at(std::size_t i) const;
  /// Open contact i, which collides, has been so far from its obstacle.
  void widen(std::size_t i, double clearance) { clearances_[i] = std::max(clearances_[i], clearance); }
  /// The height of a bounce of that contact that counts for nothing: beside its own motion, or beside the bar's where
  /// it is a hundredth of the highest so far, or among what roundings of the clearance stir. A rest is one error,
  /// however many changes there were.
  double negligible_bounce(std::size_t i) const;
  /// The node of contact i has left for such a height.
  void bounce(std::size_t i, double height) { heights_[i] = std::max(heights_[i], height); }
  double velocity_tolerance() const;
  /// Tolerance of (h/E) times a reaction, u + gap + (eta/E) w + ...
  double reaction_tolerance() const;
  /// Size of the same without an effect: a force R displaces the bar by R L/E, so that (h/E) R of h/L tolerances of u
  /// is within the tolerance. Rounding errors of u and of (eta/E) w have none either.
  double negligible_reaction(double h) const;
  /// An error of (u, w) that the stress of an element shows once has in (rho M a)_i, a = -(rho M)^{-1} (E K u + eta K
  /// w), the largest h^2 omega^2 of the mass, 12, times what its row has beside the diagonal, 1/4 at most.
  static constexpr double inertial_share = 1.0 + 12.0 / 4.0;
  /// Promised errors of u and w.
  double promised_displacement() const { return promised_multiple * displacement_tolerance() * tightening_; }
  double promised_velocity() const { return promised_multiple * velocity_tolerance() * tightening_; }
  /// Error of the kinetic energy by the promised error of the velocities.
  double promised_energy() const;

  static void members(auto& weights, auto&& each) {
    each(weights.largest_u_, weights.largest_w_, weights.derivatives_, weights.clearances_, weights.heights_);
  }

 private:
  double viscous_tolerance() const;  // of (eta/E) w
  double relative() const;           // tolerance of a step
  double resolved_w() const;         // error that w may have
  struct OfDerivative {
    double relative_scale = 0.0, largest_u = 0.0, largest_w = 0.0;
    static void members(auto& of, auto&& each) { each(of.relative_scale, of.largest_u, of.largest_w); }
  };
  void fill_derivatives(std::span<const double> y, std::span<double> weights);

  const PenalisedSystem& system_;
  Layout layout_;
  Tolerance tolerance_;
  Allowance absolute_;
  std::size_t massive_begin_, massive_end_;
  double inertia_, largest_u_ = 0.0, largest_w_ = 0.0, accumulated_, per_change_, tightening_ = 1.0, passed_over_ = 0.0;
  std::vector<OfDerivative> derivatives_;
  std::vector<double> clearances_, heights_;  // largest ones so far, of contacts that collide; else none
};

}  // namespace viscobar

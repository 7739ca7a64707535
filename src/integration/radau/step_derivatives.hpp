#pragma once

#include <span>
#include <vector>

#include "dynamics/derivative.hpp"
#include "integration/layout.hpp"
#include "integration/radau/load_tail.hpp"
#include "integration/radau/shifted_systems.hpp"
#include "viscobar/run/run.hpp"

namespace viscobar::radau {

/// The derivatives by parameters on a step of Formula. Each obeys the bar's equations under a force that the bar's own
/// motion makes: a load, taken at the stages from the motion's polynomial. So each costs a solve with the factor of the
/// step. The impulses of the ends are integrals, by the same formula.
class StepDerivatives {
 public:
  /// All outlive it.
  StepDerivatives(PenalisedSystem& system, const Layout& layout, std::span<Derivative* const> derivatives);

  /// Of the state y at t, from which the next step begins; completes the velocities of massless nodes.
  void evaluate(ShiftedSystems& systems, double t, std::span<double> y);

  /// A step from t of length h whose last stage is at `reached`, motion_at(t, y) giving the motion within it, from the
  /// blocks of `begin`: what it is wrong by, as Formula::error() says, times the blocks of `weights`.
  template <class Motion>
  double attempt(ShiftedSystems& systems, double t, double h, double reached, std::span<const double> begin,
                 std::span<const double> weights, Statistics& statistics, Motion&& motion_at) {
    h_ = h;
    at_stages(t, reached, motion_at, [&](std::size_t m, const Moment& at) { add_force(m, at, begin); });
    return solve(systems, weights, statistics);
  }

  /// That step is made: the blocks of `end`.
  template <class Motion>
  void finish(double t, double reached, std::span<const double> begin, std::span<double> end, Motion&& motion_at) {
    at_stages(t, reached, motion_at, [&](std::size_t m, const Moment& at) { add_impulse_rates(m, at, begin); });
    blocks_at(1.0, begin, end);
  }

  /// The blocks at a part theta of the step.
  void blocks_at(double theta, std::span<const double> begin, std::span<double> y) const;

 private:
  template <class Motion, class Look>
  void at_stages(double t, double reached, Motion&& motion_at, Look&& look) {
    for (std::size_t m = 0; m < stages; ++m) {
      const double now = m + 1 == stages ? reached : t + Formula::get().nodes[m] * h_;
      motion_at(now, state_);
      system_.complete_velocity(now, layout_.u(state_), layout_.w(state_));
      look(m, moment(now, state_));
    }
  }

  struct Part {
    std::vector<double> force, stiff_rate, impulse_rates;  // where the step begins
    std::vector<Complex> x, impulses;
    LoadTail load_tail;
  };

  Moment moment(double t, std::span<const double> y);
  void impulse_rates(Derivative& derivative, const Moment& at, std::span<const double> s, std::vector<double>& rates);
  void add_force(std::size_t stage, const Moment& at, std::span<const double> begin);
  double solve(ShiftedSystems& systems, std::span<const double> weights, Statistics& statistics);
  void add_impulse_rates(std::size_t stage, const Moment& at, std::span<const double> begin);
  void motion_of(std::size_t k, double theta, std::span<const double> begin, std::span<double> s, std::size_t first,
                 std::size_t last) const;

  PenalisedSystem& system_;
  const Layout& layout_;
  std::span<Derivative* const> derivatives_;
  bool asks_for_inertia_ = false;
  double h_ = 0.0;
  std::vector<Part> parts_;
  std::vector<double> state_, acceleration_, inertial_force_, force_, s_, rates_;
};

}  // namespace viscobar::radau

#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "schemes/time_step.hpp"
#include "viscobar/run/run.hpp"

namespace viscobar {

/// Energy of scheme (2.8):
///
///     E^{n-1/2} = 1/2 p.rho M p + 1/4 E (a(u^n, u^n) + a(u^{n-1}, u^{n-1})).
///
/// Its balance over a step, v^n = (u^{n+1} - u^{n-1}) / (2 dt):
///
///     E^{n+1/2} - E^{n-1/2} = dt (f, v) - eta dt a(v, v) - dt v.rho (M - Q) a + dt lambda v.
///
/// Dashpots, sides that resist and frames that move add terms.
class StepEnergy {
 public:
  /// Steps are dt from times.front() on. All but dt outlive it.
  StepEnergy(const BarSystem& system, TimeStep& step, std::span<const double> times, double dt);

  /// All that account() depends on, for a checkpoint.
  static void members(auto& energy, auto&& each) { each(energy.taken_, energy.taken_at_rest_, energy.touching_); }

  /// E^{n-1/2} in the frame of the system.
  double energy() const;
  /// Its two parts, of the bar itself, t being t_n.
  EnergyState parts(double t) const;
  /// Contribution of a frame that moves; 0 otherwise.
  double of_frame(double t) const { return system_.frame().moving() ? parts(t).total() - energy() : 0.0; }

  /// After TimeStep::advance() from n on: adds what the step dissipated and the work done.
  void account(std::size_t n, EnergyAccount& energy);
  /// v^n . rho (M - Q) a^n, of a mass with one-sided rows.
  double end_power() const;

 private:
  double time(std::size_t n) const { return begin_ + static_cast<double>(n) * dt_; }
  auto velocity() const;
  auto velocity_at_nodes() const;
  auto displacement_at_nodes() const;
  auto acceleration_at_nodes() const;
  void account_frame(std::size_t n, EnergyAccount& energy) const;
  void account_side(std::size_t n, const SideRows& side, EnergyAccount& energy) const;
  double taken_by_contacts(std::size_t n, EnergyAccount& energy) const;
  void watch_growth(double t, double taken, EnergyAccount& energy);

  const BarSystem& system_;
  TimeStep& step_;
  LaneBar bar_;
  std::vector<std::size_t> places_;        // of the nodes, where they are stored
  std::span<const unsigned char> active_;  // of the step
  double begin_, end_, dt_;
  double taken_ = 0.0, taken_at_rest_ = 0.0;  // by impacts: up to now, and the most when nothing touched
  bool touching_ = false;
};

}  // namespace viscobar

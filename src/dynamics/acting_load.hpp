#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <numeric>
#include <optional>
#include <span>
#include <utility>

#include "viscobar/dynamics/bar_system.hpp"
#include "viscobar/dynamics/load_vector.hpp"

namespace viscobar {

/// The drive of a system, M f(t) + added: the load of its bar, where that has one, on the side of a break that the leg
/// is on, and a force beside it. Owns the load's buffers.
class ActingLoad {
 public:
  /// The bar outlives it.
  explicit ActingLoad(const BarSystem& bar) : bar_(bar) {
    if (bar.loaded()) load_.emplace(bar);
  }

  bool acts() const { return load_.has_value(); }            ///< f is not zero
  bool varies() const { return load_ && !load_->steady(); }  ///< f depends on time
  /// Evaluations of the load's functions of time so far.
  std::size_t evaluations() const { return load_ ? load_->evaluations() : 0; }
  /// To be called where a leg begins: the time to which the load stays smooth, `end` at most (see LoadVector::enter).
  double begin_leg(double t, double end) { return load_ ? load_->enter(t, end) : end; }

  std::span<const double> nodal(double t) { return load_->at(t); }  ///< M f(t), where it acts()
  /// (M f)_i, 0 without a load.
  double of_bar(std::size_t unknown, double t) { return load_ ? load_->at(t)[unknown] : 0.0; }
  /// The same with what is added.
  double at(std::size_t unknown, double t) { return of_bar(unknown, t) + (added_.empty() ? 0.0 : added_[unknown]); }
  /// (M f)_i, evaluated at that node alone.
  double alone(std::size_t unknown, double t) const { return load_ ? load_->at(t, unknown) : 0.0; }
  /// (M f)_i = history(t) factor(i) where it has one (see LoadVector).
  std::optional<double> factor(std::size_t unknown) const { return load_ ? load_->factor(unknown) : std::nullopt; }
  double history(double t) const { return load_->history(t); }
  /// (M f)_e of a fixed end.
  double held(bool right, double t) const { return load_ ? load_->at_held(t, right) : 0.0; }
  /// Adds all of it.
  void add_to(double t, std::span<double> out) {
    if (load_) {
      const std::span<const double> load = load_->at(t);
      for (std::size_t i = 0; i < out.size(); ++i) out[i] += load[i];
    }
    for (std::size_t i = 0; i < added_.size(); ++i) out[i] += added_[i];
  }
  /// w.M f(t), where it acts()
  double power(double t, std::span<const double> w) {
    const std::span<const double> load = load_->at(t);
    return std::inner_product(load.begin(), load.end(), w.begin(), 0.0);
  }

  /// From here on `force` acts, too: an entry for each unknown, which outlives this. `rates` are those of its first and
  /// last entry, where massless nodes without viscosity follow it.
  void add(std::span<const double> force, std::array<double, 2> rates) { added_ = force, added_rates_ = rates; }
  double added_rate(bool right) const { return added_rates_[right]; }  ///< of what is added, in the row of an end

  /// Two times of the leg, 1e-4 element transit times or less to either side of t: the difference of the loads there
  /// gives the load's rate at t. The same time twice in a leg that is too short to have a rate.
  std::pair<double, double> beside(double t) const {
    // No load is asked for before the start, where it need not exist.
    return {load_->inside(std::max(0.0, t - apart())), load_->inside(t + apart())};
  }
  /// Adds (M f)' by that difference, and by no more: nothing where there is no rate.
  void add_rate(double t, std::span<double> rate) {
    if (!varies()) return;
    const auto [before, after] = beside(t);
    if (before >= after) return;
    for (const auto& [at, sign] : {std::pair{before, -1.0}, {after, 1.0}}) {
      const std::span<const double> load = load_->at(at);
      for (std::size_t i = 0; i < rate.size(); ++i) rate[i] += sign / (after - before) * load[i];
    }
  }
  /// Where the load has a break at t, the jumps of M f and of its rate (see LoadVector::jump).
  bool jump(double t, double end, std::span<double> force, std::span<double> rate) {
    return varies() && load_->jump(t, end, apart(), force, rate);
  }

  /// t, on the side of a break that the leg is on.
  double inside(double t) const { return load_ ? load_->inside(t) : t; }
  /// Displacement of the frame (see MovingFrame::lift), there.
  Lift lift(double t, int derivative) const {
    return bar_.frame().moving() ? bar_.frame().lift(inside(t), derivative) : Lift{};
  }

 private:
  double apart() const { return 1e-4 * bar_.mesh().spacing() * bar_.bar().slowness(); }

  const BarSystem& bar_;
  std::optional<LoadVector> load_;
  std::span<const double> added_;
  std::array<double, 2> added_rates_{};
};

}  // namespace viscobar

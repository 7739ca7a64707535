#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <numeric>
#include <optional>
#include <span>
#include <vector>

#include "integration/sundials/arkode_stepper.hpp"
#include "viscobar/dynamics/penalised_system.hpp"

namespace viscobar {

/// A multistep method that is relieved by one-step formulas, those of ARKODE, at the same tolerance, on the same legs
/// and with the same located changes, where it is at its worst:
///
///   - in an event storm. It begins every leg at order one with a step to match, and where legs are short it never gets
///     to what it is good at; a one-step method has no history that a contact change could cost it. So once the last
///     `legs` legs were short on average, until a leg is long again. Where that proves dearer than what it replaces, as
///     at tight tolerances, which are the affair of high orders, it is not done again. Measured in docs/storms.md.
///   - at rest. A contact that stays closed does not bounce, and its spring dies out. Yet Adams' formulas have to
///     resolve it for stability, and backward differentiation of order 3 to 5 is unstable near the imaginary axis,
///     where the spring is: it keeps an oscillation of the size of the tolerance alive for ever. ARKODE's formulas are
///     L-stable. They are tried on a leg once it has cost ten times what a trial does and its steps still resolve the
///     spring, keep it if their first steps lead further at their price, and are tried again after twice as many
///     steps otherwise. Measured in docs/storms.md, too.
template <class Multistep>
class RelievedStepper {
 public:
  RelievedStepper(PenalisedSystem& system, const Layout& layout, const Tolerance& tolerance, double end,
                  Statistics& statistics, Multistep& multistep)
      : system_(system),
        layout_(layout),
        tolerance_(tolerance),
        end_(end),
        statistics_(statistics),
        multistep_(multistep),
        y_(layout.size),
        events_(statistics.events) {}

  void begin_run(std::vector<std::size_t> sampled_entries) {
    entries_ = sampled_entries;
    multistep_.begin_run(std::move(sampled_entries));
  }

  void restart(double t, double stop, std::span<const double> y) {
    stop_ = stop;
    // Where contacts change together, as those of a symmetric bar, they share the cost of the leg.
    const std::size_t changes = std::max<std::size_t>(statistics_.events - events_, 1);
    for (std::size_t k = 0; k < changes; ++k) lengths_[leg_++ % legs] = tried_ ? most_steps : steps_ / changes;
    events_ = statistics_.events;
    if (turn_ == Turn::storm) account();
    period_ = slowest_period();
    patience_ = first_patience;
    tried_ = false;
    if (turn_ == Turn::storm ? !worthwhile() : relieved())
      end_relief();
    else if (!relieved() && recognised())
      begin_storm();
    begin_stretch(t);
    if (relieved())
      one_step_->restart(t, stop, y);
    else
      multistep_.restart(t, stop, y);
  }

  void before_step() {
    switch (turn_) {
      case Turn::multistep:
        if (steps_ >= patience_ && held_by_spring()) begin_trial();
        return;
      case Turn::storm:
        if (steps_ < calm) return;
        account();
        give_back();
        return;
      case Turn::trial:
        if (steps_ < trial_steps) return;
        if (pace() > price * multistep_pace_) {
          turn_ = Turn::rest;
        } else {
          give_back();
          patience_ *= 2;
        }
        return;
      case Turn::rest: return;
    }
  }

  double advance() {
    begun_[steps_++ % trial_steps] = t_;
    return t_ = relieved() ? one_step_->advance() : multistep_.advance();
  }

  std::size_t order() const { return relieved() ? one_step_->order() : multistep_.order(); }
  void interpolate(double t, std::span<double> y) {
    relieved() ? one_step_->interpolate(t, y) : multistep_.interpolate(t, y);
  }
  std::span<const double> sample(double t, int derivative) {
    return relieved() ? one_step_->sample(t, derivative) : multistep_.sample(t, derivative);
  }
  void select(std::span<const std::size_t> sampled) {
    relieved() ? one_step_->select(sampled) : multistep_.select(sampled);
  }
  void hull(std::span<double> lowest, std::span<double> highest) {
    relieved() ? one_step_->hull(lowest, highest) : multistep_.hull(lowest, highest);
  }
  double largest() const { return relieved() ? one_step_->largest() : multistep_.largest(); }
  double displacement_tolerance() const {
    return relieved() ? one_step_->displacement_tolerance() : multistep_.displacement_tolerance();
  }
  double account_correction() const { return relieved() ? 0.0 : multistep_.account_correction(); }
  /// Their maxima are those of both methods.
  ErrorWeights& weights() {
    if (relieved()) multistep_.weights().adopt_largest(one_step_->weights());
    return multistep_.weights();
  }

 private:
  enum class Turn { multistep, storm, trial, rest };

  static constexpr std::size_t legs = 16;
  static constexpr std::size_t most_steps = 40;        // of a leg, on average over them
  static constexpr std::size_t calm = 20;              // steps of a leg after which a storm is over
  static constexpr std::size_t trial_steps = 20;       // steps by which the one-step formulas are judged at rest
  static constexpr std::size_t first_patience = 1000;  // ten trials: these steps at their price, and a new beginning

  // A step of ARKODE has six stages, in the time of which a multistep method makes three steps and more.
  static constexpr double price = 3.0;

  bool relieved() const { return turn_ != Turn::multistep; }

  double mean_length() const {
    return static_cast<double>(std::accumulate(lengths_.begin(), lengths_.end(), std::size_t{0})) / legs;
  }

  // A massless node does not bounce off a rigid obstacle.
  bool recognised() const {
    const bool bounces = !system_.rigid() || system_.collides();
    return bounces && worthwhile() && leg_ > legs && mean_length() < most_steps;
  }

  // What a leg took, and what it would have taken at the price of those before the storm.
  void account() {
    ++storm_legs_;
    paid_ += price * static_cast<double>(steps_);
    saved_ += replaced_length_;
  }
  bool worthwhile() const { return storm_legs_ < legs || paid_ <= saved_; }

  // Of the closed contacts' springs, 0 without any: a massless node has none, and without dissipation nothing comes to
  // rest.
  double slowest_period() const {
    double period = 0.0;
    if (!system_.dissipates()) return period;
    for (std::size_t i = 0; i < system_.contact_count(); ++i) {
      const double rate = system_.closed(i) ? system_.contact_rate(i) : 0.0;
      if (rate > 0.0) period = std::max(period, 2.0 * std::numbers::pi / rate);
    }
    return period;
  }

  // Time per step, over the last ones.
  double pace() const { return (t_ - begun_[steps_ % trial_steps]) / trial_steps; }

  // Steps longer than half a period do not resolve the spring, so it cannot be what bounds them.
  bool held_by_spring() const { return pace() < 0.5 * period_; }

  // Of a leg, made by one of the two methods.
  void begin_stretch(double t) {
    t_ = t;
    steps_ = 0;
  }

  void begin_storm() {
    begin_relief();
    replaced_length_ = mean_length();
    turn_ = Turn::storm;
  }

  void begin_trial() {
    multistep_pace_ = pace();
    multistep_.interpolate(t_, y_);
    begin_relief();
    one_step_->restart(t_, stop_, y_);
    begin_stretch(t_);
    tried_ = true;
    turn_ = Turn::trial;
  }

  void begin_relief() {
    if (!one_step_) {
      one_step_.emplace(system_, layout_, tolerance_, end_, statistics_);
      one_step_->begin_run(entries_);
    }
    one_step_->weights().adopt_largest(multistep_.weights());
  }

  void end_relief() {
    multistep_.weights().adopt_largest(one_step_->weights());
    if (turn_ == Turn::storm) lengths_.fill(most_steps);
    turn_ = Turn::multistep;
  }

  // Within a leg.
  void give_back() {
    one_step_->interpolate(t_, y_);
    end_relief();
    multistep_.restart(t_, stop_, y_);
    begin_stretch(t_);
  }

  PenalisedSystem& system_;
  Layout layout_;
  Tolerance tolerance_;
  double end_;
  Statistics& statistics_;
  Multistep& multistep_;
  std::optional<sundials::ArkodeStepper> one_step_;  // made when first needed
  std::vector<std::size_t> entries_;
  std::vector<double> y_;
  std::size_t events_;                       // until the leg began
  std::array<std::size_t, legs> lengths_{};  // of the last legs, in steps a change
  std::size_t leg_ = 0, steps_ = 0, storm_legs_ = 0;
  double replaced_length_ = 0.0, paid_ = 0.0, saved_ = 0.0;  // in steps of the multistep method
  double t_ = 0.0, stop_ = 0.0;                              // now, and the end of the leg
  std::size_t patience_ = first_patience;                    // steps of the multistep method before a trial
  std::array<double, trial_steps> begun_{};                  // when the last steps did
  double multistep_pace_ = 0.0;                              // before a trial
  double period_ = 0.0;                                      // of the slowest spring of a closed contact
  bool tried_ = false;                                       // in this leg
  Turn turn_ = Turn::multistep;
};

}  // namespace viscobar

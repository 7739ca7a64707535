#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <numeric>
#include <optional>
#include <span>
#include <vector>

#include "integration/sundials/arkode_stepper.hpp"
#include "viscobar/dynamics/penalised_system.hpp"

namespace viscobar {

/// A multistep method that leaves event storms to one-step formulas.
///
/// A multistep method begins every leg at order one with a step to match, and where legs are short it never gets to
/// what it is good at. A one-step method has no history: a contact change costs it nothing but the end of a step. So
/// once the last `legs` legs were short on average, ARKODE makes the steps, at the same tolerance, on the same legs and
/// with the same located changes, until a leg is long again. Where that proves dearer than what it replaces, as at
/// tight tolerances, which are the affair of high orders, it is not done again. Measured in docs/storms.md.
template <class Multistep>
class StormStepper {
 public:
  StormStepper(PenalisedSystem& system, const Layout& layout, const Tolerance& tolerance, double end,
               Statistics& statistics, Multistep& multistep)
      : system_(system),
        layout_(layout),
        tolerance_(tolerance),
        end_(end),
        statistics_(statistics),
        multistep_(multistep),
        y_(layout.size) {}

  void begin_run(std::vector<std::size_t> sampled_entries) {
    entries_ = sampled_entries;
    multistep_.begin_run(std::move(sampled_entries));
  }

  void restart(double t, std::span<const double> y) {
    lengths_[leg_++ % legs] = steps_;
    if (storm_) account();
    steps_ = 0;
    if (storm_ && !worthwhile())
      end_storm();
    else if (!storm_ && recognised())
      begin_storm();
    if (storm_)
      one_step_->restart(t, y);
    else
      multistep_.restart(t, y);
  }

  void before_step() {
    if (storm_ && steps_ >= calm) {
      account();
      steps_ = 0;
      one_step_->interpolate(t_, y_);
      end_storm();
      multistep_.restart(t_, y_);
    }
    if constexpr (requires { multistep_.before_step(); })
      if (!storm_) multistep_.before_step();
  }

  double advance() {
    ++steps_;
    return t_ = storm_ ? one_step_->advance() : multistep_.advance();
  }

  std::size_t order() const { return storm_ ? one_step_->order() : multistep_.order(); }
  void interpolate(double t, std::span<double> y) {
    storm_ ? one_step_->interpolate(t, y) : multistep_.interpolate(t, y);
  }
  std::span<const double> sample(double t, int derivative) {
    return storm_ ? one_step_->sample(t, derivative) : multistep_.sample(t, derivative);
  }
  void select(std::span<const std::size_t> sampled) {
    storm_ ? one_step_->select(sampled) : multistep_.select(sampled);
  }
  void hull(std::span<double> lowest, std::span<double> highest) {
    storm_ ? one_step_->hull(lowest, highest) : multistep_.hull(lowest, highest);
  }
  double largest() const { return storm_ ? one_step_->largest() : multistep_.largest(); }
  double displacement_tolerance() const {
    return storm_ ? one_step_->displacement_tolerance() : multistep_.displacement_tolerance();
  }
  /// Their maxima are those of both methods.
  ErrorWeights& weights() {
    if (storm_) multistep_.weights().adopt_largest(one_step_->weights());
    return multistep_.weights();
  }

 private:
  static constexpr std::size_t legs = 16;
  static constexpr std::size_t most_steps = 40;  // of a leg, on average over them
  static constexpr std::size_t calm = 20;        // steps of a leg after which a storm is over

  // A step of ARKODE has six stages, in the time of which a multistep method makes three steps and more.
  static constexpr double price = 3.0;

  double mean_length() const {
    return static_cast<double>(std::accumulate(lengths_.begin(), lengths_.end(), std::size_t{0})) / legs;
  }

  // A rigid contact has massless nodes, which do not bounce.
  bool recognised() const { return !system_.rigid() && worthwhile() && leg_ > legs && mean_length() < most_steps; }

  // What a leg took, and what it would have taken at the price of those before the storm.
  void account() {
    ++storm_legs_;
    paid_ += price * static_cast<double>(steps_);
    saved_ += replaced_length_;
  }
  bool worthwhile() const { return storm_legs_ < legs || paid_ <= saved_; }

  void begin_storm() {
    if (!one_step_) {
      one_step_.emplace(system_, layout_, tolerance_, end_, statistics_);
      one_step_->begin_run(entries_);
    }
    one_step_->weights().adopt_largest(multistep_.weights());
    replaced_length_ = mean_length();
    storm_ = true;
  }

  void end_storm() {
    multistep_.weights().adopt_largest(one_step_->weights());
    lengths_.fill(most_steps);
    storm_ = false;
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
  std::array<std::size_t, legs> lengths_{};  // of the last legs, in steps
  std::size_t leg_ = 0, steps_ = 0, storm_legs_ = 0;
  double replaced_length_ = 0.0, paid_ = 0.0, saved_ = 0.0;  // in steps of the multistep method
  double t_ = 0.0;
  bool storm_ = false;
};

}  // namespace viscobar

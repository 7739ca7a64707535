#pragma once

#include <fmt/format.h>

#include <cstddef>
#include <limits>

#include "run/step_failure.hpp"

namespace viscobar {

/// Ends a run that would not come to its end in any reasonable time, so that none hangs: every `look` steps, the time
/// they advanced tells how many the rest would take, and more than `most` are refused unless they become fewer fast, as
/// when a stiff contact settles. A pause of that length within a run that then goes on is far beyond any storm that a
/// bar makes: bounces that die out do so in tens.
class PaceGuard {
 public:
  explicit PaceGuard(double begin, double end, std::size_t look = 1'000'000, double most = 1e10)
      : since_(begin), end_(end), look_(look), most_(most) {}

  /// To be told every step: the time it led to and the contact changes so far. @throws StepFailure
  void step(double t, std::size_t changes) {
    if (++steps_ < look_) return;
    const double rest = static_cast<double>(look_) * ((end_ - t) / (t - since_));
    // Not a number where no time has passed at all.
    if (t < end_ && !(rest <= most_ || rest < 0.5 * rest_)) refuse(t, changes - changes_, rest);
    rest_ = rest;
    steps_ = 0;
    changes_ = changes;
    since_ = t;
  }

 private:
  [[noreturn]] void refuse(double t, std::size_t changes, double rest) const {
    const bool storm = changes > look_ / 1000;
    throw StepFailure(
        fmt::format("the last {} steps led from t = {} to {}, with {} contact changes: at that pace the end is {:.1e} "
                    "steps away; {}",
                    look_, since_, t, changes, rest, storm ? remedy::chatter : remedy::length));
  }

  double since_, end_;
  std::size_t look_;
  double most_;
  std::size_t steps_ = 0, changes_ = 0;
  double rest_ = std::numeric_limits<double>::infinity();  // at the last look
};

}  // namespace viscobar

#pragma once

#include <algorithm>
#include <chrono>
#include <utility>

namespace viscobar {

/// When checkpoints are due on the clock: so many seconds after the last one was made, or as many as it took where that
/// is longer, so that the run keeps half of the time at least.
class CheckpointClock {
 public:
  explicit CheckpointClock(double interval) : interval_(interval) {}

  bool due() const { return seconds(last_, Clock::now()) >= std::max(interval_, cost_); }

  template <class Make>
  void make(Make&& make) {
    const auto begin = Clock::now();
    std::forward<Make>(make)();
    last_ = Clock::now();
    cost_ = seconds(begin, last_);
  }

 private:
  using Clock = std::chrono::steady_clock;
  static double seconds(Clock::time_point from, Clock::time_point to) {
    return std::chrono::duration<double>(to - from).count();
  }

  double interval_, cost_ = 0.0;
  Clock::time_point last_ = Clock::now();
};

}  // namespace viscobar

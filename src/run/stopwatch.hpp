#pragma once

#include <chrono>
#include <ctime>

namespace viscobar {

/// Processor time of this thread since construction, without what ran outside(): other work on the machine does not
/// count.
class Stopwatch {
 public:
  double seconds() const { return now() - start_; }

  /// Calls `call` off the clock.
  void outside(auto&& call) {
    const double paused = now();
    call();
    start_ += now() - paused;
  }

 private:
  static double now() {
    timespec used{};
    ::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &used);
    return static_cast<double>(used.tv_sec) + 1e-9 * static_cast<double>(used.tv_nsec);
  }

  double start_ = now();
};

/// Seconds on the clock since construction, or since a time on it.
class WallClock {
 public:
  using Clock = std::chrono::steady_clock;

  WallClock() = default;
  explicit WallClock(Clock::time_point start) : start_(start) {}
  double seconds() const { return std::chrono::duration<double>(Clock::now() - start_).count(); }

 private:
  Clock::time_point start_ = Clock::now();
};

}  // namespace viscobar

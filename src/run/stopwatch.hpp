#pragma once

#include <chrono>
#include <utility>

namespace viscobar {

/// Wall time since construction, without what ran outside().
class Stopwatch {
 public:
  double seconds() const { return std::chrono::duration<double>(Clock::now() - start_).count(); }

  /// Calls `call` off the clock.
  template <class Call>
  void outside(Call&& call) {
    const auto paused = Clock::now();
    std::forward<Call>(call)();
    start_ += Clock::now() - paused;
  }

 private:
  using Clock = std::chrono::steady_clock;
  Clock::time_point start_ = Clock::now();
};

}  // namespace viscobar

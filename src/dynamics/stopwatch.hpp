#pragma once

#include <chrono>

namespace viscobar {

/// Seconds since construction, without those between pause() and resume().
class Stopwatch {
 public:
  void pause() { passed_ += Clock::now() - since_; }
  void resume() { since_ = Clock::now(); }

  /// Of a running watch.
  double seconds() const { return std::chrono::duration<double>(passed_ + (Clock::now() - since_)).count(); }

 private:
  using Clock = std::chrono::steady_clock;
  Clock::duration passed_{};
  Clock::time_point since_ = Clock::now();
};

}  // namespace viscobar

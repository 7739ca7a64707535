#pragma once

#include <chrono>

namespace viscobar {

/// Wall time of a method alone: runs from its construction, and is paused while observers work.
class Stopwatch {
 public:
  void pause() { passed_ += Clock::now() - started_; }
  void resume() { started_ = Clock::now(); }
  /// Seconds up to now; to be asked while it runs.
  double seconds() const { return std::chrono::duration<double>(passed_ + (Clock::now() - started_)).count(); }

 private:
  using Clock = std::chrono::steady_clock;
  Clock::time_point started_ = Clock::now();
  Clock::duration passed_{0};
};

}  // namespace viscobar

#pragma once

#include <chrono>
#include <cstddef>

namespace viscobar::cli {

/// A line on the terminal that says how far a run is, overwritten a few times a second once the run has taken one.
class Progress {
 public:
  explicit Progress(double end) : end_(end) {}
  ~Progress() { clear(); }
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  void operator()(double time, std::size_t steps);
  void clear();

 private:
  using Clock = std::chrono::steady_clock;
  double end_;
  Clock::time_point started_ = Clock::now(), next_ = started_ + std::chrono::seconds(1);
  bool shown_ = false;
};

/// Standard error is a terminal.
bool on_terminal();

}  // namespace viscobar::cli

#pragma once

#include <chrono>
#include <cstddef>
#include <string>
#include <string_view>

namespace viscobar::cli {

/// A line on the terminal that says what is being done, overwritten by the next.
class StatusLine {
 public:
  StatusLine() = default;
  ~StatusLine() { clear(); }
  StatusLine(const StatusLine&) = delete;
  StatusLine& operator=(const StatusLine&) = delete;

  void show(std::string_view what);
  void clear();

 private:
  bool shown_ = false;
};

/// How far a run is, on the terminal, a few times a second once the run has taken one.
class Progress {
 public:
  explicit Progress(double end) : end_(end) {}

  void operator()(double time, std::size_t steps);
  void clear() { line_.clear(); }

 private:
  using Clock = std::chrono::steady_clock;
  double end_;
  Clock::time_point started_ = Clock::now(), next_ = started_ + std::chrono::seconds(1);
  StatusLine line_;
};

/// "35 s", "2 min 05 s", "3 h 07 min"
std::string duration(double seconds);

/// Standard error is a terminal.
bool on_terminal();

}  // namespace viscobar::cli

#pragma once

#include <chrono>
#include <cstddef>
#include <string_view>

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

/// The same for a study of many runs.
class StudyProgress {
 public:
  explicit StudyProgress(std::string_view what) : what_(what) {}
  ~StudyProgress() { clear(); }
  StudyProgress(const StudyProgress&) = delete;
  StudyProgress& operator=(const StudyProgress&) = delete;

  void operator()(std::size_t done, std::size_t of);
  void clear();

 private:
  std::string_view what_;
  bool shown_ = false;
};

/// Standard error is a terminal.
bool on_terminal();

}  // namespace viscobar::cli

#pragma once

#include <atomic>
#include <cstddef>
#include <functional>
#include <future>
#include <map>
#include <optional>
#include <vector>

#include "studies/accuracy/sample.hpp"

namespace viscobar::accuracy {

/// Settings that runs differ in: J, the relative tolerance or the time step, epsilon (0: nothing is penalised), and
/// whether the initial velocity is changed by a little, or the restitution is 0.
struct Setting {
  std::size_t elements = 0;
  double fineness = 0.0;
  double epsilon = 0.0;
  bool nudged = false;
  bool stopped = false;
  auto operator<=>(const Setting&) const = default;
};

/// Runs in memory of one case with several settings, each made once and kept as a sample.
class Runs {
 public:
  /// `make` is the case of a setting; it is looked at at `times`; `peaks` of reactions are wanted or not; `threads` as
  /// in parallel_for(); `stop` may be empty.
  Runs(std::function<Case(const Setting&)> make, std::vector<double> times, bool peaks, std::size_t threads,
       std::function<bool()> stop);
  /// Ends what is begun.
  ~Runs();
  Runs(const Runs&) = delete;
  Runs& operator=(const Runs&) = delete;

  /// Makes those that are not known yet, side by side, the dearest first. @throws StudyStopped, TooLong,
  /// IntegrationError
  void make(std::vector<Setting> settings);
  /// The same beside what the caller does until finish(), on the other cores; where there are none, or no run takes a
  /// millisecond, nothing.
  void begin(std::vector<Setting> settings);
  /// Waits for what is begun. @throws as make()
  void finish();

  bool knows(const Setting& setting) const { return samples_.contains(setting); }
  const Sample& of(const Setting& setting) const { return samples_.at(setting); }
  const std::vector<double>& times() const { return times_; }
  /// Those of the case itself, neither nudged nor stopped, in the order of their settings.
  std::vector<Setting> known() const;
  /// The solution, which somebody else ran.
  void add(const Setting& setting, Sample sample) { samples_.insert_or_assign(setting, std::move(sample)); }

  /// Runs that were made, in their order.
  const std::vector<std::pair<Setting, Statistics>>& made() const { return made_; }
  /// Processor time of these runs, over the threads that shared it.
  double seconds() const { return seconds_; }
  /// Bound of seconds(); a run that would exceed it is ended.
  double most_seconds = RunLimits().seconds;

 private:
  struct Batch {
    std::vector<Setting> settings;
    std::vector<std::optional<Sample>> found;
    double seconds = 0.0;
  };
  std::vector<Setting> unknown(std::vector<Setting> settings) const;
  std::size_t long_ones(const std::vector<Setting>& settings) const;
  Batch work(std::vector<Setting> settings, std::size_t threads, double most) const;
  void keep(Batch batch);

  std::function<Case(const Setting&)> make_;
  std::vector<double> times_;
  bool peaks_;
  std::size_t threads_;
  std::function<bool()> stop_;
  std::map<Setting, Sample> samples_;
  std::vector<std::pair<Setting, Statistics>> made_;
  double seconds_ = 0.0;
  std::atomic<bool> abandoned_ = false;
  std::future<Batch> begun_;
};

}  // namespace viscobar::accuracy

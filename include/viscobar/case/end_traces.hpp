#pragma once

#include <functional>
#include <span>
#include <vector>

#include "viscobar/case/case.hpp"
#include "viscobar/run/run.hpp"

namespace viscobar {

/// u at both ends of a run, one value each a time, and its contact changes.
struct EndTraces {
  std::vector<double> left;   ///< u(0, t_k)
  std::vector<double> right;  ///< u(L, t_k)
  /// u(i L / 16, t_k), i = 1 .. 15, under a span obstacle, u on both sides of each joint of a chain that is not bonded.
  std::vector<std::vector<double>> between;
  std::vector<Event> events;  ///< contact changes in order of time
  Statistics statistics;      ///< of the run

  /// All of them, of traces `self`.
  static auto all(auto& self) {
    std::vector traces = {&self.left, &self.right};
    for (auto& trace : self.between) traces.push_back(&trace);
    return traces;
  }
};

/// Runs a sound case on the given times, without its directions; `progress` is told each step, and may stop the run.
/// @throws IntegrationError
EndTraces trace_ends(const Case& run, std::span<const double> times,
                     const std::function<RunControl(double time)>& progress = {});

/// The contact changes of a sound case alone. @throws IntegrationError
std::vector<Event> contact_changes(const Case& run);

/// max |a_i - b_i| of numbers that are as many.
double largest_difference(std::span<const double> a, std::span<const double> b);
/// The same over all traces of two runs, which share their times.
double largest_difference(const EndTraces& a, const EndTraces& b);

/// Times on [0, end] that resolve the largest difference of two runs: `uniform` intervals, and after each contact
/// change times in geometric progression from a millionth of an interval on. A bounce on the penalty lasts
/// O(sqrt(epsilon)), and the difference is largest just after it. Of many changes the hardest 400 count.
std::vector<double> comparison_times(double end, std::size_t uniform, std::span<const Event> changes);

}  // namespace viscobar

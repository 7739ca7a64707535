#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "viscobar/dynamics/bar_system.hpp"
#include "viscobar/run/run.hpp"

namespace viscobar {

/// Everything that a run told its observers.
struct RunTrace {
  std::vector<double> times, reaction_left, reaction_right, progress;
  std::vector<std::vector<double>> u, v;  ///< over all nodes, one a time
  std::vector<Event> events;
  Statistics statistics;
};

/// Runs `system` from its initial state by any method; `energy` asks for the account.
template <class Method>
RunTrace record(const BarSystem& system, std::span<const double> times, const Method& method, bool energy = true) {
  RunTrace recording;
  Observers observers;
  observers.snapshot = [&](const Snapshot& now) {
    recording.times.push_back(now.time);
    recording.u.emplace_back(now.u.begin(), now.u.end());
    recording.v.emplace_back(now.v.begin(), now.v.end());
    recording.reaction_left.push_back(now.reaction_left);
    recording.reaction_right.push_back(now.reaction_right);
  };
  observers.event = [&](const Event& event) { recording.events.push_back(event); };
  observers.progress = [&](double time) {
    recording.progress.push_back(time);
    return RunControl::go_on;
  };
  observers.energy = energy;
  recording.statistics = integrate(system, system.initial_state(), times, method, observers);
  return recording;
}

/// begin, begin + every, ..., `count` intervals.
inline std::vector<double> uniform_times(double every, std::size_t count, double begin = 0.0) {
  std::vector<double> times(count + 1);
  for (std::size_t k = 0; k <= count; ++k) times[k] = begin + static_cast<double>(k) * every;
  return times;
}

/// 0, ..., end in so many intervals.
inline std::vector<double> grid(double end, std::size_t count) {
  return uniform_times(end / static_cast<double>(count), count);
}

}  // namespace viscobar

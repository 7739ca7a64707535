#pragma once

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "viscobar/characteristics/characteristics.hpp"

namespace viscobar {

/// Record of a run by characteristics.
struct Followed {
  std::vector<double> times;
  std::vector<std::vector<double>> u, v;
  std::vector<double> reaction_left, reaction_right;
  std::vector<Event> events;
  Statistics statistics;
};

inline std::vector<double> equal_times(double end, std::size_t count) {
  std::vector<double> times;
  for (std::size_t k = 0; k <= count; ++k) times.push_back(end * static_cast<double>(k) / static_cast<double>(count));
  return times;
}

inline Followed followed(const Scene& scene, const std::vector<double>& times, std::size_t elements = 10,
                         Observers observers = {}, const std::optional<Checkpoint>& from = std::nullopt) {
  Followed run;
  observers.energy = observers.account = true;
  observers.snapshot = [&](const Snapshot& now) {
    run.times.push_back(now.time);
    run.u.emplace_back(now.u.begin(), now.u.end());
    run.v.emplace_back(now.v.begin(), now.v.end());
    run.reaction_left.push_back(now.reaction_left);
    run.reaction_right.push_back(now.reaction_right);
  };
  observers.event = [&](const Event& event) { run.events.push_back(event); };
  run.statistics = integrate(scene, Mesh{scene.bar.length, elements}, from, times, Characteristics{}, observers);
  return run;
}

/// max |u| of all nodes and times.
inline double largest(const Followed& run) {
  double size = 0.0;
  for (const auto& row : run.u)
    for (const double u : row) size = std::max(size, std::abs(u));
  return size;
}

inline double largest_energy(const EnergyAccount& energy) {
  return std::max({energy.initial, energy.final, std::abs(energy.work)});
}

}  // namespace viscobar

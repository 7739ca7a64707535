#pragma once

#include <cstddef>
#include <vector>

#include "support/run_trace.hpp"
#include "viscobar/integration/integrate.hpp"

// Scenes and runs that the tests of the exponential method share.
namespace viscobar::testing_support {

/// A few hundred steps, each with a rounding or two of numbers of order one in sums over a hundred entries.
inline constexpr double accuracy = 1e-12;

inline RunTrace record(const BarSystem& system, const std::vector<double>& times, const Penalty& penalty = {1e-4},
                       bool energy = false) {
  return viscobar::record(system, times, Exponential{penalty}, energy);
}

/// 0, ..., end in so many intervals.
inline std::vector<double> grid(double end, std::size_t count) {
  return uniform_times(end / static_cast<double>(count), count);
}

/// A bar over an obstacle on the left, its right end free.
inline Scene falling_bar(double height, double speed, double viscosity) {
  Scene scene;
  scene.bar = {1.0, 1.0, 1.0, viscosity};
  scene.left = Obstacle{height};
  scene.displacement = [](double) { return 0.0; };
  scene.velocity = [=](double) { return -speed; };
  return scene;
}

}  // namespace viscobar::testing_support

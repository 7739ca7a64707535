#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "viscobar/case/recording.hpp"

namespace viscobar {

/// u(x,t) of the bar of Dabaghi, Petrov, Pousin and Renard (examples/scenes/period-3.toml): waves of slope 1/2, in the
/// four parts that x = s and x = 1 - s make of each third of the period, s in [0, 1].
inline double period_three(double x, double t) {
  const double phase = std::fmod(t, 3.0), s = std::fmod(phase, 1.0);
  const bool near = s >= x, late = s > 1 - x;
  switch (static_cast<int>(phase)) {
    case 0: return near ? 0.5 - s / 2 : 0.5 - x / 2;
    case 1: return near == late ? (near ? (s - 1) / 2 : -s / 2) : near ? -x / 2 : (x - 1) / 2;
    default: return late ? (1 - x) / 2 : s / 2;
  }
}

/// Largest L2 norm of the error of u, in multiples of the largest of u; functions that are linear between equidistant
/// nodes.
inline double error_of_period_three(const Recording& recording) {
  const auto norm = [](const std::vector<double>& u) {
    double sum = 0.0;
    for (std::size_t j = 0; j + 1 < u.size(); ++j) sum += (u[j] * u[j] + u[j] * u[j + 1] + u[j + 1] * u[j + 1]) / 3;
    return std::sqrt(sum / static_cast<double>(u.size() - 1));
  };
  double off = 0.0, largest = 0.0;
  for (std::size_t k = 0; k < recording.times.size(); ++k) {
    std::vector<double> error, exact;
    for (std::size_t j = 0; j < recording.mesh.nodes(); ++j) {
      exact.push_back(period_three(recording.mesh.node(j), recording.times[k]));
      error.push_back(recording.displacement(k)[j] - exact.back());
    }
    off = std::max(off, norm(error)), largest = std::max(largest, norm(exact));
  }
  return off / largest;
}

}  // namespace viscobar

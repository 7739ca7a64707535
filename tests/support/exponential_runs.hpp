#pragma once

#include <vector>

#include "support/falling_bar.hpp"
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

}  // namespace viscobar::testing_support

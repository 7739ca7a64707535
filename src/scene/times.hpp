#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

namespace viscobar {

/// Times of a run no farther apart than this, 64 roundings of the larger one, are the same.
inline double rounding_of_times(double t, double end) {
  return 64.0 * std::numeric_limits<double>::epsilon() * std::max(std::abs(t), std::abs(end));
}

}  // namespace viscobar

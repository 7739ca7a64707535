#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

namespace viscobar {

/// max |a - b| / max |b|
inline double relative_error(const std::vector<double>& a, const std::vector<double>& b) {
  double largest = 0.0, difference = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    largest = std::max(largest, std::abs(b[i]));
    difference = std::max(difference, std::abs(a[i] - b[i]));
  }
  return difference / largest;
}

}  // namespace viscobar

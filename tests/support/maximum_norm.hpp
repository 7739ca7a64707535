#pragma once

#include <cmath>
#include <cstddef>
#include <limits>
#include <span>

namespace viscobar {

/// max |a_i|; NaN where one is, which is below no bound.
inline double largest(std::span<const double> a) {
  double result = 0.0;
  for (const double value : a) {
    if (std::isnan(value)) return value;
    if (std::abs(value) > result) result = std::abs(value);
  }
  return result;
}

/// max |a_i - b_i|; NaN where one is, infinite where the lengths differ.
inline double distance(std::span<const double> a, std::span<const double> b) {
  if (a.size() != b.size()) return std::numeric_limits<double>::infinity();
  double result = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    const double difference = std::abs(a[i] - b[i]);
    if (std::isnan(difference)) return difference;
    if (difference > result) result = difference;
  }
  return result;
}

/// max |a - b| / max |b|
inline double relative_error(std::span<const double> a, std::span<const double> b) {
  return distance(a, b) / largest(b);
}

}  // namespace viscobar

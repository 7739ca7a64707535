#pragma once

#include <optional>
#include <span>

namespace viscobar {

/// Slope p of y ~ C x^p by least squares on logarithms, with its standard error (from the scatter of the points about
/// the line; 0 for two points, where there is none).
struct ObservedOrder {
  double order = 0.0;           ///< p
  double standard_error = 0.0;  ///< of p
};

/// Absent for fewer than two usable points (both coordinates positive and finite).
std::optional<ObservedOrder> observed_order(std::span<const double> x, std::span<const double> y);

}  // namespace viscobar

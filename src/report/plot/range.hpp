#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <string>

#include "report/plot/axis.hpp"
#include "report/plot/thinning.hpp"

namespace viscobar::plot {

/// Least and greatest of what it was given.
struct Range {
  double low = std::numeric_limits<double>::infinity(), high = -low;

  void add(double value) {
    if (!std::isfinite(value)) return;
    low = std::min(low, value);
    high = std::max(high, value);
  }
  void add(std::span<const Point> points) {
    for (const Point& point : points) add(point.y);
  }
  /// Takes an obstacle in unless that would squeeze the rest into less than half of the picture.
  bool reach(double level) {
    const double size = std::max(high - low, 1e-3 * std::max(std::abs(high), std::abs(low)));
    if (level < low - size || level > high + size) return false;
    add(level);
    return true;
  }
  Axis axis(std::string label) const {
    return low <= high ? fitted(std::move(label), low, high) : Axis{std::move(label)};
  }
  /// A logarithmic one, of positive values; `margin` makes room for marks at either end.
  Axis decades(std::string label, double margin = 1.0) const {
    if (!(low <= high)) return {std::move(label), 0.1, 1.0, Scale::logarithmic};
    return fitted_decades(std::move(label), low / margin, high * margin);
  }
};

}  // namespace viscobar::plot

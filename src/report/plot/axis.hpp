#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "report/plot/thinning.hpp"

namespace viscobar::plot {

enum class Scale { linear, logarithmic };

struct Axis {
  std::string label;
  double low = 0.0, high = 1.0;
  Scale scale = Scale::linear;
  bool bare = false;                   ///< without ticks; `low` may then be above `high`
  std::string link = {};               ///< axes of the same name are moved, zoomed and pointed at together on a page
  std::vector<std::string> rows = {};  ///< of a bare one from -1/2 up: what the values 0, 1, ... are, for the page

  /// Place of a value, 0 at `low` and 1 at `high`.
  double position(double value) const;
  /// Significant digits that tell values apart which lie 1 / 10^digits of the axis from each other.
  int significant_digits(int digits) const;
};

/// A linear axis over [low, high] and a margin of 5 % (an interval around the value where both are the same).
Axis fitted(std::string label, double low, double high);
/// A logarithmic axis over whole decades that hold the positive values low <= high.
Axis fitted_decades(std::string label, double low, double high);

struct Range {
  double low = std::numeric_limits<double>::infinity(), high = -low;

  void add(double value) {
    if (!std::isfinite(value)) return;
    low = std::min(low, value);
    high = std::max(high, value);
  }
  void add(std::span<const double> values) {
    for (const double value : values) add(value);
  }
  void add(std::span<const Point> points) {
    for (const Point& point : points) add(point.y);
  }
  /// Largest size of the values; 0 without any.
  double largest() const { return low <= high ? std::max(std::abs(low), std::abs(high)) : 0.0; }
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
  /// A logarithmic one, of positive values, with room for marks at either end, beyond whole decades where they lie at
  /// one.
  Axis decades(std::string label) const {
    constexpr double margin = 1.3;
    if (!(low <= high)) return {std::move(label), 0.1, 1.0, Scale::logarithmic};
    Axis axis = fitted_decades(std::move(label), low, high);
    axis.low = std::min(axis.low, low / margin);
    axis.high = std::max(axis.high, high * margin);
    return axis;
  }
};

struct Tick {
  double value;
  std::string label;  ///< SVG text; empty for a minor tick
};

/// Ticks at multiples of 1, 2 or 5 times a power of ten (linear), or at decades with their multiples as minor ticks.
/// Linear labels of very large or small numbers share a factor 10^exponent, returned for the axis label (0: none).
struct Ticks {
  std::vector<Tick> ticks;
  int exponent = 0;
};
Ticks ticks(const Axis& axis, int about);

}  // namespace viscobar::plot

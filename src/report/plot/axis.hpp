#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace viscobar::plot {

enum class Scale { linear, logarithmic };

struct Axis {
  std::string label;
  double low = 0.0, high = 1.0;
  Scale scale = Scale::linear;
  bool bare = false;      ///< without ticks; `low` may then be above `high`
  std::string link = {};  ///< axes of the same name are moved, zoomed and pointed at together on a page

  /// Place of a value, 0 at `low` and 1 at `high`.
  double position(double value) const;
  /// Significant digits that tell values apart which lie 1 / 10^digits of the axis from each other.
  int significant_digits(int digits) const;
};

/// A linear axis over [low, high] and a margin of 5 % (an interval around the value where both are the same).
Axis fitted(std::string label, double low, double high);
/// A logarithmic axis over whole decades that hold the positive values low <= high.
Axis fitted_decades(std::string label, double low, double high);

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

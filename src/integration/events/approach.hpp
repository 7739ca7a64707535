#pragma once

#include <algorithm>
#include <array>
#include <cmath>

#include "scene/times.hpp"

namespace viscobar {

/// True if a positive f may come down to `floor` in [a, b]. A parabola through three of five values bounds it, with
/// four times what the other two are off as the margin; where that decides nothing, halves do.
template <class Function>
bool may_reach(Function&& f, double floor, double a, double b, int halvings = 12) {
  std::array<double, 5> v;
  for (std::size_t k = 0; k < v.size(); ++k) {
    v[k] = f(a + (b - a) * static_cast<double>(k) / 4.0);
    if (!(v[k] > floor)) return true;
  }
  const double control = 2.0 * v[2] - (v[0] + v[4]) / 2.0;  // the middle coefficient of Bernstein's
  const auto parabola = [&](double s) {
    return (1.0 - s) * (1.0 - s) * v[0] + 2.0 * s * (1.0 - s) * control + s * s * v[4];
  };
  const double off = std::max(std::abs(v[1] - parabola(0.25)), std::abs(v[3] - parabola(0.75)));
  if (std::min({v[0], control, v[4]}) - 4.0 * off > floor) return false;
  const double middle = a + (b - a) / 2.0;
  return halvings == 0 || may_reach(f, floor, a, middle, halvings - 1) || may_reach(f, floor, middle, b, halvings - 1);
}

/// The same, of a part of a run whose whole has that length: what lasts a 256th of it is seen in a long step, too, and
/// between the breaks and pulses of a motion that f has, what is shorter.
template <class Function>
bool may_reach_within(double whole, Function&& f, const NextBreak& next, double floor, double a, double b) {
  const double rounding = rounding_of_times(a, b);
  for (double to = b; a < b; a = to) {
    to = next ? next(a + rounding, b).value_or(b) : b;
    const double pieces = std::max(1.0, std::ceil(64.0 * (to - a) / whole));
    for (double k = 0.0; k < pieces; ++k)
      if (may_reach(f, floor, a + (to - a) * k / pieces, a + (to - a) * (k + 1.0) / pieces)) return true;
  }
  return false;
}

}  // namespace viscobar

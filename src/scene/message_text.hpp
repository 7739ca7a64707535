#pragma once

#include <fmt/format.h>

#include <cmath>
#include <string>

#include "viscobar/scene/scene.hpp"

namespace viscobar {

/// A number as messages show it: not a number is "nan", whatever sign the processor gives it.
inline double printable(double value) { return std::isnan(value) ? std::abs(value) : value; }

/// The bound that a displacement beyond the obstacle has passed, such as "< -gap = -0.1".
inline std::string bound_text(const Obstacle& obstacle, double u) {
  const bool above = obstacle.side == Side::above || (obstacle.side == Side::both && u > 0.0);
  return above ? fmt::format("> gap = {}", obstacle.gap) : fmt::format("< -gap = {}", -obstacle.gap);
}

}  // namespace viscobar

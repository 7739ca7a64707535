#pragma once

#include <fmt/format.h>

#include <string>

#include "viscobar/dynamics/bar_system.hpp"

namespace viscobar {

/// Breaks and pulses of the motion of a contact's obstacle, see EndMotion; empty: it has none.
inline const NextBreak& breaks_of_gap(const BarSystem& system, const Contact& contact) {
  return system.inputs()[contact.where == Where::right].motion->breaks;
}

/// Message on an obstacle that jumps into the bar at t.
inline std::string into_the_bar(const Contact& contact, double t) {
  return fmt::format(
      "the obstacle at the {} end jumps into the bar at t = {}: no bar follows at once, so let it move there in a time "
      "that the mesh resolves, such as gap = \"1 - 0.5*min(max((t-{})/0.01, 0), 1)\"",
      contact.where == Where::right ? "right" : "left", t, t);
}

}  // namespace viscobar

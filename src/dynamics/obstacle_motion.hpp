#pragma once

#include <fmt/format.h>

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "dynamics/contacts.hpp"
#include "viscobar/dynamics/load_error.hpp"

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

/// Closed contacts that a jump of their obstacles at t leaves open; u are displacements behind it, in a frame that
/// follows it, and at most `largest`. @throws LoadError where an obstacle jumps into the bar
inline std::vector<std::size_t> left_by_jump(const Contacts& contacts, const FrameJump& jump, double t,
                                             std::span<const double> u, double largest) {
  std::vector<std::size_t> left;
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    const Contact& contact = contacts[i];
    const double towards = contact.sign * contacts.bar().frame().lift_at(contact, jump.displacement);
    const double clear = contacts.clearance(i, u);
    if (towards == 0.0 || (clear >= -contacts[i].clearance_rounding(largest) && !contacts.closed(i))) continue;
    if (towards > 0.0) throw LoadError(t, into_the_bar(contact, t));
    if (clear > 0.0) left.push_back(i);
  }
  return left;
}

}  // namespace viscobar

#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <span>
#include <utility>
#include <variant>

#include "run/parts.hpp"
#include "viscobar/dynamics/bar_system.hpp"

namespace viscobar {

/// True if a node is at an obstacle that moves, or beyond.
inline bool touches_moving(const BarSystem& system, double t, std::span<const double> u) {
  return std::ranges::any_of(system.contacts(), [&](const Contact& one) {
    return system.frame().moves(one) &&
           one.sign * u[one.unknown] + system.frame().gap(one, t) <=
               32.0 * std::numeric_limits<double>::epsilon() * (one.gap + std::abs(u[one.unknown]));
  });
}

/// A run of a bar in parts, `part(system, start)` being one: the system is the one in the frame that start is in. Where
/// the bar touches an obstacle that moves from the start on, that is the one that follows it.
template <class Part>
Statistics run_in_parts(const BarSystem& system, StartingPoint start, std::span<const double> times,
                        const Observers& observers, Part&& part) {
  require_times(times);
  std::optional<BarSystem> following;
  if (auto* state = std::get_if<State>(&start); state && touches_moving(system, times.front(), state->u)) {
    following.emplace(system.following());
    system.frame().change(following->frame(), times.front(), state->u, state->v);
  }
  return run_in_parts(start, times, observers, [&](const StartingPoint& from) {
    const auto* checkpoint = std::get_if<Checkpoint>(&from);
    if (checkpoint && checkpoint->frame != Checkpoint::Frame::resting && !following)
      following.emplace(system.following());
    return part(following ? *following : system, from);
  });
}

/// Frame of the checkpoints of a run in that system.
inline Checkpoint::Frame frame_of(const BarSystem& system) {
  return system.frame().follows() ? Checkpoint::Frame::following : Checkpoint::Frame::resting;
}

}  // namespace viscobar

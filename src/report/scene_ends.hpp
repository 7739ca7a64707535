#pragma once

#include <array>
#include <optional>
#include <string_view>
#include <variant>
#include <vector>

#include "run/contact_places.hpp"

namespace viscobar {

/// A surface of an obstacle: u lies above it, or below it where the obstacle is above.
struct ObstacleLevel {
  double u;
  bool above;
};

/// One, or the two of a slit; none without an obstacle.
inline std::vector<ObstacleLevel> levels_of(const Obstacle* obstacle) {
  std::vector<ObstacleLevel> levels;
  if (!obstacle) return levels;
  if (obstacle->bounds(Side::below)) levels.push_back({obstacle->gap == 0.0 ? 0.0 : -obstacle->gap, false});
  if (obstacle->bounds(Side::above)) levels.push_back({obstacle->gap, true});
  return levels;
}
inline std::vector<ObstacleLevel> levels_of(const std::optional<Obstacle>& span) {
  return levels_of(span ? &*span : nullptr);
}

/// An end of a scene, and what it is given.
struct SceneEnd {
  std::string_view name;  ///< left or right
  double x;               ///< where it is at rest
  const EndCondition& condition;
  const EndInput& input;

  ContactPlace place() const { return {x > 0.0 ? Where::right : Where::left}; }
  const Obstacle* obstacle() const { return std::get_if<Obstacle>(&condition); }
  /// Where its obstacle is at those times, if that moves; nothing of one that does not.
  std::vector<double> surface(const std::vector<double>& times) const {
    std::vector<double> places;
    if (!obstacle() || !input.motion) return places;
    const double at_rest = obstacle()->side == Side::above ? obstacle()->gap : -obstacle()->gap;
    for (const double t : times) places.push_back(at_rest + input.motion->displacement(t));
    return places;
  }
};

inline std::array<SceneEnd, 2> ends_of(const Scene& scene) {
  return {SceneEnd{"left", 0.0, scene.left, scene.left_input},
          SceneEnd{"right", scene.bar.length, scene.right, scene.right_input}};
}

}  // namespace viscobar

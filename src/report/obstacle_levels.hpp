#pragma once

#include <vector>

#include "viscobar/scene/scene.hpp"

namespace viscobar {

/// A surface of an obstacle: u lies above it, or below it where the obstacle is above.
struct ObstacleLevel {
  double u;
  bool above;

  /// Whether a displacement touches it, up to a slack.
  bool touched(double at, double slack) const { return above ? at >= u - slack : at <= u + slack; }
};

/// Where the obstacle of an end is at t.
inline double surface_at(const Obstacle& obstacle, const EndInput& input, double t) {
  return (obstacle.side == Side::above ? obstacle.gap : -obstacle.gap) +
         (input.motion ? input.motion->displacement(t) : 0.0);
}

/// One, or the two of a slit; none without an obstacle.
inline std::vector<ObstacleLevel> levels_of(const Obstacle* obstacle) {
  std::vector<ObstacleLevel> levels;
  if (!obstacle) return levels;
  if (obstacle->bounds(Side::below)) levels.push_back({obstacle->gap == 0.0 ? 0.0 : -obstacle->gap, false});
  if (obstacle->bounds(Side::above)) levels.push_back({obstacle->gap, true});
  return levels;
}

}  // namespace viscobar

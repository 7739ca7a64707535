#pragma once

#include "viscobar/scene/scene.hpp"

namespace viscobar {

/// A bar over an obstacle on the left, its right end free, unstrained and thrown at it.
inline Scene falling_bar(double height, double speed, double viscosity) {
  Scene scene;
  scene.bar = {1.0, 1.0, 1.0, viscosity};
  scene.left = Obstacle{height};
  scene.displacement = [](double) { return 0.0; };
  scene.velocity = [=](double) { return -speed; };
  return scene;
}

}  // namespace viscobar

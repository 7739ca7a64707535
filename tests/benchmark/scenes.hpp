#pragma once

#include "viscobar/scene/scene.hpp"

namespace viscobar {

/// A bar thrown down on both obstacles: [0,1], alpha = c = 0.1, u_0 = x(1-x), u_1 = -u_0, f = -1.
inline Scene throw_scene(double viscosity = 0.1) {
  Scene scene;
  scene.bar.viscosity = viscosity;
  scene.left = scene.right = Obstacle{0.1};
  scene.displacement = [](double x) { return x * (1 - x); };
  scene.velocity = [](double x) { return -x * (1 - x); };
  scene.load = SteadyLoad{[](double) { return -1.0; }};
  return scene;
}

/// A straight bar under its weight, at rest at first, that both obstacles carry from the start (gap 0) or that falls.
inline Scene weight_scene(double viscosity, double gap) {
  Scene scene;
  scene.bar.viscosity = viscosity;
  scene.left = scene.right = Obstacle{gap};
  scene.displacement = scene.velocity = [](double) { return 0.0; };
  scene.load = SteadyLoad{[](double) { return -1.0; }};
  return scene;
}

}  // namespace viscobar

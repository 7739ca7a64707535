#pragma once

#include <cmath>

#include "viscobar/case/case.hpp"

namespace viscobar {

/// A bar without a method that is thrown at two obstacles and pressed to the left: it bounces, chatters and comes to
/// rest, more than once.
inline Case pressed_bar(std::size_t elements, Mass mass, double length, double left, double right, double end) {
  Case run;
  run.scene.bar = {length, 1.0, 0.2, 0.001};
  run.scene.left = Obstacle{left};
  run.scene.right = Obstacle{right};
  run.scene.displacement = [](double) { return 0.0; };
  run.scene.load = SteadyLoad{[](double) { return -0.6; }};
  run.elements = elements;
  run.mass = mass;
  run.end = end;
  run.output_every = 0.05;
  return run;
}

/// Pressed bar of four elements, consistent mass, T = 20.
inline Case pressed_bar_of_four() {
  Case run = pressed_bar(4, Mass::consistent, 2.0, 0.3, 0.2, 20.0);
  run.scene.velocity = [](double x) { return -0.5 + 0.045 * std::cos(3.0 * x); };
  return run;
}

/// Pressed bar of two elements, lumped mass, T = 10; it begins on its right obstacle.
inline Case pressed_bar_of_two() {
  Case run = pressed_bar(2, Mass::lumped, 0.5, 0.45, 0.0, 10.0);
  run.scene.velocity = [](double x) { return 0.35 + 0.1 * std::cos(3.0 * x); };
  return run;
}

}  // namespace viscobar

#pragma once

#include "viscobar/case/case.hpp"

namespace viscobar {

/// An undamped bar that bounces under its weight for ever: some 700 changes until t = 40, of which rounding decides the
/// later ones.
inline Case bouncing_bar(double end) {
  Case run;
  run.scene.left = run.scene.right = Obstacle{0.01};
  run.scene.displacement = [](double x) { return 0.003 * x; };
  run.scene.velocity = [](double) { return -1.0; };
  run.scene.load = SteadyLoad{[](double) { return -1.0; }};
  run.elements = 8;
  run.mass = Mass::consistent;
  run.epsilon = 1e-4;
  run.end = end;
  return run;
}

}  // namespace viscobar

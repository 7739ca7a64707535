#pragma once

#include "viscobar/case/case.hpp"

namespace viscobar {

/// The bar of the penalty-limit studies, examples/scenes/chatter.toml: [0,1], 27 elements of the consistent mass, both
/// ends an obstacle at 0.1, u_0 = x (1 - x), u_1 = -u_0, T = 6.
inline Case paper_throw(double viscosity) {
  Case run;
  run.scene.bar.viscosity = viscosity;
  run.scene.left = run.scene.right = Obstacle{0.1};
  run.scene.displacement = [](double x) { return x * (1.0 - x); };
  run.scene.velocity = [](double x) { return -x * (1.0 - x); };
  run.elements = 27;
  run.mass = Mass::consistent;
  run.epsilon = 1e-3;
  run.end = run.output_every = 6.0;
  return run;
}

}  // namespace viscobar

#pragma once

#include <cmath>
#include <string>
#include <vector>

#include "input/formula.hpp"
#include "viscobar/case/case.hpp"

namespace viscobar::testing_checkpoint {

struct NamedCase {
  std::string name;
  Case run;
};

/// One scene of each kind that a method may treat in its own way: with and without viscosity, load, mass at the contact
/// nodes, dashpots, a span obstacle, a fixed end, a load that jumps; in all of them contacts close and open.
inline std::vector<NamedCase> kinds_of_scenes() {
  Case two_ends;
  two_ends.scene.bar.viscosity = 0.05;
  two_ends.scene.left = two_ends.scene.right = Obstacle{0.1};
  two_ends.scene.displacement = [](double x) { return x * (1.1 - x); };
  two_ends.scene.velocity = [](double x) { return -0.8 - 0.4 * x; };
  two_ends.scene.load =
      SeparableLoad{[](double x) { return 0.5 + std::cos(2 * x); }, [](double t) { return -std::sin(1.4 * t); }};
  two_ends.elements = 12;
  two_ends.epsilon = 1e-3;
  two_ends.step = 1.0 / 256;
  two_ends.end = 2.5;
  two_ends.output_every = 0.0625;

  Case undamped = two_ends;
  undamped.scene.bar.viscosity = 0.0;
  undamped.scene.load = GeneralLoad{[](double x, double t) { return 0.3 * x * std::sin(9 * t + x); }};
  undamped.mass = Mass::lumped;

  Case massless = two_ends;
  massless.mass = Mass::redistributed;
  massless.elements = 40;  // more than the sixteen stretches of a scheme

  Case algebraic = undamped;
  algebraic.mass = Mass::redistributed;

  Case dashpots = two_ends;
  dashpots.restitution = 0.3;
  dashpots.scene.load = SteadyLoad{[](double) { return -1.0; }};
  dashpots.scene.right = Fixed{};

  Case elastic = dashpots;  // the schemes gain at their impacts
  elastic.restitution = 1.0;
  elastic.step = 1.0 / 32;

  Case moreau = elastic;
  moreau.impact = Impact::moreau;

  Case span = two_ends;
  span.scene.left = span.scene.right = Free{};
  span.scene.span = Obstacle{0.05};
  span.epsilon = 1e-2;

  // One of the breaks is where the tests make a checkpoint; the front breaks at each node at another time.
  Case switching = two_ends;
  const Formula load("(t > 0.46 ? -1 : 1)*abs(sin(5*t)) - (x < 0.6*t)", "xt");
  switching.scene.load = GeneralLoad{load.of_x_t(), load.breaks(), load.breaks_at()};
  switching.mass = Mass::redistributed;

  return {{"two ends", two_ends},   {"undamped", undamped}, {"massless", massless},
          {"algebraic", algebraic}, {"dashpots", dashpots}, {"elastic", elastic},
          {"moreau", moreau},       {"span", span},         {"switching", switching}};
}

}  // namespace viscobar::testing_checkpoint

#pragma once

#include "scene/end_kinds.hpp"
#include "viscobar/case/case.hpp"

namespace viscobar {

/// True if the mass "redistributed" takes mass from a contact node of the case, which has another one now.
inline bool may_be_massless(Case run) {
  if (bare_obstacles(run.scene) == 0 || resolve(run).mass == Mass::redistributed) return false;
  run.mass = Mass::redistributed;
  return sound(run);
}

/// True if the mass of the mesh leaves none to a node that a penalty throws back: a node on which something is mounted
/// keeps its own. One at a stop with a law has one law by every method.
inline bool are_massless(const Scene& scene, Mass mass) {
  const auto keeps = [](const EndCondition& end, const EndInput& input) {
    return is_obstacle(end) && !is_bare_obstacle(end, input) && !input.stop;
  };
  return mass == Mass::redistributed && !keeps(scene.left, scene.left_input) && !keeps(scene.right, scene.right_input);
}

}  // namespace viscobar

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

}  // namespace viscobar

#pragma once

#include "viscobar/case/case.hpp"

namespace viscobar {

/// True if the mass "redistributed" fits the case: nothing at a contact wants the mass of its node.
inline bool may_be_massless(Case run) {
  run.mass = Mass::redistributed;
  return sound(run);
}

}  // namespace viscobar

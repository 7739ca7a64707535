#pragma once

#include <limits>

#include "dynamics/penalised_system.hpp"

namespace viscobar {

/// How long a step may be: a load that varies, and vanishes wherever a long step looks, could hide a pulse in between.
/// What lasts for a 64th of the run or longer is seen.
inline double longest_step(const PenalisedSystem& system, double duration) {
  return system.load_varies() ? duration / 64.0 : std::numeric_limits<double>::infinity();
}

}  // namespace viscobar

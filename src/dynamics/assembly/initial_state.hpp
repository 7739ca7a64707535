#pragma once

#include "viscobar/discretisation/tridiagonal.hpp"
#include "viscobar/dynamics/bar_system.hpp"

namespace viscobar {

/// See BarSystem::initial_state(). The inertia of the system does not have the masses of its ends here, on which the
/// data do not depend; `whole` is the same over all nodes.
State initial_state(const Scene& scene, const BarSystem& system, const BandedMatrix& whole);

}  // namespace viscobar

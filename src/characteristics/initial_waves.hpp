#pragma once

#include "characteristics/piecewise.hpp"
#include "viscobar/scene/scene.hpp"

namespace viscobar::characteristics {

/// The data of a bar at the start, over places in lengths of it.
struct InitialData {
  Piecewise displacement, velocity;
  Piecewise strain_velocity;  ///< c u_0'
  double displacement_error = 0.0, velocity_error = 0.0;
};

/// @throws std::invalid_argument where they are not finite, or the displacement jumps
InitialData initial_data(const Scene& scene);

}  // namespace viscobar::characteristics

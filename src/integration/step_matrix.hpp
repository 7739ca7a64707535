#pragma once

#include <stdexcept>

#include "dynamics/lost_inertia.hpp"
#include "dynamics/penalised_system.hpp"
#include "run/step_failure.hpp"

namespace viscobar {

/// The matrix D(m, c, k) of an implicit step, and its factor. @throws StepFailure where no digit of the inertia is left
inline void factorise_step(const PenalisedSystem& system, double m, double c, double k, BandedMatrix& matrix,
                           TridiagonalFactor& factor) {
  system.dynamic_stiffness(m, c, k, matrix);
  try {
    factor.factorise(matrix);
  } catch (const std::domain_error&) {
    throw StepFailure(Failure::inertia, lost_inertia(system.bar(), m, c, k));
  }
}

}  // namespace viscobar

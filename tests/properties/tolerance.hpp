#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "support/absolute_tolerance.hpp"
#include "support/maximum_norm.hpp"
#include "viscobar/case/recording.hpp"

namespace viscobar::properties {

/// Error of the displacement that docs/methods.md promises: 100 (relative max|u| + absolute) for an adaptive method.
/// The others are exact but for rounding: of at most 1e4 steps, each a solve on up to 25 nodes at a condition of up to
/// 1e8 (epsilon down to 2^-20 beside h^2 of 1/600), of which the largest errors do not all add up: 1e-10 max|u|.
inline double displacement_error(const Case& run, double u) {
  return is_adaptive(run.method) ? 100.0 * (run.tolerance.relative * u + absolute_tolerance(run)) : 1e-10 * u;
}

/// Fastest oscillation that an error of the displacement becomes a velocity by: that of a contact node on its spring
/// (its effective mass is at least rho h / 6), or of the mesh.
inline double fastest_frequency(const Case& run) {
  const Bar& bar = run.scene.bar;
  const double h = run.mesh().spacing();
  const double spring = run.epsilon && is_penalised(run.method) ? 6.0 / (*run.epsilon * bar.density * h) : 0.0;
  return std::sqrt(spring + 12.0 * bar.modulus / (bar.density * h * h));
}

}  // namespace viscobar::properties

#pragma once

#include <span>

#include "viscobar/dynamics/bar_system.hpp"
#include "viscobar/dynamics/run.hpp"

namespace viscobar {

/// How u^1 is found from u_0 and u_1.
enum class Start {
  first_order,  ///< u^1 = u^0 + dt u_1, the paper's
  second_order  ///< with the Taylor term dt^2/2 u'' of the semi-discrete system
};

/// The paper's fully discrete scheme (2.8), with the product of the system's mass; on a lumped or paper mass it is
/// the finite difference scheme (3.25). Constraint exact, no penalty.
struct FullyDiscrete {
  double step = 0.0;                 ///< dt > 0
  Start start = Start::first_order;  ///< how u^1 is found
  double restitution = 0.0;          ///< e: the constraint holds for (u^{n+1} + e u^{n-1}) / (1 + e)
};

/// Runs the scheme from `start` at times.front() to times.back(); between steps the output is interpolated linearly,
/// as in the paper. @throws IntegrationError
Statistics integrate(const BarSystem& system, const StartingPoint& start, std::span<const double> times,
                     const FullyDiscrete& scheme, const Observers& observers);

}  // namespace viscobar

#pragma once

#include <span>

#include "viscobar/dynamics/bar_system.hpp"
#include "viscobar/run/run.hpp"

namespace viscobar {

/// How u^1 is found from u_0 and u_1.
enum class Start {
  first_order,  ///< u^1 = u^0 + dt u_1, the paper's
  second_order  ///< with the Taylor term dt^2/2 u'' of the semi-discrete system
};

/// The law of impact: the bound that a contact with restitution e keeps. The reaction lambda^n >= 0 acts where the
/// bound holds with equality. g = u + gap at the contact's node, p^{n+1/2} = (u^{n+1} - u^n) / dt.
enum class Impact {
  /// g^{n+1} >= -e g^{n-1}: at e = 0 the paper's constraint. With e > 0 an impact may give energy, see
  /// EnergyAccount::growth.
  paoli_schatzman,
  /// Where g^n <= 0: p^{n+1/2} >= -e p^{n-1/2} for a node that moves in, >= -p^{n-1/2} for one that moves out.
  /// Never gives energy. A node is stopped in the step after the one that passed the obstacle.
  moreau
};

/// The paper's fully discrete scheme (2.8), with the product of the system's mass; on a lumped or paper mass it is
/// the finite difference scheme (3.25). Constraint exact, no penalty.
struct FullyDiscrete {
  double step = 0.0;                        ///< dt > 0
  Start start = Start::first_order;         ///< how u^1 is found
  double restitution = 0.0;                 ///< e, 0 to 1
  Impact impact = Impact::paoli_schatzman;  ///< the law of impact
};

/// Runs the scheme from `start` at times.front() to times.back(); between steps the output is interpolated linearly,
/// as in the paper. @throws IntegrationError
Statistics integrate(const BarSystem& system, const StartingPoint& start, std::span<const double> times,
                     const FullyDiscrete& scheme, const Observers& observers);

}  // namespace viscobar

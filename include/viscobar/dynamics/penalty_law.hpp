#pragma once

#include <optional>

namespace viscobar {

/// Kelvin-Voigt response of one contact node to its penetration d > 0:
///
///     R(d, d') = k d + b d'  while d > 0,  0 otherwise,      energy k d^2 / 2,  dissipation b d'^2.
///
/// The paper's penalty is k = weight / epsilon, b = 0 [Petrov 2010, section 1]. A dashpot
/// b = 2 zeta sqrt(k m), m the effective mass of the node, gives the node a restitution
/// exp(-pi zeta / sqrt(1 - zeta^2)), 0 at zeta = 1. A massless node has b = 0.
struct PenaltyLaw {
  double stiffness = 0.0;  ///< k >= 0, force per penetration
  double damping = 0.0;    ///< b >= 0, force per rate of penetration

  /// R(d, d'), 0 for d <= 0.
  double reaction(double penetration, double rate) const {
    return penetration > 0.0 ? stiffness * penetration + damping * rate : 0.0;
  }
  /// Stored in the spring, k d^2 / 2.
  double energy(double penetration) const {
    return penetration > 0.0 ? 0.5 * stiffness * penetration * penetration : 0.0;
  }
};

/// The paper's parameters of the response: reaction = penetration / epsilon, and the restitution e of a node in
/// [0, 1] that the dashpot realises (1: no dashpot).
struct Penalty {
  std::optional<double> epsilon{};  ///< displacement per stress, > 0; 0: rigid, see Rigid; absent: no contact
  double restitution = 1.0;         ///< e
};

/// zeta with exp(-pi zeta / sqrt(1 - zeta^2)) = restitution: -ln e / sqrt(pi^2 + ln^2 e), and 1 for e = 0.
double damping_ratio(double restitution);

/// Law of a contact node of the given weight (1 for an end, the trapezoidal weight for a span obstacle) and
/// effective mass m = 1 / (e . (rho M)^{-1} e), 0 for a massless node.
PenaltyLaw penalty_law(const Penalty& penalty, double weight, double effective_mass);

}  // namespace viscobar

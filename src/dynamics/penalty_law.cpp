#include "viscobar/dynamics/penalty_law.hpp"

#include <numbers>

namespace viscobar {

double damping_ratio(double restitution) {
  if (restitution <= 0.0) return 1.0;
  const double logarithm = std::log(restitution);
  return -logarithm / std::hypot(std::numbers::pi, logarithm);
}

PenaltyLaw penalty_law(const Penalty& penalty, double weight, double effective_mass) {
  const double stiffness = weight / penalty.epsilon;
  return {stiffness, 2.0 * damping_ratio(penalty.restitution) * std::sqrt(stiffness * effective_mass)};
}

}  // namespace viscobar

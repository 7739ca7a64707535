#include "viscobar/dynamics/penalty_law.hpp"

#include <cmath>
#include <numbers>
#include <stdexcept>

namespace viscobar {

double damping_ratio(double restitution) {
  if (restitution <= 0.0) return 1.0;
  const double logarithm = std::log(restitution);
  return std::abs(logarithm) / std::hypot(std::numbers::pi, logarithm);
}

PenaltyLaw penalty_law(const Penalty& penalty, double weight, double effective_mass) {
  if (!penalty.epsilon) throw std::invalid_argument("the penalty of a contact has no epsilon");
  const double stiffness = weight / *penalty.epsilon;
  const double ratio = damping_ratio(penalty.restitution);
  if (ratio == 0.0 || effective_mass == 0.0) return {stiffness, 0.0};
  return {stiffness, 2.0 * ratio * std::sqrt(stiffness * effective_mass)};
}

}  // namespace viscobar

#include "case/regime.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "case/method_table.hpp"

namespace viscobar {

namespace {

// Peak of the node's own oscillator, in units of V / omega.
double node_peak(double zeta) {
  // Beyond critical damping the node creeps up to the force of its neighbour's dashpot.
  if (zeta >= 1.0) return 2.0 * zeta;
  const double angle = std::numbers::pi - std::acos(zeta);
  return 2.0 * zeta + std::exp(-zeta * angle / std::sqrt(1.0 - zeta * zeta));
}

double viscous_ratio(const Bar& bar, double spacing, double effective_mass, double stiffness) {
  return bar.viscosity / spacing / (2.0 * std::sqrt(stiffness * effective_mass));
}

}  // namespace

std::string stiffer_advice(const Case& run) {
  Case chosen = run;
  chosen.epsilon.reset();
  return fmt::format(
      "contact.epsilon = {:.3g} is {:.2g} of {}, at which the spring gives way as the bar does: take {:.2g}, or leave "
      "it out (--set contact.epsilon=)",
      effective_epsilon(run), effective_epsilon(run) / natural_epsilon(run.scene), natural_epsilon_words(run.scene),
      effective_epsilon(chosen));
}

ImpactPrediction predict_impact(const Bar& bar, double spacing, double effective_mass, double epsilon, double speed) {
  const double rho = bar.density, eta = bar.viscosity, h = spacing;
  const bool resolved = epsilon * eta * eta > rho * h * h * h || epsilon * bar.modulus > h;
  const double elastic = epsilon * std::sqrt(rho * bar.modulus);
  // cbrt(epsilon^2 rho eta); no root is taken of a number with a unit, whose digits would depend on that.
  const double viscous = 0.858 * elastic * std::cbrt(eta / (bar.modulus * elastic));
  using Layer = ImpactPrediction::Layer;
  // All the energy of the bar in the spring.
  const double whole = std::sqrt(rho * bar.length * epsilon);
  if (whole < std::max(viscous, elastic) && epsilon * bar.modulus > bar.length)
    return {speed, speed * whole, Layer::bar};
  if (resolved)
    return viscous > elastic ? ImpactPrediction{speed, speed * viscous, Layer::viscous}
                             : ImpactPrediction{speed, speed * elastic, Layer::elastic};
  if (effective_mass == 0.0) {
    // Nothing stops alone: what resists is the dashpot or the wave behind, whichever is stiffer.
    const double dashpot = epsilon * eta / h;
    return dashpot > elastic ? ImpactPrediction{speed, speed * dashpot, Layer::node}
                             : ImpactPrediction{speed, speed * elastic, Layer::elastic};
  }
  const double zeta = viscous_ratio(bar, h, effective_mass, 1.0 / epsilon);
  return {speed, speed * std::sqrt(effective_mass * epsilon) * node_peak(zeta), Layer::node};
}

std::vector<ContactRegime> contact_regimes(const Case& run, const BarSystem& system) {
  std::vector<ContactRegime> regimes;
  if (!is_penalised(run.method)) return regimes;
  const double epsilon = effective_epsilon(run);
  const std::vector<double> masses = system.effective_masses();
  const State start = system.initial_state();
  const Bar& bar = system.bar();
  const double own = run.restitution ? damping_ratio(*run.restitution) : 0.0;
  for (const Contact& contact : system.contacts()) {
    if (contact.where == Where::span) continue;
    ContactRegime regime;
    const double h = system.spacing_at(contact.unknown);
    regime.where = contact.where;
    regime.effective_mass = masses[contact.unknown];
    if (const double m = regime.effective_mass; m > 0.0) {
      regime.damping_ratio = own + viscous_ratio(bar, h, m, 1.0 / epsilon);
      regime.quiet_epsilon = h / bar.modulus;
      if (bar.viscosity > 0.0)
        regime.quiet_epsilon = std::min(regime.quiet_epsilon, 4.0 * m * h * h / (bar.viscosity * bar.viscosity));
      regime.chatters = *regime.damping_ratio < 1.0 && epsilon < regime.quiet_epsilon;
    }
    if (const double v = contact.sign * start.v[contact.unknown]; v < 0.0)
      regime.impact = predict_impact(bar, h, regime.effective_mass, epsilon, -v);
    regimes.push_back(regime);
  }
  if (run.scene.span) {
    ContactRegime regime;
    regime.where = Where::span;
    regime.effective_mass = *std::max_element(masses.begin(), masses.end());
    regime.damping_ratio = own;
    regime.chatters = *regime.damping_ratio < 1.0;
    // Falling flat, every node is an oscillator of mass rho w on the spring w / epsilon.
    double v = 0.0;  // that leads deepest into it
    for (const Contact& contact : system.contacts())
      if (contact.where == Where::span) v = std::min(v, contact.sign * start.v[contact.unknown]);
    if (v < 0.0)
      regime.impact = ImpactPrediction{-v, -v * std::sqrt(bar.density * epsilon), ImpactPrediction::Layer::node};
    regimes.push_back(regime);
  }
  return regimes;
}

}  // namespace viscobar

#include "dynamics/frame_energy.hpp"

#include <vector>

namespace viscobar {

BarEnergy nodal_energy(const BarSystem& system, std::span<const double> u, std::span<const double> v) {
  BarEnergy energy;
  if (system.frame().moving()) {
    energy.kinetic = 0.5 * system.inertia().whole().quadratic_form(v);
    for (std::size_t j = 0; j < system.mesh().elements; ++j) {
      const double strain = u[j + 1] - u[j];
      energy.elastic += 0.5 * system.bar().modulus * strain * strain / system.elements().stretch(j);
    }
  } else {
    energy.kinetic = 0.5 * system.inertia().matrix().quadratic_form(system.unknowns().part(v));
    energy.elastic = 0.5 * system.bar().modulus * system.elements().squared_strain(system.unknowns().part(u));
  }
  for (const Support& support : system.supports()) {
    const double at = u[support.unknown + system.unknowns().first_node()];
    energy.elastic += 0.5 * support.stiffness * at * at;
  }
  if (const SideRows* side = system.side()) energy.elastic += side->energy([u](std::size_t j) { return u[j]; });
  return energy;
}

BarEnergy lifted_energy(const BarSystem& system, const Lift& lift, const Lift& rate, std::span<const double> u,
                        std::span<const double> w) {
  std::vector<double> displacement(system.mesh().nodes()), velocity(system.mesh().nodes());
  system.unknowns().expand_displacement(u, displacement);
  system.unknowns().expand_velocity(w, velocity);
  if (system.frame().moving()) {
    system.frame().add_lift(lift, displacement);
    system.frame().add_lift(rate, velocity);
  }
  return nodal_energy(system, displacement, velocity);
}

double end_lift_loss(const BarSystem& system, const Lift& rate, double left, double right) {
  const double strain_rate =
      system.elements().is_chain() ? 0.0 : (rate.right - rate.left) / system.elements().whole_stretch();
  double sum =
      system.bar().viscosity * strain_rate * (2.0 * (right - left) + strain_rate * system.elements().whole_stretch());
  for (const Support& support : system.supports()) {
    const bool at_right = system.unknowns().is_right(support.unknown);
    const double frame = rate.of(at_right);
    sum += support.dashpot * frame * (2.0 * (at_right ? right : left) + frame);
  }
  return sum;
}

}  // namespace viscobar

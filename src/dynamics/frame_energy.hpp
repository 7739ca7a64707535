#pragma once

#include <cstddef>
#include <span>

#include "viscobar/dynamics/bar_system.hpp"

// Energy and power of a bar in a frame that moves, see MovingFrame.

namespace viscobar {

/// The energy of a bar and of the springs and masses at its ends.
struct BarEnergy {
  double kinetic = 0.0;                               ///< of bar and masses
  double elastic = 0.0;                               ///< of bar and springs
  double total() const { return kinetic + elastic; }  ///< their sum
};

/// Energy of displacements and velocities over all mesh nodes, not in the frame: the inertia of ends that are moved
/// included.
BarEnergy nodal_energy(const BarSystem& system, std::span<const double> u, std::span<const double> v);
/// Energy of u + lift and w + its rate.
BarEnergy lifted_energy(const BarSystem& system, const Lift& lift, const Lift& rate, std::span<const double> u,
                        std::span<const double> w);

/// Contribution to lift_loss() of the ends, their velocities being given, and of one bar.
double end_lift_loss(const BarSystem& system, const Lift& rate, double left, double right);
/// Contribution of the frame's velocity to the power that viscosity and supports take at velocities w(j) of all nodes
/// in it. O(1) of one bar, which asks for the ends alone.
double lift_loss(const BarSystem& system, const Lift& rate, auto&& w) {
  double sum = end_lift_loss(system, rate, w(std::size_t{0}), w(system.mesh().elements));
  for (std::size_t e = 0; system.elements().is_chain() && system.bar().damped() && e < system.mesh().elements; ++e) {
    const double frame = rate.at(system.elements().share(e + 1)) - rate.at(system.elements().share(e));
    sum += system.bar().viscosity * system.elements().rate_weights()[e] * frame * (2.0 * (w(e + 1) - w(e)) + frame);
  }
  return sum;
}
/// The power of drag along the bar at velocities w(j) of all nodes.
double side_lift_loss(const BarSystem& system, const Lift& rate, auto&& w) {
  if (!system.side()->has_drag()) return 0.0;
  return system.side()->drag_power(system.frame().moved(rate, w)) - system.side()->drag_power(w);
}
/// Contribution of the frame to SideRows::row_power() of w(j) and u(j).
double side_lift_power(const BarSystem& system, const Lift& lift, const Lift& rate, auto&& w, auto&& u) {
  return system.side()->row_power(system.frame().moved(rate, w), system.frame().moved(lift, u)) -
         system.side()->row_power(w, u);
}

/// Contribution of the frame to end_power(), of velocities w(j) and accelerations a(j) of all nodes in it.
double lift_end_power(const BarSystem& system, const Lift& rate, const Lift& acceleration, auto&& w, auto&& a) {
  if (!system.inertia().whole().unsymmetric()) return 0.0;
  return system.inertia().whole().unsymmetric_product(system.frame().moved(rate, w),
                                                      system.frame().moved(acceleration, a)) -
         system.inertia().whole().unsymmetric_product(w, a);
}

}  // namespace viscobar

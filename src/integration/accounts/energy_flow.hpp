#pragma once

#include <array>
#include <span>

#include "discretisation/gauss.hpp"
#include "dynamics/energy_terms.hpp"
#include "integration/layout.hpp"

namespace viscobar {

/// Dissipated power, load power and power of the mass's end rows in a state at t, those that the layout has, in its
/// order.
///
/// @param accelerations row_values() of the derivative of w: accelerations(), asked for where they count
std::array<double, 3> energy_rates(PenalisedSystem& system, const Layout& layout, double t, std::span<const double> u,
                                   std::span<const double> w, auto&& accelerations) {
  const double loss = frame_loss(system.bar(), t, w);
  const std::size_t first = 2 * layout.nodes;
  std::array<double, 3> rates{};
  if (layout.dissipated) rates[*layout.dissipated - first] = dissipated_power(system.contacts(), w) + loss;
  if (layout.dissipated && system.contacts().bend())
    rates[*layout.dissipated - first] += stop_loss(system.contacts(), u, w);
  if (layout.work) rates[*layout.work - first] = system.load().power(t, w) + loss;
  if (layout.end_inertia) {
    const EndPower power = end_power(system, t, u, w, accelerations());
    rates[*layout.end_inertia - first] = power.all();
    if (layout.work) rates[*layout.work - first] += power.of_frame;
  }
  return rates;
}

/// The same at a time of a step.
///
/// @param motion_at fills displacements and velocities: motion_at(t, y)
/// @param accelerations as there: accelerations(t)
/// @param y scratch of layout.size entries
std::array<double, 3> energy_flow(PenalisedSystem& system, const Layout& layout, double t, auto&& motion_at,
                                  auto&& accelerations, std::span<double> y) {
  motion_at(t, y);
  system.complete_velocity(t, layout.u(y), layout.w(y));
  return energy_rates(system, layout, t, layout.u(y), layout.w(y), [&] { return accelerations(t); });
}

/// Adds the integrals of energy_flow() over [from, to], by Gauss' formula with n points, to the energy account.
///
/// @param account layout.account() entries
template <std::size_t n>
void add_energy_flow(PenalisedSystem& system, const Layout& layout, double from, double to, auto&& motion_at,
                     auto&& accelerations, std::span<double> y, std::span<double> account) {
  const double half = 0.5 * (to - from), middle = from + half;
  for (const auto [node, weight] : gauss(n)) {
    const std::array<double, 3> flow = energy_flow(system, layout, middle + node * half, motion_at, accelerations, y);
    for (std::size_t k = 0; k < layout.account(); ++k) account[k] += half * weight * flow[k];
  }
}

}  // namespace viscobar

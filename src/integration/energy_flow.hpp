#pragma once

#include <cstddef>
#include <span>

#include "dynamics/penalised_system.hpp"
#include "integration/gauss.hpp"
#include "integration/layout.hpp"

namespace viscobar {

/// Adds the integrals of dissipated power, load power and power of the mass's end rows over [from, to], by Gauss'
/// formula with n points, to the entries of the energy account.
///
/// @param motion_at fills displacements and velocities: motion_at(t, y)
/// @param y scratch of layout.size entries
/// @param account layout.account() entries, in the order of the layout
template <std::size_t n, class Motion>
void add_energy_flow(PenalisedSystem& system, const Layout& layout, double from, double to, Motion&& motion_at,
                     std::span<double> y, std::span<double> account) {
  const double half = 0.5 * (to - from), middle = from + half;
  const std::size_t first = 2 * layout.nodes;
  for (const auto [node, weight] : gauss<n>()) {
    const double t = middle + node * half;
    motion_at(t, y);
    const std::span<double> w = layout.w(y);
    system.complete_velocity(t, layout.u(y), w);
    const double loss = system.frame_loss(t, w);
    if (layout.dissipated) account[*layout.dissipated - first] += half * weight * (system.dissipated_power(w) + loss);
    if (layout.work) account[*layout.work - first] += half * weight * (system.load_power(t, w) + loss);
    if (layout.end_inertia) account[*layout.end_inertia - first] += half * weight * system.end_power(t, layout.u(y), w);
  }
}

}  // namespace viscobar

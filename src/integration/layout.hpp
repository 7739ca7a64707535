#pragma once

#include <cstddef>
#include <optional>
#include <span>

#include "dynamics/penalised_system.hpp"

namespace viscobar {

/// Where things are in the state y = (u, w, energy account): u and w have an entry for each unknown node (the w of a
/// massless one is dependent: it is carried along without a weight in the error test), the account has an entry for
/// each of dissipation, work and power of the mass's end rows that the scene has and the user wants.
struct Layout {
  Layout(const PenalisedSystem& system, bool energy) : nodes(system.size()), size(2 * nodes) {
    if (energy && system.takes_energy()) dissipated = size++;
    if (energy && system.loaded()) work = size++;
    if (energy && system.bar().has_end_rows()) end_inertia = size++;
  }
  std::span<double> u(std::span<double> y) const { return y.first(nodes); }
  std::span<double> w(std::span<double> y) const { return y.subspan(nodes, nodes); }

  std::size_t account() const { return size - 2 * nodes; }  ///< entries of the energy account, behind the others

  std::size_t nodes, size;
  std::optional<std::size_t> dissipated, work, end_inertia;
};

}  // namespace viscobar

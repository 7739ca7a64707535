#pragma once

#include <optional>
#include <span>

#include "dynamics/energy_terms.hpp"
#include "dynamics/penalised_system.hpp"

namespace viscobar {

/// Where things are in the state y = (u, w, energy account): u and w have an entry for each unknown node (the w of a
/// massless one is carried along without a weight in the error test), the account one for each of dissipation, work
/// and power of the mass's end rows that the scene has and the user wants. Behind that comes a block for each parameter
/// p whose derivatives are wanted: (du/dp, dw/dp), and an entry for the impulse on each end with an obstacle.
struct Layout {
  Layout(const PenalisedSystem& system, bool energy, std::size_t parameters = 0)
      : nodes(system.size()), size(2 * nodes), derivatives(parameters) {
    if (energy && takes_energy(system.contacts())) dissipated = size++;
    if (energy && system.load().acts()) work = size++;
    if (energy && system.bar().has_end_rows()) end_inertia = size++;
    first_derivative = size;
    for (std::size_t i = 0; i < system.contacts().size(); ++i) {
      left |= system.contacts()[i].where == Where::left;
      right |= system.contacts()[i].where == Where::right;
    }
    block = 2 * nodes + (left ? 1 : 0) + (right ? 1 : 0);
    size += derivatives * block;
  }
  std::span<double> u(std::span<double> y) const { return y.first(nodes); }
  std::span<double> w(std::span<double> y) const { return y.subspan(nodes, nodes); }

  std::size_t account() const { return first_derivative - 2 * nodes; }  ///< entries of the energy account

  /// Block k of the derivatives, and its parts.
  template <class T>
  struct Block : std::span<T> {
    std::size_t nodes;
    std::span<T> u() const { return this->first(nodes); }
    std::span<T> w() const { return this->subspan(nodes, nodes); }
    std::span<T> impulses() const { return this->subspan(2 * nodes); }
  };
  template <class T>
  Block<T> derivative(std::span<T> y, std::size_t k) const {
    return {y.subspan(first_derivative + k * block, block), nodes};
  }
  /// use(k, end) for each end whose impulse has an entry, the k-th of its block's.
  template <class Use>
  void each_impulse(Use&& use) const {
    if (left) use(std::size_t{0}, std::size_t{0});
    if (right) use(left ? std::size_t{1} : std::size_t{0}, nodes - 1);
  }

  std::size_t nodes, size, derivatives;
  std::size_t first_derivative = 0, block = 0;
  bool left = false, right = false;  ///< true if the impulse on that end has an entry
  std::optional<std::size_t> dissipated, work, end_inertia;
};

}  // namespace viscobar

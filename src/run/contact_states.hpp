#pragma once

#include <cstddef>
#include <span>
#include <type_traits>
#include <vector>

#include "dynamics/penalised_system.hpp"

namespace viscobar {

/// Which contacts of a (const) PenalisedSystem are closed, and which have been measured from, as an archive takes and
/// gives it.
template <class System>
struct ContactStates {
  System& system;

  static void members(auto& states, auto&& each) {
    System& system = states.system;
    std::vector<unsigned char> closed(system.contact_count()), measured(closed);
    for (std::size_t i = 0; i < closed.size(); ++i) {
      closed[i] = system.closed(i);
      measured[i] = system.measured_from_obstacle(i);
    }
    each(std::span(closed), std::span(measured));
    if constexpr (!std::is_const_v<System>)
      for (std::size_t i = 0; i < closed.size(); ++i) {
        system.set_closed(i, closed[i] != 0);
        if (measured[i]) system.measure_from_obstacle(i, {});  // as the archived state is
      }
  }
};
template <class System>
ContactStates(System&) -> ContactStates<System>;

}  // namespace viscobar

#pragma once

#include <cstddef>
#include <span>
#include <type_traits>
#include <vector>

#include "dynamics/contacts.hpp"

namespace viscobar {

/// Which of (const) Contacts are closed, and which have been measured from, as an archive takes and
/// gives it.
template <class Of>
struct ContactStates {
  Of& contacts;

  static void members(auto& states, auto&& each) {
    Of& contacts = states.contacts;
    std::vector<unsigned char> closed(contacts.size()), measured(closed);
    for (std::size_t i = 0; i < closed.size(); ++i) {
      closed[i] = contacts.closed(i);
      measured[i] = contacts.measured(i);
    }
    each(std::span(closed), std::span(measured));
    if constexpr (!std::is_const_v<Of>)
      for (std::size_t i = 0; i < closed.size(); ++i) {
        contacts.set_closed(i, closed[i] != 0);
        if (measured[i]) contacts.measure(i, {});  // as the archived state is
      }
  }
};
template <class Of>
ContactStates(Of&) -> ContactStates<Of>;

}  // namespace viscobar

#pragma once

#include <algorithm>
#include <cstddef>
#include <span>

namespace viscobar {

/// A spring and a dashpot between an end and the ground, and a mass on it.
struct Support {
  std::size_t unknown = 0;  ///< of the end
  double stiffness = 0.0;   ///< k
  double dashpot = 0.0;     ///< c
  double mass = 0.0;        ///< m
};

/// True if one has a dashpot.
inline bool has_dashpots(std::span<const Support> supports) {
  return std::ranges::any_of(supports, [](const Support& support) { return support.dashpot > 0.0; });
}

}  // namespace viscobar

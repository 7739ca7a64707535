#pragma once

#include <vector>

namespace viscobar {

/// Nodal displacement and velocity of the unknowns (n entries each; fixed nodes are not among them).
struct State {
  std::vector<double> u;  ///< displacement
  std::vector<double> v;  ///< velocity
};

}  // namespace viscobar

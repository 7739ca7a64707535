#pragma once

#include <array>
#include <cmath>
#include <utility>

namespace viscobar {

/// Nodes and weights of Gauss' formula with five points on [-1, 1], exact for polynomials of degree 9. On a step of
/// length h it is wrong by 4e-13 h^11 f^(10).
inline std::array<std::pair<double, double>, 5> gauss_five() {
  const double root = 2.0 * std::sqrt(10.0 / 7.0), share = 13.0 * std::sqrt(70.0);
  const double inner = std::sqrt(5.0 - root) / 3.0, outer = std::sqrt(5.0 + root) / 3.0;
  const double of_inner = (322.0 + share) / 900.0, of_outer = (322.0 - share) / 900.0;
  return {{{-outer, of_outer}, {-inner, of_inner}, {0.0, 128.0 / 225.0}, {inner, of_inner}, {outer, of_outer}}};
}

}  // namespace viscobar

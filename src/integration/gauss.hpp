#pragma once

#include <array>
#include <cstddef>
#include <span>

namespace viscobar {

struct GaussPoint {
  double node, weight;
};

/// Gauss' formula with n points on [-1, 1], exact for polynomials of degree 2 n - 1.
template <std::size_t n>
constexpr std::array<GaussPoint, n> gauss();

template <>
constexpr std::array<GaussPoint, 3> gauss<3>() {
  constexpr double node = 0.7745966692414834;
  return {{{-node, 5.0 / 9.0}, {0.0, 8.0 / 9.0}, {node, 5.0 / 9.0}}};
}

template <>
constexpr std::array<GaussPoint, 5> gauss<5>() {
  constexpr double inner = 0.5384693101056831, outer = 0.9061798459386640;
  constexpr double of_inner = 0.4786286704993665, of_outer = 0.2369268850561891;
  return {{{-outer, of_outer}, {-inner, of_inner}, {0.0, 128.0 / 225.0}, {inner, of_inner}, {outer, of_outer}}};
}

template <>
constexpr std::array<GaussPoint, 8> gauss<8>() {
  constexpr std::array<GaussPoint, 4> half = {{{0.1834346424956498, 0.3626837833783620},
                                               {0.5255324099163290, 0.3137066458778873},
                                               {0.7966664774136267, 0.2223810344533745},
                                               {0.9602898564975363, 0.1012285362903763}}};
  std::array<GaussPoint, 8> all{};
  for (std::size_t i = 0; i < 4; ++i) {
    all[2 * i] = {-half[i].node, half[i].weight};
    all[2 * i + 1] = half[i];
  }
  return all;
}

/// With as few points as the formula is exact with for that degree, 15 at most.
inline std::span<const GaussPoint> gauss_for_degree(std::size_t degree) {
  static constexpr auto three = gauss<3>();
  static constexpr auto five = gauss<5>();
  static constexpr auto eight = gauss<8>();
  if (degree <= 5) return three;
  if (degree <= 9) return five;
  return eight;
}

}  // namespace viscobar

#pragma once

#include <cstddef>
#include <span>

namespace viscobar {

struct GaussPoint {
  double node, weight;
};

/// Gauss' formula with n <= most_gauss_points points on [-1, 1], exact for polynomials of degree 2 n - 1.
inline constexpr std::size_t most_gauss_points = 40;
std::span<const GaussPoint> gauss(std::size_t n);

/// With as few points as are exact for polynomials of that degree.
inline std::span<const GaussPoint> gauss_for_degree(std::size_t degree) { return gauss(degree / 2 + 1); }

}  // namespace viscobar

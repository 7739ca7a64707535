#pragma once

#include <cmath>
#include <cstddef>
#include <numbers>
#include <span>
#include <vector>

namespace viscobar::characteristics {

struct GaussNode {
  double node, weight;
};

/// Gauss' formula with n <= 40 points on [-1, 1], exact for polynomials of degree 2 n - 1.
inline std::span<const GaussNode> gauss_legendre(std::size_t n) {
  static const std::vector<std::vector<GaussNode>> all = [] {
    std::vector<std::vector<GaussNode>> list(41);
    for (std::size_t size = 1; size < list.size(); ++size)
      for (std::size_t i = 0; i < size; ++i) {
        const auto m = static_cast<double>(size);
        double z = std::cos(std::numbers::pi * (static_cast<double>(i) + 0.75) / (m + 0.5)), slope = 1.0;
        for (int step = 0; step < 8; ++step) {  // Newton's method on Legendre's polynomial
          double p = 1.0, before = 0.0;
          for (std::size_t k = 1; k <= size; ++k) {
            const auto degree = static_cast<double>(k);
            const double next = ((2.0 * degree - 1.0) * z * p - (degree - 1.0) * before) / degree;
            before = p;
            p = next;
          }
          slope = m * (before - z * p) / (1.0 - z * z);
          z -= p / slope;
        }
        list[size].push_back({z, 2.0 / ((1.0 - z * z) * slope * slope)});
      }
    return list;
  }();
  return all[n];
}

}  // namespace viscobar::characteristics

#pragma once

#include <array>
#include <cstddef>
#include <span>

namespace viscobar {

/// A polynomial p of degree 5 through values u at six nodes around a place x,
///
///     p(x) = sum_i weights_i u_i,   p'(x) = sum_i slopes_i u_i,
///
/// of fewer nodes where the mesh has no six. Where u is smooth its errors are O(h^6) and O(h^5).
struct Interpolant {
  std::size_t begin = 0, count = 1;  ///< the nodes
  std::array<double, 6> weights{1.0}, slopes{};

  double value(std::span<const double> u) const { return sum(weights, u); }
  double slope(std::span<const double> u) const { return sum(slopes, u); }

 private:
  double sum(const std::array<double, 6>& factors, std::span<const double> u) const {
    const double* x = u.data() + begin;
    if (count == 6)
      return (factors[0] * x[0] + factors[1] * x[1]) + (factors[2] * x[2] + factors[3] * x[3]) +
             (factors[4] * x[4] + factors[5] * x[5]);
    double sum = 0.0;
    for (std::size_t i = 0; i < count; ++i) sum += factors[i] * x[i];
    return sum;
  }
};

/// @param nodes two at least, increasing
Interpolant interpolant(std::span<const double> nodes, double x);

}  // namespace viscobar

#pragma once

#include <cmath>
#include <cstddef>
#include <span>

namespace viscobar {

/// Bounds of polynomials over the step of length h that they end with, by their Taylor series at its end:
///
///     |p(t) - p(end)| <= sum_k |p^(k)(end)| h^k / k!.
///
/// `derivative(k)` gives the k-th derivative of each at the end, valid until the next call.
template <class Derivative>
void taylor_hull(std::size_t order, double h, Derivative&& derivative, std::span<double> lowest,
                 std::span<double> highest) {
  double scale = 1.0;
  for (std::size_t k = 0; k <= order; ++k) {
    const std::span<const double> values = derivative(static_cast<int>(k));
    if (k > 0) scale *= h / static_cast<double>(k);
    for (std::size_t i = 0; i < values.size(); ++i) {
      const double term = scale * values[i];
      lowest[i] = k == 0 ? term : lowest[i] - std::abs(term);
      highest[i] = k == 0 ? term : highest[i] + std::abs(term);
    }
  }
}

}  // namespace viscobar

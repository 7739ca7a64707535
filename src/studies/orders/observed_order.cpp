#include "viscobar/studies/orders/observed_order.hpp"

#include <cmath>
#include <vector>

namespace viscobar {

std::optional<ObservedOrder> observed_order(std::span<const double> x, std::span<const double> y) {
  std::vector<double> a, b;
  std::optional<std::size_t> first;  // logarithms are of ratios to it, which have no units
  for (std::size_t i = 0; i < x.size() && i < y.size(); ++i) {
    if (!(x[i] > 0.0 && y[i] > 0.0 && std::isfinite(x[i]) && std::isfinite(y[i]))) continue;
    first = first.value_or(i);
    a.push_back(std::log(x[i] / x[*first]));
    b.push_back(std::log(y[i] / y[*first]));
  }
  const auto n = static_cast<double>(a.size());
  if (a.size() < 2) return std::nullopt;
  double mean_a = 0.0, mean_b = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) mean_a += a[i] / n, mean_b += b[i] / n;
  double square = 0.0, product = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    square += (a[i] - mean_a) * (a[i] - mean_a);
    product += (a[i] - mean_a) * (b[i] - mean_b);
  }
  if (square == 0.0) return std::nullopt;
  ObservedOrder result{product / square, 0.0};
  if (a.size() == 2) return result;
  double scatter = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    const double residual = b[i] - mean_b - result.order * (a[i] - mean_a);
    scatter += residual * residual;
  }
  result.standard_error = std::sqrt(scatter / (n - 2.0) / square);
  return result;
}

}  // namespace viscobar

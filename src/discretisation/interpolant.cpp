#include "discretisation/interpolant.hpp"

#include <algorithm>

namespace viscobar {

Interpolant interpolant(std::span<const double> nodes, double x) {
  const std::size_t count = std::min<std::size_t>(6, nodes.size()), half = count / 2;
  const auto right = static_cast<std::size_t>(std::ranges::lower_bound(nodes, x) - nodes.begin());
  Interpolant result{.begin = std::min(right < half ? 0 : right - half, nodes.size() - count), .count = count};
  const auto node = [&](std::size_t i) { return nodes[result.begin + i]; };
  for (std::size_t i = 0; i < count; ++i) {
    double weight = 1.0, slope = 0.0;  // of the product of the factors so far
    for (std::size_t j = 0; j < count; ++j) {
      if (j == i) continue;
      const double distance = node(i) - node(j), factor = (x - node(j)) / distance;
      slope = slope * factor + weight / distance;
      weight *= factor;
    }
    result.weights[i] = weight;
    result.slopes[i] = slope;
  }
  return result;
}

}  // namespace viscobar

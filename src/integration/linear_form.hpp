#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <span>

#include "integration/point_values.hpp"

namespace viscobar {

/// Values at so many points, as a vector.
template <std::size_t lanes>
using Points = Eigen::Array<double, static_cast<int>(lanes), 1>;

/// sum_k weights[k] y[entries[k]] of a few entries of y = (u, w): a clearance, or a part of the row of a force.
struct LinearForm {
  static constexpr std::size_t most = 6;
  std::array<std::size_t, most> entries{};
  std::array<double, most> weights{};
  std::size_t count = 0;

  void add(std::size_t entry, double weight) {
    if (weight != 0.0) entries[count] = entry, weights[count++] = weight;
  }
  /// Values of the form at points, from those of all entries, in vectors of so many.
  template <std::size_t lanes>
  Points<lanes> of_points(std::span<const PointValues> y) const {
    Points<lanes> sum = Points<lanes>::Zero();
    for (std::size_t k = 0; k < count; ++k) sum += weights[k] * Points<lanes>::Map(y[entries[k]].data());
    return sum;
  }
};

}  // namespace viscobar

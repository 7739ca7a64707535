#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <span>
#include <vector>

namespace viscobar {

/// Values of a polynomial at equidistant points. Those behind its degree, any numbers, make whole vectors of it.
using PointValues = std::array<double, 16>;

/// Point j of [begin, end].
inline double point_of(double begin, double end, std::size_t order, std::size_t j) {
  return j == order ? end : begin + (end - begin) * static_cast<double>(j) / static_cast<double>(order);
}

/// Place of `entry` among the entries that are sampled, where it is put when it is not there yet.
inline std::size_t position_of(std::size_t entry, std::vector<std::size_t>& entries) {
  const auto place = static_cast<std::size_t>(std::ranges::find(entries, entry) - entries.begin());
  if (place == entries.size()) entries.push_back(entry);
  return place;
}

/// sample(j, t) at the points t of [begin, end], entry by entry, kept in `all`: those at `positions` alone.
template <class Sample>
std::span<const PointValues> sample_points(double begin, double end, std::size_t order,
                                           std::span<const std::size_t> positions, std::vector<PointValues>& all,
                                           Sample&& sample) {
  for (std::size_t j = 0; j <= order; ++j) {
    const std::span<const double> y = sample(j, point_of(begin, end, order, j));
    all.resize(y.size());
    for (const std::size_t k : positions) all[k][j] = y[k];
  }
  return all;
}

}  // namespace viscobar

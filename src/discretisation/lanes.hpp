#pragma once

#include <array>
#include <cstddef>
#include <experimental/simd>

namespace viscobar {

/// One value in each of the stretches of a bar that are worked on side by side.
using Lanes = std::experimental::fixed_size_simd<double, 16>;
constexpr std::size_t lane_count = Lanes::size();

inline Lanes load_lanes(const double* x) { return Lanes(x, std::experimental::element_aligned); }
inline void store_lanes(const Lanes& lanes, double* x) { lanes.copy_to(x, std::experimental::element_aligned); }

/// Changes lanes one by one: `change` is given them as an array.
[[gnu::always_inline]] inline void change_lanes(Lanes& lanes, auto&& change) {
  std::array<double, lane_count> values;
  store_lanes(lanes, values.data());
  change(values);
  lanes = load_lanes(values.data());
}

/// The sum of all lanes, by halves: the order of std::experimental::reduce depends on the width of registers.
[[gnu::always_inline]] inline double sum_of(Lanes lanes) {
  change_lanes(lanes, [](auto& values) {
    for (std::size_t half = lane_count / 2; half > 0; half /= 2)
      for (std::size_t l = 0; l < half; ++l) values[l] += values[l + half];
  });
  return lanes[0];
}

/// The first `count` of 16 numbers, and zeros.
[[gnu::noinline]] Lanes load_first(const double* x, std::size_t count) noexcept;

/// term(at) summed over n entries, `at` loading 16 of an array, or what is left of it and zeros. A loop that adds to
/// one number has its terms multiplied as many at once as registers hold, and only the others contracted with the
/// addition. Nor is a product contracted with an addition behind a branch: loading has none.
inline double sum_by_lanes(std::size_t n, auto&& term) {
  Lanes sums = 0.0;
  std::size_t i = 0;
  for (; i + lane_count <= n; i += lane_count)
    sums += term([i](const double* x) __attribute__((always_inline)) { return load_lanes(x + i); });
  if (i < n) sums += term([=](const double* x) { return load_first(x + i, n - i); });
  return sum_of(sums);
}

}  // namespace viscobar

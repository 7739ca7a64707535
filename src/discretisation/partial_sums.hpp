#pragma once

#include <array>
#include <cstddef>
#include <numeric>

namespace viscobar {

/// term(0) + ... + term(n - 1), in partial sums, since one alone would wait for each addition.
double partial_sums(std::size_t n, auto&& term) {
  constexpr std::size_t lanes = 16;
  std::array<double, lanes> sums{};
  std::size_t i = 0;
  for (; i + lanes <= n; i += lanes)
    for (std::size_t l = 0; l < lanes; ++l) sums[l] += term(i + l);
  double sum = std::accumulate(sums.begin(), sums.end(), 0.0);
  for (; i < n; ++i) sum += term(i);
  return sum;
}

}  // namespace viscobar

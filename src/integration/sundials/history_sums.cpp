#include "integration/sundials/history_sums.hpp"

#include <algorithm>
#include <experimental/simd>
#include <utility>

namespace viscobar::sundials {

namespace {

constexpr std::size_t highest_order = 12;

template <class Values, std::size_t q, class Load, class Store>
void triangle(const Load& load, const Store& store) {
  std::array<Values, q + 1> z;
#pragma GCC unroll 16
  for (std::size_t j = 0; j <= q; ++j) z[j] = load(j);
#pragma GCC unroll 16
  for (std::size_t k = 1; k <= q; ++k)
#pragma GCC unroll 16
    for (std::size_t j = q; j >= k; --j) z[j - 1] += z[j];
#pragma GCC unroll 16
  for (std::size_t j = 0; j < q; ++j) store(j, z[j]);
}

template <std::size_t q>
void sum_history(double* const* z, std::size_t n) {
  namespace simd = std::experimental;
  using Pack = simd::native_simd<double>;
  std::size_t i = 0;
  for (; i + Pack::size() <= n; i += Pack::size())
    triangle<Pack, q>([&](std::size_t j) { return Pack(z[j] + i, simd::element_aligned); },
                      [&](std::size_t j, const Pack& value) { value.copy_to(z[j] + i, simd::element_aligned); });
  for (; i < n; ++i)
    triangle<double, q>([&](std::size_t j) { return z[j][i]; }, [&](std::size_t j, double value) { z[j][i] = value; });
}

using Kernel = void (*)(double* const*, std::size_t);

template <std::size_t... q>
constexpr std::array<Kernel, sizeof...(q)> triangles(std::index_sequence<q...>) {
  return {sum_history<q + 1>...};
}

}  // namespace

bool HistorySums::put_off(double* x, const double* y, std::size_t n) {
  if (count_ == sums_.size() || (count_ > 0 && n != size_)) return false;
  sums_[count_++] = {x, y};
  size_ = n;
  return true;
}

std::size_t HistorySums::cascade() const {
  // Of different vectors: one that comes back would have to be read again.
  const auto seen = [&](const double* x, std::size_t count) {
    return std::any_of(sums_.begin(), sums_.begin() + static_cast<std::ptrdiff_t>(count),
                       [x](const Sum& sum) { return sum.x == x || sum.y == x; });
  };
  std::size_t q = 1;
  while (q < count_ && sums_[q].y == sums_[q - 1].x && !seen(sums_[q].x, q)) ++q;
  return q;
}

bool HistorySums::is_triangle(std::size_t order) const {
  if (count_ != order * (order + 1) / 2) return false;
  std::size_t i = order;
  for (std::size_t k = 1; k < order; ++k)
    for (std::size_t j = 0; j < order - k; ++j, ++i)
      if (sums_[i].x != sums_[j].x || sums_[i].y != sums_[j].y) return false;
  return true;
}

void HistorySums::carry_out() {
  static constexpr auto kernels = triangles(std::make_index_sequence<highest_order>{});
  if (const std::size_t q = cascade(); q <= highest_order && is_triangle(q)) {
    std::array<double*, highest_order + 1> z;
    z[q] = const_cast<double*>(sums_[0].y);  // is read only
    for (std::size_t j = 0; j < q; ++j) z[q - 1 - j] = sums_[j].x;
    kernels[q - 1](z.data(), size_);
  } else {
    for (std::size_t k = 0; k < count_; ++k)
      for (std::size_t i = 0; i < size_; ++i) sums_[k].x[i] += sums_[k].y[i];
  }
  count_ = 0;
}

}  // namespace viscobar::sundials

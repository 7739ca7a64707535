#include "integration/sundials/prediction.hpp"

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
void multiply_history(double* const* z, std::size_t n) {
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
constexpr std::array<Kernel, sizeof...(q)> kernels(std::index_sequence<q...>) {
  return {multiply_history<q + 1>...};
}

}  // namespace

bool Prediction::put_off(double* x, const double* y, std::size_t n) {
  if (count_ == sums_.size() || (count_ > 0 && n != size_)) return false;
  sums_[count_++] = {x, y};
  size_ = n;
  return true;
}

std::size_t Prediction::order() const {
  std::size_t q = 1;
  while (q < count_ && sums_[q].y == sums_[q - 1].x) ++q;
  if (q > highest_order || count_ != q * (q + 1) / 2) return 0;
  std::size_t i = q;
  for (std::size_t k = 1; k < q; ++k)
    for (std::size_t j = 0; j < q - k; ++j, ++i)
      if (sums_[i].x != sums_[j].x || sums_[i].y != sums_[j].y) return 0;
  return q;
}

void Prediction::carry_out() {
  static constexpr auto by_order = kernels(std::make_index_sequence<highest_order>{});
  const std::size_t q = order();
  if (q > 0) {
    std::array<double*, highest_order + 1> z;
    z[q] = const_cast<double*>(sums_[0].y);  // is read only
    for (std::size_t j = 0; j < q; ++j) z[q - 1 - j] = sums_[j].x;
    by_order[q - 1](z.data(), size_);
  } else {
    for (std::size_t k = 0; k < count_; ++k)
      for (std::size_t i = 0; i < size_; ++i) sums_[k].x[i] += sums_[k].y[i];
  }
  count_ = 0;
}

}  // namespace viscobar::sundials

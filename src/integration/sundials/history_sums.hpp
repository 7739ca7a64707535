#pragma once

#include <array>
#include <cstddef>
#include <span>

namespace viscobar::sundials {

/// Sums x += y of vectors, put off until somebody looks. CVODE predicts by multiplying its history with Pascal's
/// triangle,
///
///     for k = 1 ... q:  for j = q ... k:  z_{j-1} += z_j,
///
/// as separate sums, which move three times q (q + 1) / 2 numbers through memory for each entry; in one pass it is
/// 2 q + 1. The sums are the same and in the same order, so the result is too, to the last bit.
class HistorySums {
 public:
  /// Puts x += y off; both of n entries. False when there is no room: carry_out() first.
  bool put_off(double* x, const double* y, std::size_t n);

  bool empty() const { return count_ == 0; }
  void carry_out();

 private:
  std::size_t cascade() const;                // length of the cascade that the sums begin with
  bool is_triangle(std::size_t order) const;  // whether they are the whole triangle

  struct Sum {
    double* x = nullptr;
    const double* y = nullptr;
  };
  std::array<Sum, 78> sums_{};  // order 12
  std::size_t count_ = 0, size_ = 0;
};

}  // namespace viscobar::sundials

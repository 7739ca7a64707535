#pragma once

#include <array>
#include <cstddef>
#include <numeric>
#include <span>
#include <utility>
#include <vector>

#include "integration/sundials/handles.hpp"

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
  bool is_triangle(std::size_t order) const;  // true if they are the whole triangle

  struct Sum {
    double* x = nullptr;
    const double* y = nullptr;
  };
  std::array<Sum, 78> sums_{};  // order 12
  std::size_t count_ = 0, size_ = 0;
};

/// An N_Vector of our own: contiguous, every operation vectorised and the linear combinations fused, because
/// distributions ship SUNDIALS' own vectors unoptimised. Its weighted norm is the maximum norm max |x_i w_i|: the
/// root mean square would dilute the error of one node in an impact by the square root of the mesh size.
/// Norms look at its first `weighed` entries, all by default: the others have no weight anyway.
Vector make_vector(std::size_t size, const Context& context, std::size_t weighed = static_cast<std::size_t>(-1));

/// Entries that a probe looks at: entry i of it is entries[i] of a vector, where i is among the `selected`; others are
/// left.
struct Probed {
  explicit Probed(std::vector<std::size_t> of) : entries(std::move(of)), selected(entries.size()) {
    std::iota(selected.begin(), selected.end(), std::size_t{0});
  }
  std::vector<std::size_t> entries, selected;
};

/// A vector that linear combinations only reach at the probed entries of their operands: evaluating an integrator's
/// interpolant into it costs a few operations instead of a pass over the whole history.
/// `probed` must outlive the vector.
Vector make_probe(const Probed& probed, const Context& context);

/// A vector that takes from an interpolant at the end of a step, p(t) = sum_k c_k(t) x_k, what bounds it over the step:
/// the entries' lowest values first, then their highest, then those at the end. There c_0 = 1, and the others are 0.
/// Before it |c_k| <= 1 and |h c_k'| <= k, so p is within sum |x_k|, k > 0, of its end, and where |x_1| is above
/// sum k |x_k|, k > 1, it rises or falls throughout. That holds of Nordsieck's array, c_k = s^k with -1 <= s <= 0, and
/// of IDA's divided differences: c_k = c_{k-1} (d + psi_{k-2}) / psi_{k-1}, -psi_0 <= d <= 0, h = psi_0, the psi
/// growing.
Vector make_hull(const Probed& probed, const Context& context);

/// A linear combination sum_k c_k x_k that has been written down.
struct Recorded {
  std::array<double, 13> factors{};       ///< c_k
  std::array<const double*, 13> terms{};  ///< x_k
  std::size_t count = 0;
};
/// A vector that linear combinations are not made into, but written down in `record`, which must outlive it: so one
/// learns what an integrator's interpolant is made of.
Vector make_recorder(Recorded& record, const Context& context);

/// To be called behind each call of the library that may make vectors. @throws std::bad_alloc when it could not
void require_memory();

std::span<double> values(N_Vector vector);
inline std::span<double> values(const Vector& vector) { return values(vector.get()); }

}  // namespace viscobar::sundials

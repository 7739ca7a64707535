#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "viscobar/discretisation/tridiagonal.hpp"

namespace viscobar {

/// min 1/2 x.A x - b.x  subject to  s_X x_X >= bound_X  at two entries X of x at most, solved in closed form:
///
///     A x = b + sum_X lambda_X s_X e_X,    0 <= s_X x_X - bound_X  _|_  lambda_X >= 0,
///
/// s_X = 1 or -1. The columns A^{-1} s_X e_X are computed once. Their rows X are positive definite, or for a mass with
/// end rows have positive diagonal and determinant, so exactly one of the two or four contact states fits.
class EndConstraint {
 public:
  /// An entry and its sign.
  struct Bounded {
    // NOLINTNEXTLINE(google-explicit-constructor): an entry alone is bounded from below
    Bounded(std::size_t bounded_entry, double from = 1.0) : entry(bounded_entry), sign(from) {}
    std::size_t entry;
    double sign;
  };
  EndConstraint(const SymmetricTridiagonal& matrix, const std::vector<Bounded>& entries);

  /// x holds b on entry and the solution on return, with s_X x_X = bound_X bitwise where the constraint is active.
  /// `bound` and `multiplier` have one value an entry X; without a bound it is -infinity.
  void solve(std::span<double> x, std::span<const double> bound, std::span<double> multiplier);

  /// 1 where the last solution is held by its bound.
  std::span<const unsigned char> active() const { return {active_.data(), columns_.size()}; }

 private:
  struct Column {
    Bounded at;
    std::vector<double> values;  // A^{-1} s e_entry
    double of(std::span<const double> x) const { return at.sign * x[at.entry]; }
  };

  TridiagonalFactor factor_;
  std::vector<Column> columns_;
  std::array<unsigned char, 2> active_{};
};

}  // namespace viscobar

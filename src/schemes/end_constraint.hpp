#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "viscobar/discretisation/tridiagonal.hpp"

namespace viscobar {

/// min 1/2 x.A x - b.x  subject to  x_X >= bound_X  at one or two entries X of x, solved in closed form:
///
///     A x = b + sum_X lambda_X e_X,    0 <= x_X - bound_X  _|_  lambda_X >= 0.
///
/// The columns A^{-1} e_X are computed once. Their rows X are positive definite, or for a mass with end rows have
/// positive diagonal and determinant, so exactly one of the two or four contact states fits.
class EndConstraint {
 public:
  EndConstraint(const SymmetricTridiagonal& matrix, const std::vector<std::size_t>& entries);

  /// x holds b on entry and the solution on return, with x_X = bound_X bitwise where the constraint is active.
  /// `bound` and `multiplier` have one value an entry X; without a bound it is -infinity.
  void solve(std::span<double> x, std::span<const double> bound, std::span<double> multiplier);

  /// 1 where the last solution is held by its bound.
  std::span<const unsigned char> active() const { return {active_.data(), columns_.size()}; }

 private:
  struct Column {
    std::size_t entry;
    std::vector<double> values;  // A^{-1} e_entry
  };

  TridiagonalFactor factor_;
  std::vector<Column> columns_;
  std::array<unsigned char, 2> active_{};
};

}  // namespace viscobar

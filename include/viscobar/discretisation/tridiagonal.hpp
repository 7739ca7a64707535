#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace viscobar {

/// Symmetric tridiagonal matrix A: A(i,i) = diagonal[i], A(i,i+1) = A(i+1,i) = off_diagonal[i].
/// A diagonal matrix has an empty off_diagonal: nothing is stored or multiplied for what is not there.
struct SymmetricTridiagonal {
  std::vector<double> diagonal;      ///< n
  std::vector<double> off_diagonal;  ///< n - 1, or empty

  std::size_t size() const { return diagonal.size(); }  ///< n

  /// out = A x. `out` and `x` have n entries and do not overlap.
  void multiply(std::span<const double> x, std::span<double> out) const;

  /// x . A x
  double quadratic_form(std::span<const double> x) const;
};

/// A = L D L^T of a symmetric positive definite tridiagonal matrix; O(n) to build, O(n) to solve.
class TridiagonalFactor {
 public:
  TridiagonalFactor() = default;
  /// The factor of a matrix, see factorise().
  explicit TridiagonalFactor(const SymmetricTridiagonal& matrix) { factorise(matrix); }

  /// Rebuilds the factor in place; allocates only when the size grows.
  /// @throws std::domain_error when a pivot is not positive: the matrix is not positive definite.
  void factorise(const SymmetricTridiagonal& matrix);

  /// x <- A^{-1} x
  void solve(std::span<double> x) const;

  std::size_t size() const { return inverse_pivot_.size(); }  ///< n

 private:
  std::vector<double> lower_;          // L(i+1,i); empty for a diagonal matrix
  std::vector<double> inverse_pivot_;  // 1 / D(i,i)
};

/// Diagonal of A^{-1} in O(n), from the pivots of the eliminations that start at either end.
std::vector<double> inverse_diagonal(const SymmetricTridiagonal& matrix);

}  // namespace viscobar

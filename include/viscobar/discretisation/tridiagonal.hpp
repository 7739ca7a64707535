#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <optional>
#include <span>
#include <vector>

namespace viscobar {

/// Entries of the end rows of a matrix beside their symmetric part.
struct EndRows {
  std::array<double, 3> first{};  ///< row 0, columns 0, 1, 2
  std::array<double, 3> last{};   ///< row n-1, columns n-1, n-2, n-3

  /// first . (x_0, x_1, x_2), n >= 3
  double first_times(std::span<const double> x) const { return first[0] * x[0] + first[1] * x[1] + first[2] * x[2]; }
  /// last . (x_{n-1}, x_{n-2}, x_{n-3}), n >= 3
  double last_times(std::span<const double> x) const {
    const std::size_t n = x.size();
    return last[0] * x[n - 1] + last[1] * x[n - 2] + last[2] * x[n - 3];
  }

  /// Entries of the row of unknown `end`, 0 or the last, from the end inwards.
  const std::array<double, 3>& row(std::size_t end) const { return end == 0 ? first : last; }
  /// The same times x, which has n entries.
  double row_times(std::size_t end, std::span<const double> x) const {
    return end == 0 ? first_times(x) : last_times(x);
  }
  EndRows times(double factor) const;  ///< factor times the same

  /// The same, of n rows, without what couples those for which out(i) holds to others.
  template <class Out>
  EndRows uncoupled(std::size_t n, Out&& out) const {
    EndRows rows = *this;
    for (std::size_t k = 1; k < 3; ++k) {
      if (out(0) || out(k)) rows.first[k] = 0.0;
      if (out(n - 1) || out(n - 1 - k)) rows.last[k] = 0.0;
    }
    return rows;
  }
};

/// Tridiagonal matrix A, symmetric but for its end rows and its skew part: A = T + (skew part) + (end rows), T(i,i) =
/// diagonal[i], T(i,i+1) = T(i+1,i) = off_diagonal[i]. A diagonal matrix has an empty off_diagonal, a symmetric one no
/// end rows and no skew part: nothing is stored or multiplied for what is not there.
struct SymmetricTridiagonal {
  std::vector<double> diagonal;       ///< n
  std::vector<double> off_diagonal;   ///< n - 1, or empty
  std::optional<EndRows> end_rows{};  ///< of n >= 3 rows with an off_diagonal
  std::vector<double> skew{};         ///< n - 1, or empty: it is added to A(i,i+1) and taken from A(i+1,i)

  std::size_t size() const { return diagonal.size(); }  ///< n

  /// A(i,i)
  double diagonal_entry(std::size_t i) const;
  /// A(i,i+1) and A(i+1,i), without the end rows.
  double above(std::size_t i) const { return skew.empty() ? off_diagonal[i] : off_diagonal[i] + skew[i]; }
  double below(std::size_t i) const { return skew.empty() ? off_diagonal[i] : off_diagonal[i] - skew[i]; }  ///< below
  /// Makes A(i,i+1) and A(i+1,i) zero, but for end rows.
  void uncouple(std::size_t i) {
    off_diagonal[i] = 0.0;
    if (!skew.empty()) skew[i] = 0.0;
  }
  /// True if its off_diagonal is missing.
  bool is_diagonal() const { return off_diagonal.empty(); }
  SymmetricTridiagonal& operator*=(double factor);  ///< of all entries

  /// out = A x. `out` and `x` have n entries and do not overlap.
  void multiply(std::span<const double> x, std::span<double> out) const;

  /// x . T x, of the symmetric part
  double quadratic_form(std::span<const double> x) const;

  /// True if A is not symmetric.
  bool unsymmetric() const { return end_rows || !skew.empty(); }
  /// x . (A - T) y of x(i), y(i): of the end rows, where x has its first and last entry, y three at either end, and of
  /// the skew part, which has all.
  auto unsymmetric_product(auto&& x, auto&& y) const {
    const std::size_t n = size();
    decltype(x(n) * y(n)) sum = 0.0 * y(0);
    if (end_rows)
      for (std::size_t k = 0; k < 3; ++k)
        sum += x(0) * (end_rows->first[k] * y(k)) + x(n - 1) * (end_rows->last[k] * y(n - 1 - k));
    for (std::size_t i = 0; i < skew.size(); ++i) sum += skew[i] * (x(i) * y(i + 1) - x(i + 1) * y(i));
    return sum;
  }
};

/// Entries of a field over n unknowns that unsymmetric_product() looks at: all of them, or, of a matrix without a skew
/// part, six: of unknowns 0, 1, 2, n-3, n-2, n-1, and within them where there are fewer.
struct RowValues {
  std::span<const double> values;  ///< six or n
  std::size_t n = values.size();   ///< unknowns
  /// The value of unknown i: one of the first or last three where only six are held.
  double operator()(std::size_t i) const { return i < 3 ? values[i] : values[values.size() - (n - i)]; }
};
/// Those of at(i), into `values` of six or n entries.
void row_values(std::size_t n, auto&& at, std::span<double> values) {
  if (values.size() == n) {
    for (std::size_t i = 0; i < n; ++i) values[i] = at(i);
    return;
  }
  for (std::size_t k = 0; k < 3; ++k) {
    const std::size_t inwards = std::min(k, n - 1);
    values[k] = at(inwards), values[5 - k] = at(n - 1 - inwards);
  }
}

/// A = L D L^T of a symmetric positive definite tridiagonal matrix; O(n) to build, O(n) to solve. With end rows A = L D
/// U without pivoting: L has one entry beside its bidiagonal, (n-1, n-3), and U one, (0, 2); but for those and four
/// more L = U^T. With a skew part neither L is the transpose of U.
class TridiagonalFactor {
 public:
  TridiagonalFactor() = default;
  /// The factor of a matrix, see factorise().
  explicit TridiagonalFactor(const SymmetricTridiagonal& matrix) { factorise(matrix); }

  /// Rebuilds the factor in place; allocates only when the size grows.
  /// @throws std::domain_error when a pivot is not positive: a symmetric matrix is not positive definite then.
  void factorise(const SymmetricTridiagonal& matrix);

  /// x <- A^{-1} x
  void solve(std::span<double> x) const;

  std::size_t size() const { return inverse_pivot_.size(); }  ///< n

 private:
  // Where L and U are no transposes of each other.
  struct Ends {
    double upper_01, upper_02, upper_12;  // U(0,1), U(0,2), U(1,2)
    double upper_last;                    // U(n-2, n-1)
    double lower_last;                    // L(n-1, n-3)
  };

  void factorise_ends(const SymmetricTridiagonal& matrix);
  void substitute_ends(std::span<double> x) const;
  const double* upper() const { return upper_.empty() ? lower_.data() : upper_.data(); }

  std::vector<double> lower_;          // L(i+1,i); empty for a diagonal matrix
  std::vector<double> upper_;          // U(i,i+1), where it is another one
  std::vector<double> inverse_pivot_;  // 1 / D(i,i)
  std::optional<Ends> ends_;
};

/// Diagonal of A^{-1} in O(n): from the pivots of the eliminations that start at either end, and for what end rows add
/// to that by Woodbury's formula.
std::vector<double> inverse_diagonal(const SymmetricTridiagonal& matrix);

}  // namespace viscobar

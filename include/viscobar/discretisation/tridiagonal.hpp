#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <span>
#include <vector>

namespace viscobar {

/// Entries of one row of a matrix beside its symmetric part, in the columns row, row + 1 and row + 2, or row, row - 1
/// and row - 2: as the rows of the ends of a bar have them.
struct OneSidedRow {
  std::size_t row = 0;              ///< r
  bool leftwards = false;           ///< columns r - k
  std::array<double, 3> entries{};  ///< of columns r, r + 1, r + 2, or r, r - 1, r - 2

  /// Column of entry k.
  std::size_t column(std::size_t k) const { return leftwards ? row - k : row + k; }
  /// entries . x of its columns
  double times(std::span<const double> x) const {
    return entries[0] * x[row] + entries[1] * x[column(1)] + entries[2] * x[column(2)];
  }
};

/// Tridiagonal matrix A, symmetric but for its one-sided rows and its skew part: A = T + (skew part) + (one-sided
/// rows), T(i,i) = diagonal[i], T(i,i+1) = T(i+1,i) = off_diagonal[i]. A diagonal matrix has an empty off_diagonal, a
/// symmetric one no one-sided rows and no skew part: nothing is stored or multiplied for what is not there.
struct BandedMatrix {
  std::vector<double> diagonal;      ///< n
  std::vector<double> off_diagonal;  ///< n - 1, or empty
  /// In rising order, a node's to the left before its to the right; of a bar alone its end rows, the first and the
  /// last.
  std::vector<OneSidedRow> one_sided{};
  std::vector<double> skew{};  ///< n - 1, or empty: it is added to A(i,i+1) and taken from A(i+1,i)
  /// Rows r, rising, that an infinite spring ties to r + 1, which no one-sided row goes across: x_r = x_{r+1}, in place
  /// of the rows their sum.
  std::vector<std::size_t> ties{};

  std::size_t size() const { return diagonal.size(); }  ///< n

  /// A(i,i)
  double diagonal_entry(std::size_t i) const;
  /// A(i,i+1) and A(i+1,i), without one-sided rows.
  double above(std::size_t i) const { return skew.empty() ? off_diagonal[i] : off_diagonal[i] + skew[i]; }
  double below(std::size_t i) const { return skew.empty() ? off_diagonal[i] : off_diagonal[i] - skew[i]; }  ///< below
  /// Makes A(i,i+1) and A(i+1,i) zero, but for one-sided rows.
  void uncouple(std::size_t i) {
    off_diagonal[i] = 0.0;
    if (!skew.empty()) skew[i] = 0.0;
  }
  /// Ties row i to i + 1; behind all that are tied.
  void tie(std::size_t i) {
    if (off_diagonal.empty()) off_diagonal.resize(size() - 1);
    ties.push_back(i);
  }
  /// Entries of row i towards one side, beside those of T; zeros where it has none.
  std::array<double, 3> one_sided_entries(std::size_t i, bool leftwards) const {
    for (const OneSidedRow& one : one_sided)
      if (one.row == i && one.leftwards == leftwards) return one.entries;
    return {};
  }
  /// Entries of the first or the last row, from the end inwards.
  std::array<double, 3> end_row(bool last) const;
  /// True if no one-sided row is that of a node inside.
  bool one_sided_at_ends() const {
    return std::ranges::all_of(one_sided, [n = size()](const OneSidedRow& r) { return r.row == 0 || r.row + 1 == n; });
  }
  /// Takes from one-sided rows what couples those for which out(i) holds to others.
  template <class Out>
  void uncouple_one_sided(Out&& out) {
    for (OneSidedRow& one : one_sided)
      for (std::size_t k = 1; k < 3; ++k)
        if (out(one.row) || out(one.column(k))) one.entries[k] = 0.0;
  }
  /// True if its off_diagonal is missing.
  bool is_diagonal() const { return off_diagonal.empty(); }
  BandedMatrix& operator*=(double factor);  ///< of all entries
  bool finite() const;                      ///< all entries are numbers, an infinite one of the diagonal among them

  /// out = A x. `out` and `x` have n entries and do not overlap.
  void multiply(std::span<const double> x, std::span<double> out) const;

  /// x . T x, of the symmetric part
  double quadratic_form(std::span<const double> x) const;

  /// True if A is not symmetric.
  bool unsymmetric() const { return !one_sided.empty() || !skew.empty(); }
  /// x . R y of the one-sided rows R, x(i) and y(i) being asked for in their rows and columns alone: those of the ends
  /// for the first and last entry of x, and three of y at either end.
  auto one_sided_product(auto&& x, auto&& y) const {
    decltype(x(size()) * y(size())) sum = 0.0 * y(0);
    auto parts = std::array{sum, sum, sum};
    for (const OneSidedRow& one : one_sided) {
      const auto at = x(one.row);
      for (std::size_t k = 0; k < 3; ++k) parts[k] += at * (one.entries[k] * y(one.column(k)));
    }
    for (const auto& part : parts) sum += part;
    return sum;
  }
  /// x . (A - T) y: that of one-sided rows, and of the skew part, which asks for all.
  auto unsymmetric_product(auto&& x, auto&& y) const {
    auto sum = one_sided_product(x, y);
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

/// A = L D L^T of a symmetric positive definite tridiagonal matrix; O(n) to build, O(n) to solve. One-sided rows make
/// it A = L D U, without pivoting or fill. A row r to the left gives L the entry (r, r - 2), one to the right gives U
/// the entry (r, r + 2); at the rows beside them L is not the transpose of U. With a skew part it nowhere is. Of two
/// rows that are tied the first has an infinite pivot. It hands the second what is left of it: L(r + 1, r) = U(r, r +
/// 1) = -1.
template <class Real>
class TridiagonalFactorOf {
 public:
  TridiagonalFactorOf() = default;
  /// The factor of a matrix, see factorise().
  explicit TridiagonalFactorOf(const BandedMatrix& matrix) { factorise(matrix); }

  /// Rebuilds the factor in place; allocates only when the size grows.
  /// @throws std::domain_error where it is not positive definite
  void factorise(const BandedMatrix& matrix);

  /// x <- A^{-1} x
  void solve(std::span<Real> x) const;

  std::size_t size() const { return inverse_pivot_.size(); }  ///< n

  /// Diagonal of A^{-1}, where A has one-sided rows; O(n).
  std::vector<Real> inverse_diagonal() const;

 private:
  // Where L and U are no transposes of each other, at a row r that goes to one side.
  struct Patch {
    std::size_t row;
    bool leftwards;
    Real upper_before, lower_beyond;            // to the left: U(r-1, r), L(r, r-2)
    Real upper_here, upper_beyond, upper_next;  // to the right: U(r, r+1), U(r, r+2), U(r+1, r+2)
  };

  void factorise_patched(const BandedMatrix& matrix);
  void substitute_patched(std::span<Real> x) const;
  void sweep_forward(std::span<Real> x, std::size_t from, std::size_t to) const;
  const Real* upper() const { return upper_.empty() ? lower_.data() : upper_.data(); }

  std::vector<Real> lower_;          // L(i+1,i); empty for a diagonal matrix
  std::vector<Real> upper_;          // U(i,i+1), where it is another one
  std::vector<Real> inverse_pivot_;  // 1 / D(i,i)
  std::vector<Patch> patches_;       // in the order of the one-sided rows
  bool meet_ = false;                // true if rows are eliminated from both ends
};
extern template class TridiagonalFactorOf<double>;
extern template class TridiagonalFactorOf<long double>;
/// The factor in double numbers.
using TridiagonalFactor = TridiagonalFactorOf<double>;

/// Diagonal of A^{-1}, in O(n): from the pivots of the eliminations that start at either end, or with one-sided rows
/// from L, D and U.
std::vector<double> inverse_diagonal(const BandedMatrix& matrix);

}  // namespace viscobar

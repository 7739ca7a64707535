#include "discretisation/lane_factor.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace viscobar {

LaneFactor::LaneFactor(const BandedMatrix& matrix, double scale) : scale_(scale) {
  find_order(matrix);
  if (order_.rows == 0) {
    condensed_ = matrix;
    return;
  }
  const double d = matrix.diagonal[order_.first], e = matrix.off_diagonal[order_.first];
  eliminate_inner(d, e);
  condense(matrix, e);
}

LaneFactor LaneFactor::without_rows(const BandedMatrix& matrix) {
  LaneFactor factor;
  factor.order_ = {matrix.size()};
  factor.condensed_ = matrix;
  return factor;
}

// Rows that are alike, with what couples them to their neighbours, divided evenly; the rest goes to the ends.
void LaneFactor::find_order(const BandedMatrix& matrix) {
  const std::size_t n = matrix.size();
  order_ = {n};
  constexpr std::size_t fewest_rows = 4;  // fewer are not worth the interface
  if (n < fewest_rows * lane_count + 2 || matrix.off_diagonal.empty()) return;
  const auto& diagonal = matrix.diagonal;
  const auto& off = matrix.off_diagonal;
  const std::size_t middle = n / 2;
  const auto alike = [&](std::size_t i) {
    return diagonal[i] == diagonal[middle] && off[i - 1] == off[middle] && off[i] == off[middle];
  };
  std::size_t begin = middle, end = middle;
  while (begin > 1 && alike(begin - 1)) --begin;
  while (end + 1 < n && alike(end)) ++end;
  if (!matrix.one_sided.empty())
    begin = std::max<std::size_t>(begin, 3), end = std::min(end, n - 3);  // their entries stay
  if (end < begin + fewest_rows * lane_count) return;
  const std::size_t rest = (end - begin) % lane_count;
  order_.first = begin + rest / 2;
  order_.rows = (end - begin) / lane_count;
  order_.last = n - order_.first - order_.rows * lane_count;
}

void LaneFactor::eliminate_inner(double d, double e) {
  const std::size_t m = order_.rows - 1;
  // Below the rounding of rounding a neighbour's influence changes nothing; it would end in denormal numbers.
  const double negligible = std::abs(e) * std::pow(std::numeric_limits<double>::epsilon(), 2);
  lower_.assign(m + 1, 0.0);
  scaled_inverse_pivot_.resize(m);
  double pivot = d, influence = -e;
  for (std::size_t k = 0; k < m; ++k) {
    if (k > 0) {
      pivot = d - lower_[k] * e;
      influence *= -lower_[k];
    }
    if (!(pivot > 0.0)) throw std::domain_error("tridiagonal matrix is not positive definite");
    scaled_inverse_pivot_[k] = scale_ / pivot;
    lower_[k + 1] = e / pivot;
    if (reach_ == k && std::abs(influence) > negligible) {
      from_left_.push_back(influence / pivot);
      ++reach_;
    }
  }
}

void LaneFactor::condense(const BandedMatrix& matrix, double e) {
  const std::size_t first = order_.first, separators_end = first + lane_count, n = separators_end + order_.last;
  const std::size_t m = inner_rows(), skipped = matrix.size() - n;
  const double end_pull = e * lower_[m];                             // e^2 (T^{-1})_{00}
  const double through = reach_ == m ? e * from_left_[m - 1] : 0.0;  // -e^2 (T^{-1})_{0,m-1}
  condensed_.diagonal.resize(n);
  condensed_.off_diagonal.resize(n - 1);
  condensed_.one_sided = matrix.one_sided;
  for (OneSidedRow& one : condensed_.one_sided)
    if (one.row > 0) one.row = n - 1;
  for (std::size_t i = 0; i < n; ++i) {
    const std::size_t row = i < first ? i : i < separators_end ? first : i + skipped;
    condensed_.diagonal[i] = matrix.diagonal[row];
    if (i + 1 >= first && i + 1 < separators_end) condensed_.diagonal[i] -= end_pull;
    if (i >= first && i < separators_end) condensed_.diagonal[i] -= end_pull;
    if (i + 1 == n) break;
    const bool between = i + 1 >= first && i + 1 < separators_end;  // two separators, or the first and its neighbour
    condensed_.off_diagonal[i] = between ? through : matrix.off_diagonal[i < first ? i : i + skipped];
  }
}

}  // namespace viscobar

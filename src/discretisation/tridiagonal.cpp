#include "viscobar/discretisation/tridiagonal.hpp"

#include <cassert>
#include <stdexcept>

namespace viscobar {

EndRows EndRows::times(double factor) const {
  EndRows rows = *this;
  for (auto* row : {&rows.first, &rows.last})
    for (double& entry : *row) entry *= factor;
  return rows;
}

SymmetricTridiagonal& SymmetricTridiagonal::operator*=(double factor) {
  for (std::vector<double>* entries : {&diagonal, &off_diagonal, &skew})
    for (double& entry : *entries) entry *= factor;
  if (end_rows) end_rows = end_rows->times(factor);
  return *this;
}

double SymmetricTridiagonal::diagonal_entry(std::size_t i) const {
  double entry = diagonal[i];
  if (end_rows && i == 0) entry += end_rows->first[0];
  if (end_rows && i + 1 == size()) entry += end_rows->last[0];
  return entry;
}

void SymmetricTridiagonal::multiply(std::span<const double> x, std::span<double> out) const {
  const std::size_t n = size();
  assert(x.size() == n && out.size() == n);
  if (off_diagonal.empty()) {
    for (std::size_t i = 0; i < n; ++i) out[i] = diagonal[i] * x[i];
    return;
  }
  out[0] = diagonal[0] * x[0] + off_diagonal[0] * x[1];
  for (std::size_t i = 1; i + 1 < n; ++i)
    out[i] = off_diagonal[i - 1] * x[i - 1] + diagonal[i] * x[i] + off_diagonal[i] * x[i + 1];
  out[n - 1] = off_diagonal[n - 2] * x[n - 2] + diagonal[n - 1] * x[n - 1];
  for (std::size_t i = 0; i < skew.size(); ++i) {
    out[i] += skew[i] * x[i + 1];
    out[i + 1] -= skew[i] * x[i];
  }
  if (!end_rows) return;
  out[0] += end_rows->first_times(x);
  out[n - 1] += end_rows->last_times(x);
}

double SymmetricTridiagonal::quadratic_form(std::span<const double> x) const {
  double sum = 0.0;
  for (std::size_t i = 0; i < size(); ++i) sum += diagonal[i] * x[i] * x[i];
  for (std::size_t i = 0; i < off_diagonal.size(); ++i) sum += 2.0 * off_diagonal[i] * x[i] * x[i + 1];
  return sum;
}

void TridiagonalFactor::factorise(const SymmetricTridiagonal& matrix) {
  const std::size_t n = matrix.size();
  inverse_pivot_.resize(n);
  lower_.resize(matrix.off_diagonal.size());
  upper_.resize(matrix.skew.size());
  ends_.reset();
  if (matrix.end_rows) return factorise_ends(matrix);
  bool positive = true;
  for (std::size_t i = 0; i < n && lower_.empty(); ++i) {
    positive &= matrix.diagonal[i] > 0.0;
    inverse_pivot_[i] = 1.0 / matrix.diagonal[i];
  }
  for (std::size_t i = 0; i < n && !lower_.empty(); ++i) {
    double pivot = matrix.diagonal[i];
    if (i > 0) {
      const double above = matrix.above(i - 1), lower = matrix.below(i - 1) * inverse_pivot_[i - 1];
      lower_[i - 1] = lower;
      if (!upper_.empty()) upper_[i - 1] = above * inverse_pivot_[i - 1];
      pivot -= lower * above;
    }
    positive &= pivot > 0.0;
    inverse_pivot_[i] = 1.0 / pivot;
  }
  if (!positive) throw std::domain_error("tridiagonal matrix is not positive definite");
}

void TridiagonalFactor::factorise_ends(const SymmetricTridiagonal& matrix) {
  const std::size_t n = matrix.size();
  assert(n >= 3 && matrix.off_diagonal.size() + 1 == n);
  const auto& [first, last] = *matrix.end_rows;
  const std::vector<double>& d = matrix.diagonal;
  Ends& ends = ends_.emplace();
  bool positive = true;
  const auto pivot = [&](std::size_t i, double value) {
    positive &= value > 0.0;
    inverse_pivot_[i] = 1.0 / value;
  };
  pivot(0, d[0] + first[0]);
  ends.upper_01 = (matrix.above(0) + first[1]) * inverse_pivot_[0];
  ends.upper_02 = first[2] * inverse_pivot_[0];
  double before = 0.0, upper = ends.upper_01;  // U(i-2, i-1), U(i-1, i)
  for (std::size_t i = 1; i + 1 < n; ++i) {
    const double below = matrix.below(i - 1);
    lower_[i - 1] = below * inverse_pivot_[i - 1];
    pivot(i, d[i] - below * upper);
    before = upper;
    upper = (i == 1 ? matrix.above(1) - below * ends.upper_02 : matrix.above(i)) * inverse_pivot_[i];
    if (!upper_.empty()) upper_[i] = upper;
    if (i == 1) ends.upper_12 = upper;
  }
  ends.upper_last = upper;
  ends.lower_last = last[2] * inverse_pivot_[n - 3];
  const double beside = matrix.below(n - 2) + last[1] - last[2] * before;
  lower_[n - 2] = beside * inverse_pivot_[n - 2];
  pivot(n - 1, d[n - 1] + last[0] - beside * upper - (n == 3 ? last[2] * ends.upper_02 : 0.0));
  if (!positive) throw std::domain_error("a pivot of a tridiagonal matrix with end rows is not positive");
}

namespace {

// x_i <- x_i / D(i,i) - L(i+1,i) x_{i+1}, i = top - 1, ..., bottom. Four terms of the recurrence are condensed, see
// solve().
inline void sweep_back(const double* lower, const double* inverse_pivot, double* x, std::size_t top,
                       std::size_t bottom) {
  double carried = x[top];
  std::size_t i = top;
  for (; i >= bottom + 4; i -= 4) {
    const double m0 = -lower[i - 1], m1 = -lower[i - 2], m2 = -lower[i - 3], m3 = -lower[i - 4];
    const double b0 = x[i - 1] * inverse_pivot[i - 1], b1 = x[i - 2] * inverse_pivot[i - 2] + m1 * b0;
    const double b2 = x[i - 3] * inverse_pivot[i - 3] + m2 * b1, b3 = x[i - 4] * inverse_pivot[i - 4] + m3 * b2;
    const double m10 = m1 * m0, m210 = m2 * m10;
    x[i - 1] = b0 + m0 * carried;
    x[i - 2] = b1 + m10 * carried;
    x[i - 3] = b2 + m210 * carried;
    x[i - 4] = carried = b3 + (m3 * m210) * carried;
  }
  while (i-- > bottom) x[i] = carried = x[i] * inverse_pivot[i] - lower[i] * carried;
}

}  // namespace

void TridiagonalFactor::substitute_ends(std::span<double> x) const {
  const std::size_t n = size();
  x[n - 1] = (x[n - 1] - ends_->lower_last * x[n - 3]) * inverse_pivot_[n - 1];
  x[n - 2] = x[n - 2] * inverse_pivot_[n - 2] - ends_->upper_last * x[n - 1];
  if (n > 3) {
    sweep_back(upper(), inverse_pivot_.data(), x.data(), n - 2, 2);
    x[1] = x[1] * inverse_pivot_[1] - ends_->upper_12 * x[2];
  }
  x[0] = x[0] * inverse_pivot_[0] - ends_->upper_01 * x[1] - ends_->upper_02 * x[2];
}

void TridiagonalFactor::solve(std::span<double> x) const {
  const std::size_t n = size();
  assert(x.size() == n);
  if (lower_.empty()) {
    for (std::size_t i = 0; i < n; ++i) x[i] *= inverse_pivot_[i];
    return;
  }
  // Either sweep is a recurrence y_i = b_i + m_i y_{i-1}. Four terms of it are condensed without waiting for y_{i-1},
  // so that one multiplication in four is on the chain of dependencies.
  double carried = x[0];
  std::size_t i = 1;
  for (; i + 4 <= n; i += 4) {
    const double m0 = -lower_[i - 1], m1 = -lower_[i], m2 = -lower_[i + 1], m3 = -lower_[i + 2];
    const double b0 = x[i], b1 = x[i + 1] + m1 * b0, b2 = x[i + 2] + m2 * b1, b3 = x[i + 3] + m3 * b2;
    const double m10 = m1 * m0, m210 = m2 * m10;
    x[i] = b0 + m0 * carried;
    x[i + 1] = b1 + m10 * carried;
    x[i + 2] = b2 + m210 * carried;
    x[i + 3] = carried = b3 + (m3 * m210) * carried;
  }
  for (; i < n; ++i) x[i] = carried = x[i] - lower_[i - 1] * carried;

  if (ends_) return substitute_ends(x);
  x[n - 1] *= inverse_pivot_[n - 1];
  sweep_back(upper(), inverse_pivot_.data(), x.data(), n - 1, 0);
}

namespace {

// (T + e_0 f^T + e_{n-1} l^T)^{-1} = T^{-1} - T^{-1} [e_0 e_{n-1}] S^{-1} [f l]^T T^{-1},  S = I + [f l]^T T^{-1} [e_0
// e_{n-1}]
void add_end_rows(const SymmetricTridiagonal& matrix, std::vector<double>& inverse_diagonal) {
  const std::size_t n = matrix.size();
  SymmetricTridiagonal inner = matrix;
  inner.end_rows.reset();
  const TridiagonalFactor factor(inner);
  for (double& entry : inner.skew) entry = -entry;
  const TridiagonalFactor transposed(inner);
  const EndRows& rows = *matrix.end_rows;
  std::vector<double> left(n), right(n), first(n), last(n);
  left[0] = right[n - 1] = 1.0;
  for (std::size_t k = 0; k < 3; ++k) first[k] = rows.first[k], last[n - 1 - k] = rows.last[k];
  for (std::vector<double>* column : {&left, &right}) factor.solve(*column);
  for (std::vector<double>* column : {&first, &last}) transposed.solve(*column);
  const double s00 = 1.0 + rows.first_times(left), s01 = rows.first_times(right);
  const double s10 = rows.last_times(left), s11 = 1.0 + rows.last_times(right);
  const double determinant = s00 * s11 - s01 * s10;
  for (std::size_t i = 0; i < n; ++i)
    inverse_diagonal[i] -=
        (left[i] * (s11 * first[i] - s01 * last[i]) + right[i] * (s00 * last[i] - s10 * first[i])) / determinant;
}

}  // namespace

std::vector<double> inverse_diagonal(const SymmetricTridiagonal& matrix) {
  const std::size_t n = matrix.size();
  std::vector<double> forward(matrix.diagonal), backward(matrix.diagonal), result(n);
  if (!matrix.off_diagonal.empty()) {
    for (std::size_t i = 1; i < n; ++i) forward[i] -= matrix.above(i - 1) * matrix.below(i - 1) / forward[i - 1];
    for (std::size_t i = n - 1; i-- > 0;) backward[i] -= matrix.above(i) * matrix.below(i) / backward[i + 1];
  }
  for (std::size_t i = 0; i < n; ++i) result[i] = 1.0 / (forward[i] + backward[i] - matrix.diagonal[i]);
  if (matrix.end_rows) add_end_rows(matrix, result);
  return result;
}

}  // namespace viscobar

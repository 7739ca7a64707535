#include "viscobar/discretisation/tridiagonal.hpp"

#include <cassert>
#include <stdexcept>

namespace viscobar {

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
  double pivot = n ? matrix.diagonal[0] : 1.0;
  bool positive = pivot > 0.0;
  if (n) inverse_pivot_[0] = 1.0 / pivot;
  if (lower_.empty()) {
    for (std::size_t i = 1; i < n; ++i) {
      positive &= matrix.diagonal[i] > 0.0;
      inverse_pivot_[i] = 1.0 / matrix.diagonal[i];
    }
  } else {
    for (std::size_t i = 1; i < n; ++i) {
      const double off = matrix.off_diagonal[i - 1];
      const double lower = off * inverse_pivot_[i - 1];
      lower_[i - 1] = lower;
      pivot = matrix.diagonal[i] - lower * off;
      positive &= pivot > 0.0;
      inverse_pivot_[i] = 1.0 / pivot;
    }
  }
  if (!positive) throw std::domain_error("tridiagonal matrix is not positive definite");
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

  x[n - 1] = carried = x[n - 1] * inverse_pivot_[n - 1];
  for (i = n - 1; i >= 4; i -= 4) {
    const double m0 = -lower_[i - 1], m1 = -lower_[i - 2], m2 = -lower_[i - 3], m3 = -lower_[i - 4];
    const double b0 = x[i - 1] * inverse_pivot_[i - 1], b1 = x[i - 2] * inverse_pivot_[i - 2] + m1 * b0;
    const double b2 = x[i - 3] * inverse_pivot_[i - 3] + m2 * b1, b3 = x[i - 4] * inverse_pivot_[i - 4] + m3 * b2;
    const double m10 = m1 * m0, m210 = m2 * m10;
    x[i - 1] = b0 + m0 * carried;
    x[i - 2] = b1 + m10 * carried;
    x[i - 3] = b2 + m210 * carried;
    x[i - 4] = carried = b3 + (m3 * m210) * carried;
  }
  while (i-- > 0) x[i] = carried = x[i] * inverse_pivot_[i] - lower_[i] * carried;
}

std::vector<double> inverse_diagonal(const SymmetricTridiagonal& matrix) {
  const std::size_t n = matrix.size();
  std::vector<double> forward(matrix.diagonal), backward(matrix.diagonal), result(n);
  if (!matrix.off_diagonal.empty()) {
    for (std::size_t i = 1; i < n; ++i) {
      const double off = matrix.off_diagonal[i - 1];
      forward[i] -= off * off / forward[i - 1];
    }
    for (std::size_t i = n - 1; i-- > 0;) {
      const double off = matrix.off_diagonal[i];
      backward[i] -= off * off / backward[i + 1];
    }
  }
  for (std::size_t i = 0; i < n; ++i) result[i] = 1.0 / (forward[i] + backward[i] - matrix.diagonal[i]);
  return result;
}

}  // namespace viscobar

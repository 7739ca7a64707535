#include "schemes/span_constraint.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace viscobar {

SpanConstraint::SpanConstraint(const BandedMatrix& matrix)
    : matrix_(matrix),
      split_(matrix),
      monotone_(matrix.one_sided.empty() && matrix.skew.empty() &&
                std::all_of(matrix.off_diagonal.begin(), matrix.off_diagonal.end(), [](double o) { return o <= 0.0; })),
      active_(matrix.size(), nowhere),
      wanted_(active_) {
  split();
}

void SpanConstraint::split() {
  held_ = std::ranges::any_of(active_, [](unsigned char held) { return held != nowhere; });
  for (std::size_t i = 0; i < split_.off_diagonal.size(); ++i) {
    const bool apart = active_[i] | active_[i + 1];
    split_.off_diagonal[i] = apart ? 0.0 : matrix_.off_diagonal[i];
    if (!split_.skew.empty()) split_.skew[i] = apart ? 0.0 : matrix_.skew[i];
  }
  split_.one_sided = matrix_.one_sided;
  split_.uncouple_one_sided([this](std::size_t i) { return active_[i] != 0; });
  factor_.factorise(split_);
  ++factorisations_;
}

// True if no bound is passed.
bool SpanConstraint::meets(std::span<double> x) const {
  const double *const values = x.data(), *const lower = lower_.data(), *const upper = upper_.data();
  int passed = 0;
  for (std::size_t i = 0, n = x.size(); i < n; ++i) passed |= !(values[i] >= lower[i]) | !(values[i] <= upper[i]);
  return passed == 0;
}

bool SpanConstraint::solve(std::span<const double> b, std::span<const double> lower, std::span<const double> upper,
                           std::span<double> x, std::span<double> multiplier) {
  lower_ = lower, upper_ = upper;
  constexpr int patience = 8;
  const std::size_t n = matrix_.size();
  std::size_t fewest = n + 1, pivots = 0;
  int left = patience;
  double tolerance = 16.0 * std::numeric_limits<double>::epsilon();
  bool released = false;
  for (std::size_t i = 0; i < n && held_; ++i)
    if (active_[i] && std::isinf(bound(i))) active_[i] = nowhere, released = true;
  if (released) split();
  for (;;) {
    if (!held_) {
      std::ranges::copy(b, x.begin());
      factor_.solve(x);
      ++solves_;
      std::ranges::fill(multiplier, 0.0);
      if (meets(x)) return false;
    } else {
      pivot(b, x, multiplier);
    }
    const std::size_t wrong = mark_wrong(b, x, multiplier, tolerance);
    if (wrong == 0) break;
    if (wrong < fewest) {
      fewest = wrong;
      left = patience;
    }
    if (monotone_ || left > 0) {
      --left;
      active_ = wanted_;
    } else {
      std::size_t last = n - 1;
      while (wanted_[last] == active_[last]) --last;
      active_[last] = wanted_[last];
    }
    // In exact arithmetic either rule ends; a tie that rounding cannot decide ends because the tolerance grows.
    if (++pivots % (4 * n + 16) == 0) tolerance *= 2.0;
    split();
  }
  for (std::size_t i = 0; i < n; ++i) {
    x[i] = std::clamp(x[i], lower[i], upper[i]);
    multiplier[i] = active_[i] == at_upper ? std::min(multiplier[i], 0.0) : std::max(multiplier[i], 0.0);
  }
  return held_;
}

void SpanConstraint::pivot(std::span<const double> b, std::span<double> x, std::span<double> multiplier) {
  const std::size_t n = matrix_.size();
  for (std::size_t i = 0; i < n; ++i) {
    if (active_[i]) {
      x[i] = bound(i);
      continue;
    }
    x[i] = b[i];
    if (i > 0 && active_[i - 1]) x[i] -= matrix_.below(i - 1) * bound(i - 1);
    if (i + 1 < n && active_[i + 1]) x[i] -= matrix_.above(i) * bound(i + 1);
  }
  for (const OneSidedRow& one : matrix_.one_sided)
    for (std::size_t k = 1; k < 3; ++k)
      if (!active_[one.row] && active_[one.column(k)]) x[one.row] -= one.entries[k] * bound(one.column(k));
  factor_.solve(x);
  ++solves_;
  for (std::size_t i = 0; i < n; ++i)
    if (active_[i]) x[i] = bound(i);
  for (std::size_t i = 0; i < n; ++i) {
    multiplier[i] = 0.0;
    if (!active_[i]) continue;
    multiplier[i] = matrix_.diagonal[i] * x[i] - b[i];
    if (i > 0) multiplier[i] += matrix_.below(i - 1) * x[i - 1];
    if (i + 1 < n) multiplier[i] += matrix_.above(i) * x[i + 1];
    for (const OneSidedRow& one : matrix_.one_sided)
      if (one.row == i) multiplier[i] += one.times(x);
  }
}

std::size_t SpanConstraint::mark_wrong(std::span<const double> b, std::span<const double> x,
                                       std::span<const double> multiplier, double tolerance) {
  const std::size_t n = matrix_.size();
  std::size_t count = 0;
  for (std::size_t i = 0; i < n; ++i) {
    wanted_[i] = active_[i];
    if (active_[i] == nowhere && lower_[i] <= x[i] && x[i] <= upper_[i]) continue;
    // Rounding of the row's terms.
    double scale = matrix_.diagonal[i] * std::abs(x[i]) + std::abs(b[i]);
    if (i > 0) scale += std::abs(matrix_.off_diagonal[i - 1] * x[i - 1]);
    if (i + 1 < n) scale += std::abs(matrix_.off_diagonal[i] * x[i + 1]);
    for (const OneSidedRow& one : matrix_.one_sided)
      for (std::size_t k = 0; k < 3 && one.row == i; ++k) scale += std::abs(one.entries[k] * x[one.column(k)]);
    const double hidden = tolerance * scale;
    if (active_[i] == nowhere) {
      if (matrix_.diagonal[i] * (lower_[i] - x[i]) > hidden) wanted_[i] = at_lower;
      if (matrix_.diagonal[i] * (x[i] - upper_[i]) > hidden) wanted_[i] = at_upper;
    } else if ((active_[i] == at_lower ? -multiplier[i] : multiplier[i]) > hidden) {
      wanted_[i] = nowhere;
    }
    count += wanted_[i] != active_[i];
  }
  return count;
}

}  // namespace viscobar

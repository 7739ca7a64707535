#include "schemes/end_constraint.hpp"

#include <algorithm>
#include <cassert>

namespace viscobar {

EndConstraint::EndConstraint(const SymmetricTridiagonal& matrix, const std::vector<Bounded>& entries)
    : factor_(matrix) {
  assert(entries.size() <= 2);
  for (const Bounded& at : entries) {
    std::vector<double> column(matrix.size(), 0.0);
    column[at.entry] = at.sign;
    factor_.solve(column);
    columns_.push_back({at, std::move(column)});
  }
}

void EndConstraint::solve(std::span<double> x, std::span<const double> bound, std::span<double> multiplier) {
  factor_.solve(x);
  const std::size_t count = columns_.size();
  std::array<double, 2> excess{};  // of the unconstrained solution over its bound
  for (std::size_t k = 0; k < count; ++k) excess[k] = columns_[k].of(x) - bound[k];

  std::array<double, 2> lambda{};
  active_ = {};
  const auto compliance = [this](std::size_t k, std::size_t l) { return columns_[k].of(columns_[l].values); };
  if (count == 1) {
    if (excess[0] < 0.0) {
      active_ = {1, 0};
      lambda[0] = -excess[0] / compliance(0, 0);
    }
  } else if (excess[0] < 0.0 || excess[1] < 0.0) {
    const double g00 = compliance(0, 0), g11 = compliance(1, 1), g01 = compliance(0, 1), g10 = compliance(1, 0);
    // The excess of either end, times the other's compliance, while the other alone is held at its bound.
    const double excess_0 = g11 * excess[0] - g01 * excess[1];
    const double excess_1 = g00 * excess[1] - g10 * excess[0];
    if (excess[0] < 0.0 && excess_1 >= 0.0) {
      active_ = {1, 0};
      lambda[0] = -excess[0] / g00;
    } else if (excess[1] < 0.0 && excess_0 >= 0.0) {
      active_ = {0, 1};
      lambda[1] = -excess[1] / g11;
    } else {
      const double determinant = g00 * g11 - g01 * g10;
      active_ = {1, 1};
      lambda = {std::max(-excess_0 / determinant, 0.0), std::max(-excess_1 / determinant, 0.0)};
    }
  }
  for (std::size_t k = 0; k < count; ++k) multiplier[k] = lambda[k];
  if (!active_[0] && !active_[1]) return;
  const double *first = columns_.front().values.data(), *last = columns_.back().values.data();
  double* values = x.data();
  const std::size_t n = x.size();
#pragma GCC ivdep
  for (std::size_t i = 0; i < n; ++i) values[i] += lambda[0] * first[i] + lambda[1] * last[i];
  for (std::size_t k = 0; k < count; ++k)
    if (active_[k]) x[columns_[k].at.entry] = columns_[k].at.sign * bound[k];
}

}  // namespace viscobar

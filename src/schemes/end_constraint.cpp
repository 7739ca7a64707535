#include "schemes/end_constraint.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "discretisation/dense.hpp"

namespace viscobar {

EndConstraint::EndConstraint(const SymmetricTridiagonal& matrix, const std::vector<Bounded>& entries)
    : factor_(matrix), active_(entries.size(), 0) {
  for (const Bounded& at : entries) {
    std::vector<double> column(matrix.size(), 0.0);
    column[at.entry] = at.sign;
    if (at.joint) column[at.entry - 1] = -1.0;
    factor_.solve(column);
    columns_.push_back({at, std::move(column)});
  }
}

// On its bound bitwise.
void EndConstraint::put_on(const Column& column, double bound, std::span<double> x) const {
  const auto& [entry, sign, joint] = column.at;
  x[entry] = joint ? x[entry - 1] + bound : sign * bound;
}

// Begins with what lies beyond its bound; where many changes at once do not end, the first that is wrong alone, which
// does.
void EndConstraint::solve_many(std::span<double> x, std::span<const double> bound, std::span<double> multiplier) {
  const std::size_t count = columns_.size();
  const auto index = [](std::size_t k) { return static_cast<Eigen::Index>(k); };
  Eigen::VectorXd lambda(index(count)), excess(index(count));
  for (std::size_t k = 0; k < count; ++k) {
    excess[index(k)] = columns_[k].of(x) - bound[k];
    active_[k] = !std::isinf(bound[k]) && excess[index(k)] < 0.0;
  }
  for (std::size_t pivots = 0;; ++pivots) {
    Eigen::MatrixXd compliance = Eigen::MatrixXd::Identity(index(count), index(count));
    Eigen::VectorXd right = Eigen::VectorXd::Zero(index(count));
    for (std::size_t k = 0; k < count; ++k) {
      if (!active_[k]) continue;
      right[index(k)] = -excess[index(k)];
      for (std::size_t l = 0; l < count; ++l)
        compliance(index(k), index(l)) = active_[l] ? columns_[k].of(columns_[l].values) : 0.0;
    }
    lambda = solution(compliance, right);
    bool changed = false;
    for (std::size_t k = 0; k < count && pivots < 50 * count; ++k) {
      double clear = std::isinf(bound[k]) ? 1.0 : excess[index(k)];
      for (std::size_t l = 0; l < count; ++l)
        if (active_[l]) clear += lambda[index(l)] * columns_[k].of(columns_[l].values);
      const bool wrong = active_[k] ? lambda[index(k)] < 0.0 : clear < 0.0;
      if (!wrong) continue;
      active_[k] = active_[k] ? 0 : 1;
      changed = true;
      if (pivots >= count) break;
    }
    if (!changed) break;
  }
  for (std::size_t k = 0; k < count; ++k) {
    multiplier[k] = active_[k] ? std::max(lambda[index(k)], 0.0) : 0.0;
    if (active_[k])
      for (std::size_t i = 0; i < x.size(); ++i) x[i] += lambda[index(k)] * columns_[k].values[i];
  }
  for (std::size_t k = 0; k < count; ++k)
    if (active_[k]) put_on(columns_[k], bound[k], x);
}

void EndConstraint::solve(std::span<double> x, std::span<const double> bound, std::span<double> multiplier) {
  factor_.solve(x);
  const std::size_t count = columns_.size();
  if (count > 2) return solve_many(x, bound, multiplier);
  std::array<double, 2> excess{};  // of the unconstrained solution over its bound
  for (std::size_t k = 0; k < count; ++k) excess[k] = columns_[k].of(x) - bound[k];

  std::array<double, 2> lambda{};
  std::array<unsigned char, 2> active{};
  const auto compliance = [this](std::size_t k, std::size_t l) { return columns_[k].of(columns_[l].values); };
  if (count == 1) {
    if (excess[0] < 0.0) {
      active = {1, 0};
      lambda[0] = -excess[0] / compliance(0, 0);
    }
  } else if (excess[0] < 0.0 || excess[1] < 0.0) {
    const double g00 = compliance(0, 0), g11 = compliance(1, 1), g01 = compliance(0, 1), g10 = compliance(1, 0);
    // The excess of either end, times the other's compliance, while the other alone is held at its bound.
    const double excess_0 = g11 * excess[0] - g01 * excess[1];
    const double excess_1 = g00 * excess[1] - g10 * excess[0];
    if (excess[0] < 0.0 && excess_1 >= 0.0) {
      active = {1, 0};
      lambda[0] = -excess[0] / g00;
    } else if (excess[1] < 0.0 && excess_0 >= 0.0) {
      active = {0, 1};
      lambda[1] = -excess[1] / g11;
    } else {
      const double determinant = g00 * g11 - g01 * g10;
      active = {1, 1};
      lambda = {std::max(-excess_0 / determinant, 0.0), std::max(-excess_1 / determinant, 0.0)};
    }
  }
  for (std::size_t k = 0; k < count; ++k) multiplier[k] = lambda[k];
  std::copy_n(active.begin(), count, active_.begin());
  if (!active[0] && !active[1]) return;
  const double *first = columns_.front().values.data(), *last = columns_.back().values.data();
  double* values = x.data();
  const std::size_t n = x.size();
#pragma GCC ivdep
  for (std::size_t i = 0; i < n; ++i) values[i] += lambda[0] * first[i] + lambda[1] * last[i];
  for (std::size_t k = 0; k < count; ++k)
    if (active[k]) put_on(columns_[k], bound[k], x);
}

}  // namespace viscobar

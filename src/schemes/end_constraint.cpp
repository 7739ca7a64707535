#include "schemes/end_constraint.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace viscobar {

EndConstraint::EndConstraint(const BandedMatrix& matrix, const std::vector<Bounded>& entries)
    : factor_(matrix), active_(entries.size(), 0) {
  for (const Bounded& at : entries) {
    std::vector<double> column(matrix.size(), 0.0);
    column[at.entry] = at.sign;
    if (at.joint) column[at.entry - 1] = -1.0;
    factor_.solve(column);
    // Below the rounding of rounding an entry adds nothing; those of bars that nothing couples are zero.
    double largest = 0.0;
    for (const double value : column) largest = std::max(largest, std::abs(value));
    const double negligible = largest * std::pow(std::numeric_limits<double>::epsilon(), 2);
    const auto counts = [=](double value) { return std::abs(value) > negligible; };
    const auto begin = std::ranges::find_if(column, counts) - column.begin();
    const auto behind = std::find_if(column.rbegin(), column.rend(), counts) - column.rbegin();
    const std::size_t end = column.size() - static_cast<std::size_t>(behind);
    columns_.push_back({at, std::move(column), static_cast<std::size_t>(begin), end});
  }
  const std::size_t count = columns_.size();
  if (count <= 2) return;
  for (const Column& row : columns_)
    for (const Column& column : columns_) compliance_.push_back(row.of(column.values));
  rows_.resize(count * count);
  inverse_.resize(count * count);
  lambda_.resize(count);
  excess_.resize(count);
  held_.reserve(count);
  before_.reserve(count);
}

// On its bound bitwise.
void EndConstraint::put_on(const Column& column, double bound, std::span<double> x) const {
  const auto& [entry, sign, joint] = column.at;
  x[entry] = joint ? x[entry - 1] + bound : sign * bound;
}

// Inverts the rows of the compliance that are held, by elimination with partial pivoting in place, since a step
// allocates nothing. Neighbouring steps hold the same.
void EndConstraint::invert_held() {
  const std::size_t count = columns_.size(), held = held_.size();
  const auto row = [&](std::size_t i) { return &rows_[i * count]; };
  const auto inverse = [&](std::size_t i) { return &inverse_[i * count]; };
  for (std::size_t i = 0; i < held; ++i)
    for (std::size_t j = 0; j < held; ++j) {
      row(i)[j] = compliance_[held_[i] * count + held_[j]];
      inverse(i)[j] = i == j;
    }
  for (std::size_t k = 0; k < held; ++k) {
    std::size_t pivot = k;
    for (std::size_t i = k + 1; i < held; ++i)
      if (std::abs(row(i)[k]) > std::abs(row(pivot)[k])) pivot = i;
    std::swap_ranges(row(k), row(k) + held, row(pivot));
    std::swap_ranges(inverse(k), inverse(k) + held, inverse(pivot));
    for (std::size_t i = 0; i < held; ++i) {
      const double factor = i == k ? 0.0 : row(i)[k] / row(k)[k];
      if (factor == 0.0) continue;
      for (std::size_t j = k; j < held; ++j) row(i)[j] -= factor * row(k)[j];
      for (std::size_t j = 0; j < held; ++j) inverse(i)[j] -= factor * inverse(k)[j];
    }
  }
  for (std::size_t i = 0; i < held; ++i) {
    const double pivot = row(i)[i];
    for (std::size_t j = 0; j < held; ++j) inverse(i)[j] /= pivot;
  }
}

// Begins with those that were held; where many changes at once do not end, the first that is wrong alone, which does.
// An entry that is held without force is let go, so that the answer does not depend on where it begins.
void EndConstraint::solve_many(std::span<double> x, std::span<const double> bound, std::span<double> multiplier) {
  const std::size_t count = columns_.size();
  for (std::size_t k = 0; k < count; ++k) excess_[k] = columns_[k].of(x) - bound[k];  // infinite without a bound
  for (std::size_t pivots = 0;; ++pivots) {
    std::swap(held_, before_);
    held_.clear();
    for (std::size_t k = 0; k < count; ++k)
      if (active_[k]) held_.push_back(k);
    if (held_ != before_) invert_held();
    for (std::size_t i = 0; i < held_.size(); ++i) {
      lambda_[i] = 0.0;
      for (std::size_t j = 0; j < held_.size(); ++j) lambda_[i] -= inverse_[i * count + j] * excess_[held_[j]];
    }
    bool changed = false;
    for (std::size_t k = 0, i = 0; k < count && pivots < 50 * count; ++k) {
      bool wrong;
      if (active_[k]) {
        wrong = !(lambda_[i++] > 0.0);
      } else {
        double clear = excess_[k];
        for (std::size_t j = 0; j < held_.size(); ++j) clear += lambda_[j] * compliance_[k * count + held_[j]];
        wrong = clear < 0.0;
      }
      if (!wrong) continue;
      active_[k] ^= 1;
      changed = true;
      if (pivots >= count) break;
    }
    if (!changed) break;
  }
  std::ranges::fill(multiplier, 0.0);
  for (std::size_t i = 0; i < held_.size(); ++i) {
    const Column& column = columns_[held_[i]];
    multiplier[held_[i]] = std::max(lambda_[i], 0.0);
    const double lambda = lambda_[i], *of = column.values.data();
    double* const values = x.data();
#pragma GCC ivdep
    for (std::size_t j = column.begin; j < column.end; ++j) values[j] += lambda * of[j];
  }
  for (const std::size_t k : held_) put_on(columns_[k], bound[k], x);
}

void EndConstraint::solve(std::span<double> x, std::span<const double> bound, std::span<double> multiplier) {
  factor_.solve(x);
  const std::size_t count = columns_.size();
  if (count > 2) return solve_many(x, bound, multiplier);
  std::array<double, 2> excess{};  // of the unconstrained solution over its bound
  bool free = true;
  for (std::size_t k = 0; k < count; ++k) {
    excess[k] = columns_[k].of(x) - bound[k];
    free &= !(excess[k] < 0.0);
    multiplier[k] = 0.0;
    active_[k] = 0;
  }
  if (free) return;

  std::array<double, 2> lambda{};
  std::array<unsigned char, 2> active{};
  const auto compliance = [this](std::size_t k, std::size_t l) { return columns_[k].of(columns_[l].values); };
  if (count == 1) {
    active = {1, 0};
    lambda[0] = -excess[0] / compliance(0, 0);
  } else {
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
  const double *first = columns_.front().values.data(), *last = columns_.back().values.data();
  double* values = x.data();
  const std::size_t n = x.size();
#pragma GCC ivdep
  for (std::size_t i = 0; i < n; ++i) values[i] += lambda[0] * first[i] + lambda[1] * last[i];
  for (std::size_t k = 0; k < count; ++k)
    if (active[k]) put_on(columns_[k], bound[k], x);
}

}  // namespace viscobar

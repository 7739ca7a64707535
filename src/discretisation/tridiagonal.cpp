#include "viscobar/discretisation/tridiagonal.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "discretisation/lanes.hpp"
#include "discretisation/not_positive.hpp"

namespace viscobar {

bool BandedMatrix::finite() const {
  return std::ranges::none_of(diagonal, [](double one) { return std::isnan(one); }) &&
         std::ranges::all_of(off_diagonal, [](double one) { return std::isfinite(one); });
}

BandedMatrix& BandedMatrix::operator*=(double factor) {
  for (std::vector<double>* entries : {&diagonal, &off_diagonal, &skew})
    for (double& entry : *entries) entry *= factor;
  for (OneSidedRow& one : one_sided)
    for (double& entry : one.entries) entry *= factor;
  return *this;
}

double BandedMatrix::diagonal_entry(std::size_t i) const {
  double entry = diagonal[i];
  for (const OneSidedRow& one : one_sided)
    if (one.row == i) entry += one.entries[0];
  return entry;
}

std::array<double, 3> BandedMatrix::end_row(bool last) const {
  std::array<double, 3> row = one_sided_entries(last ? size() - 1 : 0, last);
  row[0] += last ? diagonal.back() : diagonal.front();
  if (!off_diagonal.empty()) row[1] += last ? off_diagonal.back() : off_diagonal.front();
  return row;
}

void BandedMatrix::multiply(std::span<const double> x, std::span<double> out) const {
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
  for (const OneSidedRow& one : one_sided) out[one.row] += one.times(x);
}

[[gnu::flatten]] double BandedMatrix::quadratic_form(std::span<const double> x) const {
  const double* const u = x.data();
  const auto on = [=, d = diagonal.data()](auto&& at) { return at(d) * at(u) * at(u); };
  const auto off = [=, o = off_diagonal.data()](auto&& at) { return at(o) * at(u) * at(u + 1); };
  return sum_by_lanes(size(), on) + 2.0 * sum_by_lanes(off_diagonal.size(), off);
}

namespace {

// So few rows are eliminated from both ends, which meet at n / 2: the chain of dependencies is half as long, and takes
// fewer operations than sweep_forward() and sweep_back(). From there on L(i+1,i) is U(i,i+1) of the way up.
bool from_both_ends(std::size_t rows) { return rows >= 3 && rows <= 12; }

template <class Real>
inline void solve_from_both_ends(const Real* lower, const Real* inverse_pivot, Real* x, std::size_t n) {
  const std::size_t middle = n / 2;
  Real left = x[0], right = x[n - 1];
  std::size_t i = 1, j = n - 2;
  for (; j > middle; ++i, --j) {
    x[i] = left = x[i] - lower[i - 1] * left;
    x[j] = right = x[j] - lower[j] * right;
  }
  if (i < middle) x[i] = left = x[i] - lower[i - 1] * left, ++i;
  left = right = x[middle] = (x[middle] - lower[middle - 1] * left - lower[middle] * right) * inverse_pivot[middle];
  for (j = middle + 1; j < n; ++j) {
    --i;
    x[i] = left = x[i] * inverse_pivot[i] - lower[i] * left;
    x[j] = right = x[j] * inverse_pivot[j] - lower[j - 1] * right;
  }
  if (i > 0) x[0] = x[0] * inverse_pivot[0] - lower[0] * left;
}

}  // namespace

template <class Real>
void TridiagonalFactorOf<Real>::factorise(const BandedMatrix& matrix) {
  const std::size_t n = matrix.size();
  inverse_pivot_.resize(n);
  lower_.resize(matrix.off_diagonal.size());
  upper_.resize(matrix.skew.size());
  patches_.clear();
  meet_ = false;
  if (!matrix.one_sided.empty() || !matrix.ties.empty()) return factorise_patched(matrix);
  bool positive = true;
  for (std::size_t i = 0; i < n && lower_.empty(); ++i) {
    positive &= matrix.diagonal[i] > 0.0;
    inverse_pivot_[i] = 1 / Real(matrix.diagonal[i]);
  }
  meet_ = from_both_ends(n) && !lower_.empty() && upper_.empty();
  const std::size_t middle = meet_ ? n / 2 : n - 1;
  Real lost = 0;  // of the pivot at which both ends meet
  for (std::size_t i = n - 1; i > middle; --i) {
    const Real pivot = matrix.diagonal[i] - lost, off = matrix.off_diagonal[i - 1];
    positive &= pivot > 0.0;
    inverse_pivot_[i] = 1 / pivot;
    lower_[i - 1] = off * inverse_pivot_[i];
    lost = lower_[i - 1] * off;
  }
  for (std::size_t i = 0; i <= middle && !lower_.empty(); ++i) {
    Real pivot = i == middle ? matrix.diagonal[i] - lost : matrix.diagonal[i];
    if (i > 0) {
      const Real above = matrix.above(i - 1), lower = matrix.below(i - 1) * inverse_pivot_[i - 1];
      lower_[i - 1] = lower;
      if (!upper_.empty()) upper_[i - 1] = above * inverse_pivot_[i - 1];
      pivot -= lower * above;
    }
    positive &= pivot > 0.0;
    inverse_pivot_[i] = 1 / pivot;
  }
  if (!positive) throw NotPositive(matrix.finite());
}

template <class Real>
void TridiagonalFactorOf<Real>::factorise_patched(const BandedMatrix& matrix) {
  const std::size_t n = matrix.size();
  assert(matrix.off_diagonal.size() + 1 == n);
  patches_.reserve(matrix.one_sided.size());
  auto row = matrix.one_sided.begin();
  const auto rows_end = matrix.one_sided.end();
  auto tie = matrix.ties.begin();
  bool positive = true, tied = false;
  Real before = 0.0, upper = 0.0;              // U(i-2, i-1), U(i-1, i)
  Real skipping = 0.0, skipping_before = 0.0;  // U(i-1, i+1), U(i-2, i)
  Real handed = 0.0;                           // the pivot of the row before, tied to this one
  for (std::size_t i = 0; i < n; ++i) {
    Real pivot = matrix.diagonal[i], below = i > 0 ? matrix.below(i - 1) : 0.0;
    Real above = i + 1 < n ? matrix.above(i) : 0.0, beyond = 0.0, lost = 0.0;
    for (; row != rows_end && row->row == i; ++row) {
      patches_.push_back({i, row->leftwards, 0.0, 0.0, 0.0, 0.0, 0.0});
      pivot += row->entries[0];
      if (!row->leftwards) {
        above += row->entries[1], beyond = row->entries[2];
        continue;
      }
      patches_.back().upper_before = upper;
      patches_.back().lower_beyond = row->entries[2] * inverse_pivot_[i - 2];
      below = below + row->entries[1] - row->entries[2] * before;
      lost = row->entries[2] * skipping_before;
    }
    if (tied) below = handed;
    if (i > 0) {
      lower_[i - 1] = tied ? -1.0 : below * inverse_pivot_[i - 1];
      pivot -= below * upper;
    }
    if (lost != 0.0) pivot -= lost;
    positive &= pivot > 0.0;
    inverse_pivot_[i] = 1 / pivot;
    if (skipping != 0.0) above -= below * skipping;
    before = upper;
    upper = above * inverse_pivot_[i];
    skipping_before = skipping;
    skipping = beyond * inverse_pivot_[i];
    tied = tie != matrix.ties.end() && *tie == i;
    if (tied) {
      ++tie;
      handed = pivot, inverse_pivot_[i] = 0.0, upper = -1.0;
    }
    if (!upper_.empty() && i + 1 < n) upper_[i] = upper;
    for (auto patch = patches_.rbegin(); patch != patches_.rend() && patch->row + 1 >= i; ++patch) {
      if (patch->leftwards) continue;
      if (patch->row == i)
        patch->upper_here = upper, patch->upper_beyond = skipping;
      else
        patch->upper_next = upper;
    }
  }
  if (!positive) throw NotPositive(matrix.finite());
}

namespace {

// x_i <- x_i / D(i,i) - L(i+1,i) x_{i+1}, i = top - 1, ..., bottom. Four terms of the recurrence are condensed, see
// solve().
template <class Real>
inline void sweep_back(const Real* lower, const Real* inverse_pivot, Real* x, std::size_t top, std::size_t bottom) {
  Real carried = x[top];
  std::size_t i = top;
  for (; i >= bottom + 4; i -= 4) {
    const Real l0 = lower[i - 1], l1 = lower[i - 2], l2 = lower[i - 3], l3 = lower[i - 4];
    const Real b0 = x[i - 1] * inverse_pivot[i - 1], b1 = x[i - 2] * inverse_pivot[i - 2] - l1 * b0;
    const Real b2 = x[i - 3] * inverse_pivot[i - 3] - l2 * b1, b3 = x[i - 4] * inverse_pivot[i - 4] - l3 * b2;
    const Real l10 = l1 * l0, l210 = l2 * l10;
    x[i - 1] = b0 - l0 * carried;
    x[i - 2] = b1 + l10 * carried;
    x[i - 3] = b2 - l210 * carried;
    x[i - 4] = carried = b3 + (l3 * l210) * carried;
  }
  while (i-- > bottom) x[i] = carried = x[i] * inverse_pivot[i] - lower[i] * carried;
}

}  // namespace

template <class Real>
void TridiagonalFactorOf<Real>::substitute_patched(std::span<Real> x) const {
  std::size_t top = size() - 1;  // solved from there on
  x[top] *= inverse_pivot_[top];
  const auto sweep = [&](std::size_t bottom) {
    if (top > bottom) sweep_back(upper(), inverse_pivot_.data(), x.data(), top, bottom), top = bottom;
  };
  for (auto patch = patches_.rbegin(); patch != patches_.rend(); ++patch) {
    const std::size_t r = patch->row;
    if (patch->leftwards) {
      sweep(r);
      x[r - 1] = x[r - 1] * inverse_pivot_[r - 1] - patch->upper_before * x[r];
      top = r - 1;
      continue;
    }
    sweep(r + 2);
    if (top > r + 1) x[r + 1] = x[r + 1] * inverse_pivot_[r + 1] - patch->upper_next * x[r + 2];
    x[r] = x[r] * inverse_pivot_[r] - patch->upper_here * x[r + 1] - patch->upper_beyond * x[r + 2];
    top = r;
  }
  sweep(0);
}

// Takes x_from from what follows, up to x_to. The recurrence is y_i = b_i - l_i y_{i-1}. Four terms of it are condensed
// without waiting for y_{i-1}, so that one multiplication in four is on the chain of dependencies.
template <class Real>
inline void TridiagonalFactorOf<Real>::sweep_forward(std::span<Real> of, std::size_t from, std::size_t to) const {
  const Real* const lower = lower_.data();
  Real* const x = of.data();
  Real carried = x[from];
  std::size_t i = from + 1;
  for (; i + 3 <= to; i += 4) {
    const Real l0 = lower[i - 1], l1 = lower[i], l2 = lower[i + 1], l3 = lower[i + 2];
    const Real b0 = x[i], b1 = x[i + 1] - l1 * b0, b2 = x[i + 2] - l2 * b1, b3 = x[i + 3] - l3 * b2;
    const Real l10 = l1 * l0, l210 = l2 * l10;
    x[i] = b0 - l0 * carried;
    x[i + 1] = b1 + l10 * carried;
    x[i + 2] = b2 - l210 * carried;
    x[i + 3] = carried = b3 + (l3 * l210) * carried;
  }
  for (; i <= to; ++i) x[i] = carried = x[i] - lower[i - 1] * carried;
}

template <class Real>
void TridiagonalFactorOf<Real>::solve(std::span<Real> x) const {
  const std::size_t n = size();
  assert(x.size() == n);
  if (lower_.empty()) {
    for (std::size_t i = 0; i < n; ++i) x[i] *= inverse_pivot_[i];
    return;
  }
  if (meet_) return solve_from_both_ends(lower_.data(), inverse_pivot_.data(), x.data(), n);
  std::size_t from = 0;
  for (const Patch& patch : patches_) {
    if (!patch.leftwards) continue;
    sweep_forward(x, from, patch.row);
    x[patch.row] -= patch.lower_beyond * x[patch.row - 2];
    from = patch.row;
  }
  sweep_forward(x, from, n - 1);
  if (!patches_.empty()) return substitute_patched(x);
  x[n - 1] *= inverse_pivot_[n - 1];
  sweep_back(upper(), inverse_pivot_.data(), x.data(), n - 1, 0);
}

// Z = A^{-1} = U^{-1} D^{-1} L^{-1}, so Z = D^{-1} L^{-1} + (1 - U) Z and Z = U^{-1} D^{-1} + Z (1 - L): row by row
// from the last one these have the entries that are at most two beside the diagonal by those behind them.
template <class Real>
std::vector<Real> TridiagonalFactorOf<Real>::inverse_diagonal() const {
  assert(!meet_);
  const std::size_t n = size();
  std::vector<Real> result(n);
  const auto along = [n](std::vector<Real> entries) {
    entries.resize(n + 1, Real(0));
    return entries;
  };
  std::vector<Real> lower = along(lower_), upper = along(upper_.empty() ? lower_ : upper_);
  std::vector<Real> lower_beyond(n + 1, Real(0)), upper_beyond = lower_beyond;  // L(i+2,i), U(i,i+2)
  for (const Patch& patch : patches_) {
    const std::size_t r = patch.row;
    if (patch.leftwards)
      upper[r - 1] = patch.upper_before, lower_beyond[r - 2] = patch.lower_beyond;
    else
      upper[r] = patch.upper_here, upper_beyond[r] = patch.upper_beyond, upper[r + 1] = patch.upper_next;
  }
  Real next = 0, after = 0, above = 0, below = 0;  // Z(i+1,i+1), Z(i+2,i+2), Z(i+1,i+2), Z(i+2,i+1)
  for (std::size_t i = n; i-- > 0;) {
    const Real u = upper[i], u2 = upper_beyond[i], l = lower[i], l2 = lower_beyond[i];
    const Real right = -u * next - u2 * below, down = -next * l - above * l2, far_down = -below * l - after * l2;
    result[i] = inverse_pivot_[i] - u * down - u2 * far_down;
    after = next, next = result[i], above = right, below = down;
  }
  return result;
}

template class TridiagonalFactorOf<double>;
template class TridiagonalFactorOf<long double>;

std::vector<double> inverse_diagonal(const BandedMatrix& matrix) {
  if (!matrix.one_sided.empty()) return TridiagonalFactor(matrix).inverse_diagonal();
  const std::size_t n = matrix.size();
  std::vector<double> forward(matrix.diagonal), backward(matrix.diagonal), result(n);
  if (!matrix.off_diagonal.empty()) {
    for (std::size_t i = 1; i < n; ++i) forward[i] -= matrix.above(i - 1) * matrix.below(i - 1) / forward[i - 1];
    for (std::size_t i = n - 1; i-- > 0;) backward[i] -= matrix.above(i) * matrix.below(i) / backward[i + 1];
  }
  for (std::size_t i = 0; i < n; ++i) result[i] = 1.0 / (forward[i] + backward[i] - matrix.diagonal[i]);
  return result;
}

}  // namespace viscobar

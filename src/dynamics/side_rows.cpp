#include "viscobar/dynamics/side_rows.hpp"

#include <algorithm>
#include <functional>
#include <utility>

namespace viscobar {

namespace {

bool varies(const std::vector<double>& values) {
  return std::ranges::adjacent_find(values, std::not_equal_to{}) != values.end();
}

}  // namespace

SideRows::SideRows(BandedMatrix mass, std::vector<double> stiffness, std::vector<double> drag)
    : mass_(std::move(mass)),
      stiffness_(std::move(stiffness)),
      drag_(std::move(drag)),
      skew_(!mass_.is_diagonal() && (!mass_.skew.empty() || varies(stiffness_) || varies(drag_))) {
  for (std::size_t j = 0; skew_ && has_stiffness() && j < mass_.off_diagonal.size(); ++j)
    skew_stiffness_.push_back(0.5 * (mass_.above(j) * stiffness_[j + 1] - mass_.below(j) * stiffness_[j]));
}

double SideRows::largest_stiffness() const { return stiffness_.empty() ? 0.0 : std::ranges::max(stiffness_); }

double SideRows::largest_drag() const { return drag_.empty() ? 0.0 : std::ranges::max(drag_); }

void SideRows::subtract(std::span<const double> u, std::span<const double> w, std::size_t first, double left,
                        double right, std::span<double> out) const {
  const std::size_t n = out.size(), last = mass_.size() - 1;
  double* const force = out.data();
  const auto from_first = [first](const std::vector<double>& of) { return of.empty() ? nullptr : of.data() + first; };
  const double* const diagonal = from_first(mass_.diagonal);
  const double *const off = from_first(mass_.off_diagonal), *const skew = from_first(mass_.skew);
  const bool coupled = !mass_.is_diagonal();
  // r(i) of unknown i; below(i) and above(i) are beside row i.
  const auto inside = [=](auto&& r, auto&& below, auto&& above) {
#pragma GCC ivdep
    for (std::size_t i = 1; i + 1 < n; ++i)
      force[i] = force[i] - diagonal[i] * r(i) - below(i) * r(i - 1) - above(i) * r(i + 1);
  };
  const auto rows = [&](auto&& r) {
    const auto at = [&](std::size_t j) {
      if (first <= j && j < first + n) return r(j - first);
      return (j < first ? left : right) * stiffness(j);
    };
    const auto end = [&](std::size_t i) {
      const std::size_t j = first + i;
      force[i] = force[i] - diagonal[i] * r(i);
      if (coupled && j > 0) force[i] -= mass_.below(j - 1) * at(j - 1);
      if (coupled && j < last) force[i] -= mass_.above(j) * at(j + 1);
    };
    if (n > 0) end(0);
    if (n > 1) end(n - 1);
    if (!coupled)
      for (std::size_t i = 1; i + 1 < n; ++i) force[i] -= diagonal[i] * r(i);
    else if (mass_.skew.empty())
      inside(
          r, [off](std::size_t i) { return off[i - 1]; }, [off](std::size_t i) { return off[i]; });
    else
      inside(
          r, [=](std::size_t i) { return off[i - 1] - skew[i - 1]; }, [=](std::size_t i) { return off[i] + skew[i]; });
    for (const OneSidedRow& one : mass_.one_sided)
      for (std::size_t k = 0; k < 3 && one.row >= first && one.row < first + n; ++k)
        force[one.row - first] -= one.entries[k] * at(one.column(k));
  };
  const double *const springs = from_first(stiffness_), *const drags = from_first(drag_);
  if (!has_drag() && has_stiffness())
    rows([=, u = u.data()](std::size_t i) { return u[i] * springs[i]; });
  else if (!has_stiffness() && has_drag())
    rows([=, w = w.data()](std::size_t i) { return w[i] * drags[i]; });
  else if (has_stiffness())
    rows([=, u = u.data(), w = w.data()](std::size_t i) { return u[i] * springs[i] + w[i] * drags[i]; });
}

void SideRows::add_to(BandedMatrix& out, std::size_t first, double c, double k) const {
  const std::size_t n = out.size();
  const auto at = [&](std::size_t j) { return c * drag(j) + k * stiffness(j); };
  if (skew_) out.skew.resize(n - 1);  // zeros but for those of the inertia
  for (std::size_t i = 0; i < n; ++i) {
    const std::size_t j = first + i;
    out.diagonal[i] += mass_.diagonal[j] * at(j);
    if (i + 1 == n || mass_.is_diagonal()) continue;
    const double above = mass_.above(j) * at(j + 1), below = mass_.below(j) * at(j);
    out.off_diagonal[i] += 0.5 * (above + below);
    if (skew_) out.skew[i] += 0.5 * (above - below);
  }
  for (OneSidedRow& row : out.one_sided)
    for (const OneSidedRow& of_mass : mass_.one_sided)
      for (std::size_t m = 0; m < 3 && of_mass.row == row.row + first && of_mass.leftwards == row.leftwards; ++m)
        row.entries[m] += of_mass.entries[m] * at(of_mass.column(m));
}

}  // namespace viscobar

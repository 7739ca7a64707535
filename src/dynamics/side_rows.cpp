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

SideRows::SideRows(SymmetricTridiagonal mass, std::vector<double> stiffness, std::vector<double> drag)
    : mass_(std::move(mass)),
      stiffness_(std::move(stiffness)),
      drag_(std::move(drag)),
      skew_(!mass_.is_diagonal() && (!mass_.skew.empty() || varies(stiffness_) || varies(drag_))) {}

double SideRows::largest_stiffness() const { return stiffness_.empty() ? 0.0 : std::ranges::max(stiffness_); }

double SideRows::largest_drag() const { return drag_.empty() ? 0.0 : std::ranges::max(drag_); }

std::array<double, 3> SideRows::end_row(bool right) const {
  std::array<double, 3> row{};
  const std::size_t n = mass_.size();
  if (mass_.end_rows) row = right ? mass_.end_rows->last : mass_.end_rows->first;
  row[0] += right ? mass_.diagonal.back() : mass_.diagonal.front();
  if (n > 1 && !mass_.is_diagonal()) row[1] += right ? mass_.off_diagonal.back() : mass_.off_diagonal.front();
  return row;
}

void SideRows::add_to(SymmetricTridiagonal& out, std::size_t first, double c, double k) const {
  const std::size_t n = out.size(), last = mass_.size() - 1;
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
  if (!out.end_rows) return;
  for (std::size_t m = 0; m < 3; ++m) {
    if (first == 0) out.end_rows->first[m] += mass_.end_rows->first[m] * at(m);
    if (first + n == last + 1) out.end_rows->last[m] += mass_.end_rows->last[m] * at(last - m);
  }
}

}  // namespace viscobar

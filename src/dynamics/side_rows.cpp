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
      skew_(!mass_.is_diagonal() && (!mass_.skew.empty() || varies(stiffness_) || varies(drag_))) {}

double SideRows::largest_stiffness() const { return stiffness_.empty() ? 0.0 : std::ranges::max(stiffness_); }

double SideRows::largest_drag() const { return drag_.empty() ? 0.0 : std::ranges::max(drag_); }

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

#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <utility>
#include <vector>

#include "viscobar/discretisation/tridiagonal.hpp"
#include "viscobar/scene/scene.hpp"

namespace viscobar {

/// Resistance along the bar in the rows of its mass (docs/side.md). With r = k u + c u' at the nodes a row is
///
///     (rho M u'' + M r + E K u + eta K u')_i = (M f)_i,
///
/// M as for the inertia: exact to fourth order on `fourth_order`, and nothing in the row of a node without mass. It
/// stores 1/2 u.S(k) u and takes w.S(c) w, S(k) being the symmetric part of M diag(k) without the end rows of M. What
/// is left of w.M r is the power of the rows: the end rows, and where k varies along the bar a skew part.
///
/// Functions u(j), w(j), r(j) below are of all nodes j = 0, ..., J: numbers, or what is added and multiplied as such.
class SideRows {
 public:
  /// @param mass M of all nodes, without rho
  /// @param stiffness k at all nodes; empty: none
  /// @param drag c at all nodes; empty: none
  SideRows(BandedMatrix mass, std::vector<double> stiffness, std::vector<double> drag);

  const BandedMatrix& mass() const { return mass_; }          ///< M of all nodes
  bool has_stiffness() const { return !stiffness_.empty(); }  ///< k
  bool has_drag() const { return !drag_.empty(); }            ///< c
  /// True if M diag(k) or M diag(c) has a skew part, by which k and c vary.
  bool skew() const { return skew_; }
  /// True if the rows have a power of their own.
  bool has_row_power() const { return skew_ || !mass_.one_sided.empty(); }
  double stiffness(std::size_t j) const { return stiffness_.empty() ? 0.0 : stiffness_[j]; }  ///< k at node j
  double drag(std::size_t j) const { return drag_.empty() ? 0.0 : drag_[j]; }                 ///< c at node j

  double largest_stiffness() const;  ///< max k: (rho M)^{-1} M diag(k) has no eigenvalue above it / rho
  double largest_drag() const;       ///< max c, with the same bound for diag(c)

  /// r(j) of displacements u(j) and velocities w(j).
  auto resistance(auto&& u, auto&& w) const {
    return [this, u, w](std::size_t j) {
      auto sum = u(j) * stiffness(j);
      sum += w(j) * drag(j);
      return sum;
    };
  }

  /// out[i] -= (M r)_j for count nodes j from first on.
  template <class Out>
  void subtract(auto&& r, std::size_t first, std::size_t count, Out&& out) const {
    const std::size_t last = mass_.size() - 1;
    const bool coupled = !mass_.is_diagonal();
    auto before = first > 0 ? r(first - 1) : r(first);
    auto here = r(first);
    for (std::size_t i = 0; i < count; ++i) {
      const std::size_t j = first + i;
      auto next = j < last ? r(j + 1) : here;
      out[i] = out[i] - mass_.diagonal[j] * here;
      if (coupled && j > 0) out[i] = out[i] - mass_.below(j - 1) * before;
      if (coupled && j < last) out[i] = out[i] - mass_.above(j) * next;
      before = here;
      here = next;
    }
    for (const OneSidedRow& one : mass_.one_sided)
      for (std::size_t k = 0; k < 3 && one.row >= first && one.row < first + count; ++k)
        out[one.row - first] = out[one.row - first] - one.entries[k] * r(one.column(k));
  }

  /// The same of the resistance of u and w at the nodes from `first` on, of displacement left and right at fixed ends;
  /// many rows at once.
  void subtract(std::span<const double> u, std::span<const double> w, std::size_t first, double left, double right,
                std::span<double> out) const;

  /// Entries of the row of M of an end, from it inwards: columns 0, 1, 2 on the left.
  std::array<double, 3> end_row(bool right) const { return mass_.end_row(right); }
  /// The same of the row of node j, an end of a bar, inwards in that.
  std::array<double, 3> end_row(std::size_t j, bool right) const {
    std::array<double, 3> row = mass_.one_sided_entries(j, right);
    row[0] += mass_.diagonal[j];
    if (!mass_.is_diagonal()) row[1] += right ? mass_.below(j - 1) : mass_.above(j);
    return row;
  }
  /// (M r)_e of an end.
  double at_end(bool right, auto&& r) const { return at_end(right ? mass_.size() - 1 : 0, right, r); }
  /// (M r)_j of such a node j.
  double at_end(std::size_t j, bool right, auto&& r) const {
    const std::array<double, 3> row = end_row(j, right);
    const std::size_t inwards = right ? j : mass_.size() - 1 - j;
    double sum = 0.0;
    for (std::size_t k = 0; k < row.size() && k <= inwards; ++k) sum += row[k] * r(right ? j - k : j + k);
    return sum;
  }

  /// Adds M diag(k k_j + c c_j) over the unknowns, from node `first` on, to a matrix of their size.
  void add_to(BandedMatrix& out, std::size_t first, double c, double k) const;

  /// 1/2 u.S(k) u
  double energy(auto&& u) const { return 0.5 * energy_product(u, u); }
  /// u.S(k) s
  double energy_product(auto&& u, auto&& s) const { return has_stiffness() ? product(stiffness_, u, s) : 0.0; }
  /// w.S(c) w
  auto drag_power(auto&& w) const { return product(drag_, w, w); }
  /// w.M r - w.(S(k) u + S(c) w)
  auto row_power(auto&& w, auto&& u) const {
    decltype(w(0) * u(0)) sum = 0.0;
    if (const auto& rows = mass_.one_sided; !rows.empty()) {
      const auto r = resistance(u, w);
      const auto of = [&](const OneSidedRow& one, std::size_t k) -> decltype(sum) {
        return w(one.row) * one.entries[k] * r(one.column(k));
      };
      for (std::size_t k = 0; k < 3; ++k) {
        decltype(sum) part = of(rows[0], k);
        for (std::size_t i = 1; i < rows.size(); ++i) part += of(rows[i], k);
        sum += part;
      }
    }
    // The skew part of M diag(c) has none.
    if (skew_stiffness_.empty()) return sum;
    auto w_here = w(std::size_t{0});
    auto u_here = u(std::size_t{0});
    for (std::size_t j = 0; j < skew_stiffness_.size(); ++j) {
      const auto w_next = w(j + 1);
      const auto u_next = u(j + 1);
      sum += skew_stiffness_[j] * (w_here * u_next - w_next * u_here);
      w_here = w_next, u_here = u_next;
    }
    return sum;
  }

 private:
  // x.S(values) y
  auto product(const std::vector<double>& values, auto&& x, auto&& y) const {
    auto x_here = x(std::size_t{0}), y_here = y(std::size_t{0}), sum = x_here;
    sum = x_here * y_here * (mass_.diagonal[0] * values[0]);
    for (std::size_t j = 0; j + 1 < values.size(); ++j) {
      const auto x_next = x(j + 1), y_next = y(j + 1);
      if (!mass_.is_diagonal())
        sum +=
            (x_here * y_next + x_next * y_here) * (0.5 * (mass_.above(j) * values[j + 1] + mass_.below(j) * values[j]));
      sum += x_next * y_next * (mass_.diagonal[j + 1] * values[j + 1]);
      x_here = x_next, y_here = y_next;
    }
    return sum;
  }

  BandedMatrix mass_;
  std::vector<double> stiffness_, drag_;
  bool skew_ = false;
  std::vector<double> skew_stiffness_;  // of M diag(k), as in BandedMatrix; empty: none
};

}  // namespace viscobar

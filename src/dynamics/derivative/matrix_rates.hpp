#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "viscobar/dynamics/bar_system.hpp"
#include "viscobar/dynamics/sensitivity.hpp"

namespace viscobar {

/// Derivatives by a parameter p of the matrices of a bar or of several in line, without springs, dashpots and masses of
/// their ends. Of each bar
///
///     (rho M)' = (rho'/rho + L'/L) rho M,     (E K)' = (E' - E L'/L) K,     (eta K)' = (eta' - eta L'/L) K,
///
/// for M goes like L, and K like 1 / L, on graded meshes, too: nodes stay at their part of the bar. Joints that are
/// springs have their own rates. Where p changes a section they are differences (see Direction::Beside).
class MatrixRates {
 public:
  /// @param difference of the systems beside; null: of none
  MatrixRates(const BarSystem& bar, const Direction& direction, const LoadDifference* difference);

  /// The first three factors of a bar alone, relative to rho, eta and E; of a difference and of a chain 0.
  struct OfBar {
    double inertia = 0.0, viscosity = 0.0, modulus = 0.0;
  };
  const OfBar& of_bar() const { return of_bar_; }

  bool any() const { return inertial() || !elastic_.empty() || !viscous_.empty(); }
  bool inertial() const { return !inertia_.diagonal.empty(); }  ///< (rho M)' is not zero
  const BandedMatrix& inertia() const { return inertia_; }      ///< (rho M)' over the unknowns, where inertial()
  const BandedMatrix& whole() const { return whole_; }          ///< the same over all nodes, where the frame moves
  /// Entries of its row of a fixed end, inwards.
  const std::array<double, 3>& held(bool right) const { return held_[right]; }

  /// Derivatives of E and of eta over int dx / A of an element.
  double elastic(std::size_t element) const { return elastic_.empty() ? 0.0 : elastic_[element]; }
  double viscous(std::size_t element) const { return viscous_.empty() ? 0.0 : viscous_[element]; }  ///< of eta
  /// out[i] -= ((E K)' u)_i of displacements u(j) of all nodes, numbers or what is added and multiplied as such.
  template <class Out>
  void subtract_elastic(auto&& u, Out&& out) const {
    subtract(elastic_, u, out);
  }
  /// out[i] -= ((eta K)' w)_i
  template <class Out>
  void subtract_viscous(auto&& w, Out&& out) const {
    subtract(viscous_, w, out);
  }

  /// Relative change of what bars, bodies and joints are made of.
  double relative_change() const { return relative_change_; }

 private:
  void take_difference(const BarSystem& bar, const Direction& direction, const LoadDifference& difference,
                       const std::array<bool, 2>& massless);
  // Springs of elements between neighbouring nodes, by differences, which keep the digits of what is all but constant.
  void subtract(const std::vector<double>& springs, auto&& x, auto&& out) const {
    if (springs.empty()) return;
    auto here = x(first_);
    auto before = 0.0 * here;
    if (first_ > 0) before = springs[first_ - 1] * (here - x(first_ - 1));
    for (std::size_t i = 0, j = first_; i < size_; ++i, ++j) {
      auto after = 0.0 * here;
      if (j < springs.size()) {
        const auto next = x(j + 1);
        after = springs[j] * (next - here);
        here = next;
      }
      out[i] = out[i] + (after - before);
      before = after;
    }
  }

  std::size_t first_, size_;  // node of unknown 0, unknowns
  OfBar of_bar_;
  BandedMatrix inertia_, whole_;
  std::array<std::array<double, 3>, 2> held_{};
  std::vector<double> elastic_, viscous_;  // of each element; empty: zeros
  double relative_change_ = 0.0;
};

/// Derivatives of the initial velocities of the unknowns beside those that the data of a direction have. A velocity
/// that enters a chain by its moments, (rho M) w = int rho phi_i u_1, has the derivative of both. Empty: none.
std::vector<double> start_of_masses(const BarSystem& bar, const Direction& direction, const LoadDifference* difference);

}  // namespace viscobar

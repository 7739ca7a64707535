#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "dynamics/element_springs.hpp"
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

  /// M' of the rows of a side that resists, without rho, over all nodes; of no size where it is zero.
  const BandedMatrix& of_side() const { return of_side_; }

  const ElementSprings& elastic() const { return elastic_; }  ///< (E K)': rates of E over int dx / A of each element
  const ElementSprings& viscous() const { return viscous_; }  ///< (eta K)'

  /// Relative change of what bars, bodies and joints are made of.
  double relative_change() const { return relative_change_; }

 private:
  void take_difference(const BarSystem& bar, const Direction& direction, const LoadDifference& difference,
                       const std::array<bool, 2>& massless, std::vector<double>& elastic, std::vector<double>& viscous);

  OfBar of_bar_;
  BandedMatrix inertia_, whole_, of_side_;
  std::array<std::array<double, 3>, 2> held_{};
  ElementSprings elastic_, viscous_;
  double relative_change_ = 0.0;
};

/// Derivatives of the initial velocities of the unknowns beside those that the data of a direction have. A velocity
/// that enters a chain by its moments, (rho M) w = int rho phi_i u_1, has the derivative of both. Empty: none.
std::vector<double> start_of_masses(const BarSystem& bar, const Direction& direction, const LoadDifference* difference);

}  // namespace viscobar

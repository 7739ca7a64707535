#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "viscobar/discretisation/tridiagonal.hpp"
#include "viscobar/dynamics/contact.hpp"
#include "viscobar/dynamics/unknowns.hpp"

namespace viscobar {

/// rho M of a bar, the masses of its ends in it. M is symmetric but for the rows of Mass::fourth_order, Q is its
/// symmetric part; the row of a node without mass is zero.
class Inertia {
 public:
  /// @param whole rho M over all nodes, which is kept where an end is `moved`
  /// @param unknowns nodes that move
  /// @param massless ends that have no mass
  /// @param moved true where something moves an end
  Inertia(const BandedMatrix& whole, const Unknowns& unknowns, std::array<bool, 2> massless, bool moved);

  const BandedMatrix& matrix() const { return matrix_; }  ///< over the unknowns
  const BandedMatrix& whole() const { return whole_; }    ///< over all nodes, where something moves an end

  /// Unknowns with inertia are the contiguous range [massive_begin, massive_end).
  std::size_t massive_begin() const { return massless_[0] ? 1 : 0; }
  /// One past the last unknown with inertia.
  std::size_t massive_end() const { return matrix_.size() - (massless_[1] ? 1 : 0); }
  /// True if it has no inertia.
  bool massless(std::size_t unknown) const { return unknown < massive_begin() || unknown >= massive_end(); }
  /// True if any unknown has none.
  bool has_massless() const { return massless_[0] || massless_[1]; }

  /// Acceleration of the massive unknowns from a force: force <- (rho M)^{-1} force, zero at massless nodes.
  void accelerate(std::span<double> force) const;
  /// 1 / (e . (rho M)^{-1} e) of every unknown, the mass with which a node answers to a force on it alone; 0 for
  /// massless ones.
  std::vector<double> effective_masses() const;
  /// The mass that a contact has to stop: at an end the node's effective mass, under a span obstacle the row sum of
  /// rho M, because there all nodes are stopped together (a bar that falls flat).
  double contact_mass(const Contact& contact) const;
  /// (rho M a)_e of a fixed end, a over all mesh nodes.
  double held(bool right, std::span<const double> a) const;

  /// How many row_values() of the unknowns end_power() asks for.
  std::size_t row_values() const {
    const bool ends = matrix_.skew.empty() && whole_.skew.empty() && matrix_.one_sided_at_ends();
    return ends ? 6 : matrix_.size();
  }
  /// w . rho (M - Q) a, the power that rows of the mass take at velocity w and acceleration a in the frame; a has
  /// row_values().
  double end_power(std::span<const double> w, std::span<const double> a) const {
    return matrix_.unsymmetric_product([w](std::size_t i) { return w[i]; }, RowValues{a, matrix_.size()});
  }

 private:
  std::array<bool, 2> massless_;
  BandedMatrix matrix_, whole_;
  std::array<std::array<double, 3>, 2> held_rows_{};  // of fixed ends, inwards
  TridiagonalFactor massive_factor_;                  // of the massive block
};

}  // namespace viscobar

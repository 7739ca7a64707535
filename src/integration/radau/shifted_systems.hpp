#pragma once

#include <span>
#include <vector>

#include "dynamics/penalised_system.hpp"
#include "integration/radau/formula.hpp"
#include "viscobar/discretisation/tridiagonal.hpp"

namespace viscobar::radau {

/// The systems of a step of length h,
///
///     (zeta M + h C + h^2 / zeta K) X = h r - h^2 / zeta K w + load,
///
/// M = rho M, C and K those of the dynamic stiffness, for the four poles side by side. They are eliminated from both
/// ends towards the middle, two chains of dependencies at once.
class ShiftedSystems {
 public:
  static constexpr std::size_t least_size = 5;  ///< unknowns

  /// Takes the matrices of the system with its contacts as they are.
  void take(const PenalisedSystem& system);
  /// Of steps of length h.
  void factorise(double h);
  /// out = K x; 0 where a contact holds the node.
  void multiply_stiffness(std::span<const double> x, std::span<double> out) const;
  /// Solves; `force` is r, `stiff_rate` is K w. Where `loaded`, x holds the load's part of the right-hand side.
  void solve(std::span<const double> force, std::span<const double> stiff_rate, bool loaded,
             std::span<Complex> x) const;

 private:
  struct Node {
    Complex inverse_pivot;
    Complex towards;  // U(i, next) / pivot, next towards the middle
    Complex away;     // what the row of next loses of this one: L(next, i)
  };

  SymmetricTridiagonal mass_, damping_, stiffness_;
  std::vector<unsigned char> held_;
  std::vector<Node> nodes_;
  Complex beyond_first_, beyond_last_;  // of the row of an end, two nodes on, over its pivot
  double h_ = 0.0;
};

}  // namespace viscobar::radau

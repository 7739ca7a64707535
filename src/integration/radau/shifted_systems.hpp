#pragma once

#include <optional>
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
  /// The unknown at which the eliminations from either end meet: next to the middle, where no one-sided row is nor
  /// goes across. Absent: there is none.
  static std::optional<std::size_t> middle_of(const BandedMatrix& inertia);

  /// Takes the matrices of the system, the same one in each call, with its contacts as they are.
  void take(const PenalisedSystem& system);
  /// Factorises the matrices for steps of length h.
  void factorise(double h);
  /// out = K x; 0 where a contact holds the node. By differences, which keep the digits of what is all but constant.
  void multiply_stiffness(std::span<const double> x, std::span<double> out) const;
  /// Solves; `force` is r, `stiff_rate` is K w. Where `loaded`, x holds the load's part of the right-hand side.
  void solve(std::span<const double> force, std::span<const double> stiff_rate, bool loaded, std::span<Complex> x);
  /// True if solve() is to correct x by its residual, by a second solve: rounding of the pivots is one of the inertia
  /// by their ratio, and the weights of the formula multiply that by some hundreds.
  void refine(bool wanted) { refines_ = wanted; }
  /// Error of a step without that correction, relative to the motion; about fifteen times the measured one.
  double rounding() const { return rounding_; }

 private:
  struct Node {
    Complex inverse_pivot;
    Complex towards;  // U(i, next) / pivot, next towards the middle
    Complex away;     // L(next, i), factor of this row in the elimination of the next one
  };

  // Flags of a node: something is to be done beside what each has; a one-sided row of it has been taken into account
  // where it goes back, or is to be where it goes ahead; it is tied to the next one; a contact holds it.
  enum Flag : unsigned char { amended = 1, goes_back = 2, goes_ahead = 4, tied = 8, held = 16 };

  // A one-sided row: its node, the two beside it, and whether the elimination goes to them.
  struct RowBeside {
    std::size_t node, next, beyond;
    bool ahead;
  };

  // An elimination that has come to a node.
  struct Front {
    Complex pivot, upper, coupling;
  };

  // Entries of the three matrices.
  struct Entries {
    const double *m, *c, *k;
  };

  // The combination of the matrices in a step of length h.
  struct Coefficients {
    Complex of_mass, of_stiffness;
    double h;
    [[gnu::always_inline]] Complex operator()(double m, double c, double k) const {
      return {of_mass.re * m + of_stiffness.re * k + h * c, of_mass.im * m + of_stiffness.im * k};
    }
    [[gnu::always_inline]] Complex operator()(const Entries& of, std::size_t i) const {
      return (*this)(of.m[i], of.c[i], of.k[i]);
    }
  };
  Coefficients coefficients() const {
    const Formula& formula = Formula::get();
    return {formula.poles, {h_ * h_ * formula.inverse.re, h_ * h_ * formula.inverse.im}, h_};
  }

  void take(const BarSystem& bar);
  void flag_rows(const BarSystem& bar);
  void find_alike();
  void set_flags(std::size_t i, int flags);  // and its ratios
  bool is_held(std::size_t i) const { return flags_[i] & held; }
  void sum_rows_beside(const BarSystem& bar, const SideRows& side);
  void multiply_beside(std::span<const double> x, std::span<double> out) const;  // with a side that resists
  [[gnu::always_inline]] inline void amend(Front& front, std::size_t i, const Coefficients& at);
  [[gnu::always_inline]] inline Complex less_beyond(std::size_t i, Flag rows, Complex at,
                                                    std::span<const Complex> x) const;
  template <class RightSide>
  void substitute(const RightSide& right_side, std::span<Complex> of) const;
  Complex residual(std::size_t i, const Complex& right_side, std::span<const Complex> x) const;

  BandedMatrix mass_, damping_, stiffness_;
  std::vector<double> bound_, dashed_;  // sums of the rows of K and C: what binds a node to the ground
  bool refines_ = false;
  double rounding_ = 0.0;
  Eigen::ArrayXd damping_ratio_, stiffness_ratio_;  // diagonals of C and K over that of M; 0 where a node is held
  std::vector<Complex> right_, correction_;
  std::vector<std::size_t> in_contact_;  // the nodes that are tied or held
  std::vector<Node> nodes_;
  std::size_t middle_ = 0;
  std::vector<unsigned char> flags_;
  std::vector<RowBeside> rows_;
  // Both eliminations go through pairs of nodes, j and n - 1 - j. From one on none has a flag, and from another on all
  // have the same entries, but for flags.
  std::size_t unflagged_ = 0, alike_ = 0;
  // One a one-sided row: U(r, r +- 2) over its pivot of one that goes ahead, L(r, r +- 2) of one that goes back.
  std::vector<Complex> beyond_;
  double h_ = 0.0;
};

}  // namespace viscobar::radau

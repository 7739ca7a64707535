#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "viscobar/discretisation/tridiagonal.hpp"

namespace viscobar {

/// min 1/2 x.A x - b.x  subject to  x >= bound  in every entry, solved exactly:
///
///     A x = b + lambda,    0 <= x - bound  _|_  lambda >= 0.
///
/// Block principal pivoting from the active set of the last solution: all entries that are wrong change at once (a step
/// of the primal-dual active set method, or of semismooth Newton), and each pivot is one tridiagonal solve in which
/// the active entries split the matrix. For an M-matrix that ends, the solution rising monotonically [Hintermueller,
/// Ito, Kunisch 2003]. With positive off-diagonals, which the consistent mass has for dt << h, one entry at a time
/// changes by Murty's last-index rule while the number of wrong entries does not fall, which ends for every positive
/// definite matrix [Judice, Pires 1994].
class SpanConstraint {
 public:
  explicit SpanConstraint(const SymmetricTridiagonal& matrix);

  /// All arguments have one value an entry; x = bound bitwise in active entries and x >= bound bitwise in all. An entry
  /// without a bound has -infinity.
  void solve(std::span<const double> b, std::span<const double> bound, std::span<double> x,
             std::span<double> multiplier);

  /// 1 where the last solution is held by its bound.
  std::span<const unsigned char> active() const { return active_; }

  /// What the next solution depends on.
  static void members(auto& constraint, auto&& each) {
    each(std::span(constraint.active_), constraint.solves_, constraint.factorisations_);
  }
  /// Makes the factor that belongs to members() that have been read.
  void restored() {
    split();
    --factorisations_;
  }

  std::size_t solves() const { return solves_; }
  std::size_t factorisations() const { return factorisations_; }

 private:
  void pivot(std::span<const double> b, std::span<const double> bound, std::span<double> x,
             std::span<double> multiplier);
  std::size_t mark_wrong(std::span<const double> b, std::span<const double> bound, std::span<const double> x,
                         std::span<const double> multiplier, double tolerance);
  void split();

  SymmetricTridiagonal matrix_;
  SymmetricTridiagonal split_;  // matrix_ without what couples active entries to others
  TridiagonalFactor factor_;    // of split_
  bool monotone_;               // an M-matrix
  std::vector<unsigned char> active_, wrong_;
  std::size_t solves_ = 0, factorisations_ = 0;
};

}  // namespace viscobar

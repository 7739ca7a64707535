#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "viscobar/discretisation/tridiagonal.hpp"

namespace viscobar {

/// min 1/2 x.A x - b.x  subject to  lower <= x <= upper  in every entry, solved exactly:
///
///     A x = b + lambda,    lambda >= 0 where x = lower,  lambda <= 0 where x = upper,  0 elsewhere.
///
/// Block principal pivoting from the active set of the last solution: all entries that are wrong change at once (a step
/// of the primal-dual active set method, or of semismooth Newton), and each pivot is one tridiagonal solve in which
/// the active entries split the matrix. For an M-matrix that ends, the solution rising monotonically [Hintermueller,
/// Ito, Kunisch 2003]. With positive off-diagonals, which the consistent mass has for dt << h, one entry at a time
/// changes by Murty's last-index rule while the number of wrong entries does not fall, which ends for every positive
/// definite matrix [Judice, Pires 1994].
class SpanConstraint {
 public:
  explicit SpanConstraint(const BandedMatrix& matrix);

  /// All arguments have one value an entry; x is its bound bitwise in active entries and within them bitwise in all. An
  /// entry without a bound has an infinite one. Returns false if none is active.
  bool solve(std::span<const double> b, std::span<const double> lower, std::span<const double> upper,
             std::span<double> x, std::span<double> multiplier);

  enum Held : unsigned char { nowhere, at_lower, at_upper };
  /// Where the last solution is held by a bound.
  std::span<const unsigned char> active() const { return active_; }

  /// State that the next solution depends on.
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
  bool meets(std::span<double> x) const;
  void pivot(std::span<const double> b, std::span<double> x, std::span<double> multiplier);
  std::size_t mark_wrong(std::span<const double> b, std::span<const double> x, std::span<const double> multiplier,
                         double tolerance);
  double bound(std::size_t i) const { return active_[i] == at_lower ? lower_[i] : upper_[i]; }
  void split();

  BandedMatrix matrix_;
  BandedMatrix split_;                          // matrix_ without what couples active entries to others
  TridiagonalFactor factor_;                    // of split_
  bool monotone_;                               // an M-matrix
  bool held_ = false;                           // an entry is active
  std::vector<unsigned char> active_, wanted_;  // Held; as it is and as it should be
  std::span<const double> lower_, upper_;       // of the present solution
  std::size_t solves_ = 0, factorisations_ = 0;
};

}  // namespace viscobar

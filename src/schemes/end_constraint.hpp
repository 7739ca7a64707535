#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "viscobar/discretisation/tridiagonal.hpp"

namespace viscobar {

/// min 1/2 x.A x - b.x  subject to  c_X.x >= bound_X  at a few entries X of x:
///
///     A x = b + sum_X lambda_X c_X,    0 <= c_X.x - bound_X  _|_  lambda_X >= 0.
///
/// c_X is e_X where x is bounded from below and -e_X where it is from above; at a joint it is e_X - e_{X-1}. Two at
/// most are solved in closed form, more by principal pivoting [Murty 1974]. The columns A^{-1} c_X are computed once.
/// Their rows X are positive definite, or for a mass with end rows have positive diagonal and determinant, so exactly
/// one of the two or four contact states fits.
class EndConstraint {
 public:
  /// An entry and its sign.
  struct Bounded {
    // NOLINTNEXTLINE(google-explicit-constructor): an entry alone is bounded from below
    Bounded(std::size_t bounded_entry, double from = 1.0, bool at_joint = false)
        : entry(bounded_entry), sign(from), joint(at_joint) {}
    std::size_t entry;
    double sign;
    bool joint;
    /// The value that is bounded, but for the sign.
    double of(std::span<const double> x) const { return joint ? x[entry] - x[entry - 1] : x[entry]; }
  };
  EndConstraint(const BandedMatrix& matrix, const std::vector<Bounded>& entries);

  /// x holds b on entry and the solution on return, with s_X x_X = bound_X bitwise where the constraint is active.
  /// `bound` and `multiplier` have one value an entry X; without a bound it is -infinity.
  void solve(std::span<double> x, std::span<const double> bound, std::span<double> multiplier);

  /// Goes on as after a solution that had these multipliers.
  void restored(std::span<const double> multiplier) {
    for (std::size_t k = 0; k < active_.size(); ++k) active_[k] = multiplier[k] > 0.0;
  }

  /// 1 where the last solution is held by its bound.
  std::span<const unsigned char> active() const { return active_; }

 private:
  struct Column {
    Bounded at;
    std::vector<double> values;  // A^{-1} s e_entry
    std::size_t begin = 0, end;  // of those that are not negligible
    double of(std::span<const double> x) const {
      return at.joint ? x[at.entry] - x[at.entry - 1] : at.sign * x[at.entry];
    }
  };

  void put_on(const Column& column, double bound, std::span<double> x) const;
  void invert_held();
  void solve_many(std::span<double> x, std::span<const double> bound, std::span<double> multiplier);

  TridiagonalFactor factor_;
  std::vector<Column> columns_;
  std::vector<unsigned char> active_;
  // More than two: c_k A^{-1} c_l; those held, the inverse of their rows of it, their multipliers; the excess of all.
  std::vector<double> compliance_, rows_, inverse_, lambda_, excess_;
  std::vector<std::size_t> held_, before_;
};

}  // namespace viscobar

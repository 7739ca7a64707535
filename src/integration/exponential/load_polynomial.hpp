#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <optional>

#include "viscobar/dynamics/bar_system.hpp"
#include "viscobar/dynamics/load_vector.hpp"

namespace viscobar::exponential {

/// Degree of the load's polynomial on a step.
inline constexpr Eigen::Index load_degree = 12;

/// p(sigma) = sum_j column_j sigma^j, sigma in [0, 1] the part of a step that has passed; no columns without a load
/// that varies in time.
using LoadPolynomial = Eigen::MatrixXd;

/// q with q(sigma) = p(origin + scale sigma).
LoadPolynomial rescaled(const LoadPolynomial& p, double origin, double scale);

/// M f(t) on a step as a polynomial in time with coefficients in the span of few vectors: one for profile(x)
/// history(t), as many as the load shows for a density without structure.
class LoadInterpolation {
 public:
  /// In a run from `begin` to `end`.
  LoadInterpolation(const BarSystem& system, double begin, double end);

  /// Vectors that the coefficients refer to, orthonormal; grows while loads outside their span appear.
  const Eigen::MatrixXd& basis() const { return basis_; }

  /// The part that is constant in time; empty where there is none.
  std::span<const double> steady() const { return steady_; }
  bool varies() const { return load_.has_value(); }

  /// The load is that of the piece of time between two of its breaks that begins at t (see LoadVector::enter).
  void enter(double t, double end) {
    if (load_) load_->enter(t, end);
  }

  /// Interpolates at Chebyshev's points of [t, t + tau]. Returns whether the last Chebyshev coefficients are
  ///
  ///   - below 1e-14 of the largest load so far, or `negligible`, or below the numbers that have all digits,
  ///   - or below 1e-11 of the largest load of the run and no shorter step would lower them: they are what a few
  ///     roundings of the time make of the load, or they are level, which is the rounding of the load itself. A load
  ///     that begins like t^8 as (1 - cos t)^4 has no digits of its own there.
  bool fit(double t, double tau, double negligible, LoadPolynomial& out);

  /// Coefficients over the unknowns (n entries each), of the part that varies and of all: no columns without any.
  Eigen::MatrixXd varying(const LoadPolynomial& p) const;
  Eigen::MatrixXd total(const LoadPolynomial& p) const;

  static void members(auto& load, auto&& each) { each(load.largest_); }

  std::size_t evaluations() const { return load_ ? load_->evaluations() : 0; }

 private:
  double parts(double t) const;

  const BarSystem& system_;
  std::optional<LoadVector> load_;
  std::span<const double> steady_;
  Eigen::MatrixXd basis_;
  double largest_ = 0.0;   // so far, of the sum and of the parts that may cancel in it
  double expected_ = 0.0;  // among 64 of the run
};

}  // namespace viscobar::exponential

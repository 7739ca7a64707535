#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "viscobar/dynamics/bar_system.hpp"
#include "viscobar/dynamics/penalty_law.hpp"

namespace viscobar::exponential {

using Eigen::Index;

inline std::span<const double> entries(const Eigen::VectorXd& x) {
  return {x.data(), static_cast<std::size_t>(x.size())};
}

/// Terms of the Taylor series of a step with (rate bound) * step <= 1: 1 / 22! < 2^-64.
inline constexpr Index taylor_order = 22;

/// A closed contact: its node, where u is zero penetration, and its law. A support is one, too, that is always closed.
/// At a joint u is that of the node against the one before.
struct ClosedContact {
  Index unknown = 0;
  double surface = 0.0;
  PenaltyLaw law;
  bool joint = false;

  /// Its u, or the rate of that, by those of all unknowns.
  template <class Real>
  Real of(const auto& x) const {
    return joint ? Real(x[unknown] - x[unknown - 1]) : Real(x[unknown]);
  }
};

/// The penalised bar while its contact states do not change,
///
///     rho M u'' = p(t) - E K u - eta K u' (- M (k u + c u') of a side that resists) - sum over closed contacts of (k
///     (u_c - surface_c) + b u_c') e_c,
///
/// u of each node measured from its entry of `origin`, linear with constant coefficients in y = (u, v): u of the nodes
/// with an equation of motion, v of the massive ones. A massless node moves by its own balance, u_0' from it with
/// viscosity; without, the balance is algebraic and u_0 is no part of y. `Real` is double for steps and long double for
/// the matrices that many steps share.
template <class Real>
class LinearLeg {
 public:
  using Vector = Eigen::Matrix<Real, Eigen::Dynamic, 1>;
  /// Column k holds tau^k u^(k) / k! of all n unknowns.
  using Series = Eigen::Matrix<Real, Eigen::Dynamic, Eigen::Dynamic>;

  LinearLeg(const BarSystem& system, const Eigen::VectorXd& origin, std::span<const double> steady_load,
            std::vector<ClosedContact> closed);

  Index size() const { return moving_ + (massive_end_ - massive_begin_); }  ///< entries of y
  Index displacements() const { return moving_; }                           ///< y begins with so many displacements

  /// Taylor coefficients of u about a point of time, from y there. Column j of `load` multiplies (s / tau)^j; `one`
  /// multiplies what does not depend on y and load (surfaces, fixed ends, steady load): 0 gives the linear part.
  Series expand(const Vector& y, Real one, const Eigen::MatrixXd& load, Real tau, Index order) const;

  /// u and u' of all unknowns at s = sigma tau.
  static Vector displacement(const Series& series, Real sigma);
  static Vector velocity(const Series& series, Real sigma, Real tau);
  static Vector acceleration(const Series& series, Real sigma, Real tau);

  Vector pack(const Vector& u, const Vector& v) const;

 private:
  Index n_, moving_begin_, moving_, massive_begin_, massive_end_;
  bool left_fixed_, right_fixed_, damped_;
  Real left_displacement_, right_displacement_;  // of fixed ends
  std::vector<Real> stiffness_, damping_;  // E / h, eta / h of the elements left and right of unknown i: [i], [i+1]
  TridiagonalFactorOf<Real> factor_;       // of the massive block of rho M
  Eigen::VectorXd origin_;
  std::vector<double> steady_load_;  // empty, or n entries
  std::vector<ClosedContact> closed_;
  const SideRows* side_;  // of the system, which outlives this
  Index first_node_;
};

extern template class LinearLeg<double>;
extern template class LinearLeg<long double>;

}  // namespace viscobar::exponential

#pragma once

#include <cmath>
#include <memory>
#include <vector>

#include "dynamics/penalised_system.hpp"
#include "integration/exponential/linear_leg.hpp"
#include "integration/exponential/load_polynomial.hpp"

namespace viscobar::exponential {

/// Steps of a leg by matrix exponentials of dyadic lengths tau_k = 2^k tau_0,
///
///     y(tau) = E_k y + sum_j W_kj c_j,   E_k = exp(A tau_k),   W_kj = int_0^tau exp(A (tau - s)) (s / tau)^j ds B,
///
/// c_j the load's coefficients. E_0 and W_0j are Taylor sums; the others follow by E_{k+1} = E_k^2 and
/// W_{k+1,j} = 2^-j (E_k W_kj + sum_{i <= j} binomial(j, i) W_ki), built when first needed. E is squared in extended
/// precision: an error of E_0 in double precision would act in every step alike and shift the slow modes.
class Propagator {
 public:
  /// `inverse_inertia` is the norm of (rho M)^{-1} on the massive nodes. `load` and `exponentials`, to which the number
  /// of matrices built is added, outlive this.
  Propagator(const BarSystem& system, const Eigen::VectorXd& origin, double inverse_inertia,
             const LoadInterpolation& load, std::vector<ClosedContact> closed, std::size_t& exponentials);

  const LinearLeg<double>& leg() const { return leg_; }

  /// tau_level. The leg's Taylor series serves for every length up to step(0), a power of two, so that the sums of
  /// steps are exact.
  double step(int level) const { return std::ldexp(finest_, level); }

  /// y <- y(step(level)); by the Taylor series for level <= 0
  void advance(int level, Eigen::VectorXd& y, const LoadPolynomial& load);

  /// Taylor coefficients of u from y and the load on a step of length tau.
  LinearLeg<double>::Series expand(const Eigen::VectorXd& y, const LoadPolynomial& load, double tau,
                                   Index order = taylor_order) const;

 private:
  using ExtendedMatrix = LinearLeg<long double>::Series;
  struct Level {
    Eigen::MatrixXd increment;  // E - I, and the response to what is constant as last column
    Eigen::MatrixXd response;   // W_0, W_1, ... beside each other
  };
  void build_increments(int level);
  void keep_rigid_motions(long double tau);
  const Eigen::MatrixXd& response(int level);

  LinearLeg<double> leg_;
  LinearLeg<long double> extended_leg_;
  const LoadInterpolation& load_;
  std::size_t& exponentials_;
  bool free_;  // nothing holds the bar
  double finest_;
  std::vector<Level> levels_;
  ExtendedMatrix coarsest_;  // increment of the last level
};

/// The propagators of the contact states that a run comes back to, the least recently used forgotten when their
/// matrices would take too much memory.
class PropagatorCache {
 public:
  /// All arguments outlive this; `exponentials` counts the matrices that are built.
  PropagatorCache(const PenalisedSystem& system, const LoadInterpolation& load, std::size_t& exponentials);

  /// For the present contact states of the system. Valid until the next call.
  Propagator& present();

  /// Norm of (rho M)^{-1} on the massive nodes.
  double inverse_inertia() const { return inverse_inertia_; }

 private:
  struct Entry {
    std::vector<bool> closed;
    std::unique_ptr<Propagator> propagator;
  };

  const PenalisedSystem& system_;
  const LoadInterpolation& load_;
  std::size_t& exponentials_;
  double inverse_inertia_;
  Eigen::VectorXd origin_;      // of the displacements in the entries
  std::vector<Entry> entries_;  // the last used at the end
};

}  // namespace viscobar::exponential

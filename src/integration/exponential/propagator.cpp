#include "integration/exponential/propagator.hpp"

#include <algorithm>
#include <cmath>

namespace viscobar::exponential {

using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

// Bound of the rates |lambda| of the leg: sqrt(|M^-1| |K|) + |M^-1| |C| + the massless nodes' own relaxation.
double rate_bound(const BarSystem& system, double inverse_inertia, const std::vector<ClosedContact>& closed) {
  const double stiffness = system.bar().modulus / system.mesh().smallest();
  const double damping = system.bar().viscosity / system.mesh().smallest();
  double contact_stiffness = 0.0, contact_damping = 0.0, massless_stiffness = 0.0;
  for (const ClosedContact& contact : closed) {
    const auto node = static_cast<std::size_t>(contact.unknown);
    if (node < system.massive_begin() || node >= system.massive_end()) {
      massless_stiffness = std::max(massless_stiffness, contact.law.stiffness);
    } else {
      contact_stiffness = std::max(contact_stiffness, contact.law.stiffness);
      contact_damping = std::max(contact_damping, contact.law.damping);
    }
  }
  double rate = std::sqrt(inverse_inertia * (4.0 * stiffness + 2.0 * contact_stiffness)) +
                inverse_inertia * (4.0 * damping + 2.0 * contact_damping);
  if (system.has_massless() && system.damped()) rate += (stiffness + massless_stiffness) / damping;
  return rate;
}

}  // namespace

Propagator::Propagator(const BarSystem& system, const VectorXd& origin, double inverse_inertia,
                       const LoadInterpolation& load, std::vector<ClosedContact> closed, std::size_t& exponentials)
    : leg_(system, origin, load.steady(), closed),
      extended_leg_(system, origin, load.steady(), closed),
      load_(load),
      exponentials_(exponentials),
      free_(closed.empty() && !system.left_fixed() && !system.right_fixed()),
      finest_(std::exp2(-std::ceil(std::log2(rate_bound(system, inverse_inertia, closed))))) {}

LinearLeg<double>::Series Propagator::expand(const VectorXd& y, const LoadPolynomial& load, double tau,
                                             Index order) const {
  return leg_.expand(y, 1.0, load_.varying(load), tau, order);
}

void Propagator::advance(int level, VectorXd& y, const LoadPolynomial& load) {
  const Index m = leg_.size();
  if (level <= 0) {
    const auto series = expand(y, load, step(level));
    y = leg_.pack(leg_.displacement(series, 1.0), leg_.velocity(series, 1.0, step(level)));
    return;
  }
  build_increments(level);
  const MatrixXd& increment = levels_[level].increment;
  VectorXd change = increment.leftCols(m) * y + increment.col(m);
  if (load.size() > 0) change += response(level) * load.reshaped();
  y += change;
}

void Propagator::build_increments(int level) {
  const Index m = leg_.size();
  while (static_cast<int>(levels_.size()) <= level) {
    if (levels_.empty()) {
      coarsest_.resize(m, m + 1);
      const long double tau = finest_;
      for (Index j = 0; j <= m; ++j) {
        LinearLeg<long double>::Vector unit = LinearLeg<long double>::Vector::Zero(m);
        if (j < m) unit[j] = 1;
        // Without the terms of I: 1 + (a rate times tau_0) - 1 would keep few digits of the slow modes' rates.
        auto series = extended_leg_.expand(unit, j < m ? 0 : 1, {}, tau, taylor_order);
        series.col(0).setZero();
        const auto u = extended_leg_.displacement(series, 1);
        series.col(1).setZero();
        coarsest_.col(j) = extended_leg_.pack(u, extended_leg_.velocity(series, 1, tau));
      }
    } else {
      const ExtendedMatrix square = coarsest_.leftCols(m) * coarsest_;
      coarsest_ = 2 * coarsest_ + square;
    }
    if (free_) keep_rigid_motions(static_cast<long double>(step(static_cast<int>(levels_.size()))));
    levels_.push_back({coarsest_.cast<double>(), {}});
    ++exponentials_;
  }
}

// A rigid displacement stays where it is, and moves at a rigid velocity by it times tau. Squaring loses that: what is
// missing acts as a spring to the origin, and grows fourfold a level.
void Propagator::keep_rigid_motions(long double tau) {
  const Index m = leg_.size(), u = leg_.displacements(), v = m - u;
  using Vector = LinearLeg<long double>::Vector;
  auto increment = coarsest_.leftCols(m);
  const Vector of_displacement = increment.leftCols(u).rowwise().mean();
  Vector of_velocity = increment.rightCols(v).rowwise().mean();
  of_velocity.head(u).array() -= tau / static_cast<long double>(v);
  increment.leftCols(u).colwise() -= of_displacement;
  increment.rightCols(v).colwise() -= of_velocity;
}

const MatrixXd& Propagator::response(int level) {
  const Index m = leg_.size(), rank = load_.basis().cols();
  MatrixXd& out = levels_[level].response;
  const Index columns = rank * (load_degree + 1);
  if (out.cols() == columns) return out;  // else the basis has grown
  MatrixXd result(m, columns);
  if (level == 0) {
    MatrixXd unit = MatrixXd::Zero(load_.basis().rows(), load_degree + 1);
    for (Index j = 0; j <= load_degree; ++j, unit.setZero())
      for (Index q = 0; q < rank; ++q) {
        unit.col(j) = load_.basis().col(q);
        const auto series = leg_.expand(VectorXd::Zero(m), 0.0, unit, finest_, taylor_order);
        result.col(j * rank + q) = leg_.pack(leg_.displacement(series, 1.0), leg_.velocity(series, 1.0, finest_));
      }
  } else {
    const MatrixXd& half = response(level - 1);
    result = half;
    result.noalias() += levels_[level - 1].increment.leftCols(m) * half;
    double scale = 1.0;
    for (Index j = 0; j <= load_degree; ++j, scale /= 2) {
      auto weights = result.middleCols(j * rank, rank);
      double binomial = 1.0;
      for (Index i = 0; i <= j; ++i) {
        weights += binomial * half.middleCols(i * rank, rank);
        binomial *= static_cast<double>(j - i) / static_cast<double>(i + 1);
      }
      weights *= scale;
    }
  }
  return out = std::move(result);
}

}  // namespace viscobar::exponential

#pragma once

#include <Eigen/Core>
#include <cmath>

#include "support/decompositions.hpp"
#include "viscobar/dynamics/bar_system.hpp"

namespace viscobar::testing_support {

/// Bar without contact, by its modes in extended precision: with K phi = mu rho M phi each amplitude obeys
///
///     q'' + eta mu q' + E mu q = phi . p sin(Omega t),
///
/// solved in closed form. `rest` is the displacement in equilibrium (what fixed ends ask for).
class ModalSolution {
 public:
  using Real = long double;
  using Vector = Eigen::Matrix<Real, Eigen::Dynamic, 1>;
  using Matrix = Eigen::Matrix<Real, Eigen::Dynamic, Eigen::Dynamic>;

  ModalSolution(const BarSystem& system, const Vector& rest, const Vector& load, Real frequency)
      : rest_(rest), omega_(frequency), modulus_(system.bar().modulus), viscosity_(system.bar().viscosity) {
    const auto n = static_cast<Eigen::Index>(system.size());
    Matrix inertia = Matrix::Zero(n, n), stiffness = Matrix::Zero(n, n);
    for (Eigen::Index i = 0; i < n; ++i) {
      inertia(i, i) = system.inertia().matrix().diagonal[i];
      stiffness(i, i) = system.elements().stiffness_diagonal(static_cast<std::size_t>(i));
      if (i + 1 == n) break;
      if (!system.inertia().matrix().off_diagonal.empty())
        inertia(i, i + 1) = inertia(i + 1, i) = system.inertia().matrix().off_diagonal[i];
      stiffness(i, i + 1) = stiffness(i + 1, i) = -1 / Real(system.mesh().spacing());
    }
    const Modes found = modes(stiffness, inertia);
    modes_ = found.vectors;
    mu_ = found.values;
    if (!system.unknowns().left_fixed() && !system.unknowns().right_fixed()) mu_[0] = 0;  // exactly, in a rigid motion
    const State start = system.initial_state();
    const Matrix projection = modes_.transpose() * inertia;
    q_ = projection * (Eigen::Map<const Eigen::VectorXd>(start.u.data(), n).cast<Real>() - rest);
    rate_ = projection * Eigen::Map<const Eigen::VectorXd>(start.v.data(), n).cast<Real>();
    force_ = modes_.transpose() * load;
  }

  Vector displacement(Real t) const {
    Vector q(q_.size());
    for (Eigen::Index i = 0; i < q.size(); ++i) q[i] = amplitude(i, t);
    return rest_ + modes_ * q;
  }

 private:
  Real amplitude(Eigen::Index i, Real t) const {
    const Real square = modulus_ * mu_[i], decay = viscosity_ * mu_[i] / 2;
    if (square == 0) {
      const Real forced = force_[i] == 0 ? 0 : force_[i] / omega_ * (t - std::sin(omega_ * t) / omega_);
      return q_[i] + rate_[i] * t + forced;
    }
    // Forced motion a sin + b cos, and a free one that starts from the rest of the initial data.
    Real a = 0, b = 0;
    if (force_[i] != 0) {
      const Real x = square - omega_ * omega_, y = 2 * decay * omega_;
      a = force_[i] * x / (x * x + y * y);
      b = -force_[i] * y / (x * x + y * y);
    }
    const Real q = q_[i] - b, rate = rate_[i] - a * omega_;
    const Real forced = a * std::sin(omega_ * t) + b * std::cos(omega_ * t);
    const Real discriminant = square - decay * decay;
    if (discriminant > 0) {
      const Real w = std::sqrt(discriminant);
      return forced + std::exp(-decay * t) * (q * std::cos(w * t) + (rate + decay * q) / w * std::sin(w * t));
    }
    const Real w = std::sqrt(-discriminant), slow = -square / (decay + w), fast = -decay - w;
    return forced + ((rate - fast * q) * std::exp(slow * t) - (rate - slow * q) * std::exp(fast * t)) / (2 * w);
  }

  Vector rest_;
  Real omega_, modulus_, viscosity_;
  Matrix modes_;
  Vector mu_, q_, rate_, force_;
};

}  // namespace viscobar::testing_support

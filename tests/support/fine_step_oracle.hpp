#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "support/decompositions.hpp"
#include "viscobar/dynamics/bar_system.hpp"
#include "viscobar/dynamics/load_vector.hpp"
#include "viscobar/dynamics/penalty_law.hpp"
#include "viscobar/run/run.hpp"

namespace viscobar::testing_support {

/// The penalised system by the classical Runge-Kutta method of order 4 in extended precision, at a fixed step, contact
/// changes found by bisection of the step. Shares nothing with the library but the inertia, the contacts and M f: slow,
/// simple, for few nodes. Free or obstacle ends.
class FineStepOracle {
 public:
  using Real = long double;
  using Vector = Eigen::Matrix<Real, Eigen::Dynamic, 1>;
  using Matrix = Eigen::Matrix<Real, Eigen::Dynamic, Eigen::Dynamic>;

  struct Change {
    Real time;
    std::size_t contact;
    bool closing;
  };

  /// True if a Real has more digits than a double as the program runs: valgrind computes with those of a double.
  static bool is_extended() {
    volatile Real one = 1, less_than_a_rounding = 0x1p-60L;
    return one + less_than_a_rounding != one;
  }

  FineStepOracle(const BarSystem& system, const Penalty& penalty, Real step)
      : system_(system),
        n_(static_cast<Eigen::Index>(system.size())),
        begin_(static_cast<Eigen::Index>(system.inertia().massive_begin())),
        end_(static_cast<Eigen::Index>(system.inertia().massive_end())),
        stiffness_(Real(system.bar().modulus) / system.mesh().spacing()),
        damping_(Real(system.bar().viscosity) / system.mesh().spacing()),
        step_(step),
        u(Eigen::Map<const Eigen::VectorXd>(system.initial_state().u.data(), n_).cast<Real>()),
        v(Eigen::Map<const Eigen::VectorXd>(system.initial_state().v.data(), n_).cast<Real>()) {
    Matrix inertia = Matrix::Zero(n_, n_);
    for (Eigen::Index i = 0; i < n_; ++i) {
      inertia(i, i) = system.inertia().matrix().diagonal[i];
      if (i + 1 < n_ && !system.inertia().matrix().off_diagonal.empty())
        inertia(i, i + 1) = inertia(i + 1, i) = system.inertia().matrix().off_diagonal[i];
    }
    const Eigen::Index massive = end_ - begin_;
    inverse_ = inverse(Matrix(inertia.block(begin_, begin_, massive, massive)));
    for (const Contact& contact : system.contacts())
      laws_.push_back(penalty_law(penalty, contact.weight, system.inertia().contact_mass(contact)));
    closed_.assign(laws_.size(), false);
    if (system.loaded()) load_.emplace(system);
    complete(u, v);
  }

  void advance_to(Real end) {
    while (t < end) {
      const Real tau = std::min(step_, end - t);
      auto [next_u, next_v] = stepped(tau);
      if (!passed(next_u)) {
        u = next_u, v = next_v, t += tau;
        continue;
      }
      Real before = 0, after = tau;
      for (int i = 0; i < 60; ++i) {
        const Real middle = (before + after) / 2;
        (passed(stepped(middle).first) ? after : before) = middle;
      }
      std::tie(next_u, next_v) = stepped(after);
      const std::optional<std::size_t> contact = passed(next_u);
      u = next_u, v = next_v, t += after;
      closed_[*contact] = !closed_[*contact];
      changes.push_back({t, *contact, closed_[*contact]});
      complete(u, v);
    }
  }

 private:
  using State = std::pair<Vector, Vector>;

  std::optional<std::size_t> passed(const Vector& at) const {
    for (std::size_t c = 0; c < laws_.size(); ++c) {
      const Real clearance = at[system_.contacts()[c].unknown] + system_.contacts()[c].gap;
      if (closed_[c] ? clearance > 0 : clearance < 0) return c;
    }
    return std::nullopt;
  }

  // Force of the contacts, the stress of the neighbouring elements and the load on node i.
  Real force(Eigen::Index i, const Vector& x, const Vector& w) const {
    const auto stress = [&](Eigen::Index e) {
      return e < 0 || e + 1 >= n_ ? Real(0) : stiffness_ * (x[e + 1] - x[e]) + damping_ * (w[e + 1] - w[e]);
    };
    Real sum = stress(i) - stress(i - 1) + (load_ ? Real(load_->at(static_cast<double>(time_))[i]) : Real(0));
    for (std::size_t c = 0; c < laws_.size(); ++c)
      if (closed_[c] && system_.contacts()[c].unknown == static_cast<std::size_t>(i))
        sum -= laws_[c].stiffness * (x[i] + system_.contacts()[c].gap) + laws_[c].damping * w[i];
    return sum;
  }

  // The balance of a massless node is linear in its velocity, without viscosity in its displacement.
  void complete(Vector& x, Vector& w) const {
    for (Eigen::Index i = 0; i < n_; ++i) {
      if (i >= begin_ && i < end_) continue;
      Real& unknown = damping_ > 0 ? w[i] : x[i];
      unknown = 0;
      const Real at_zero = force(i, x, w);
      unknown = 1;
      const Real slope = force(i, x, w) - at_zero;
      unknown = -at_zero / slope;
    }
  }

  State rate(Real at, Vector x, Vector w) const {
    time_ = at;
    complete(x, w);
    Vector forces(end_ - begin_), acceleration = Vector::Zero(n_);
    for (Eigen::Index i = begin_; i < end_; ++i) forces[i - begin_] = force(i, x, w);
    acceleration.segment(begin_, end_ - begin_) = inverse_ * forces;
    return {w, acceleration};
  }

  State stepped(Real tau) const {
    const auto [a1, b1] = rate(t, u, v);
    const auto [a2, b2] = rate(t + tau / 2, u + tau / 2 * a1, v + tau / 2 * b1);
    const auto [a3, b3] = rate(t + tau / 2, u + tau / 2 * a2, v + tau / 2 * b2);
    const auto [a4, b4] = rate(t + tau, u + tau * a3, v + tau * b3);
    State result{u + tau / 6 * (a1 + 2 * a2 + 2 * a3 + a4), v + tau / 6 * (b1 + 2 * b2 + 2 * b3 + b4)};
    time_ = t + tau;
    complete(result.first, result.second);
    return result;
  }

  const BarSystem& system_;
  Eigen::Index n_, begin_, end_;
  Real stiffness_, damping_, step_;
  Matrix inverse_;
  std::vector<PenaltyLaw> laws_;
  std::vector<bool> closed_;
  mutable std::optional<LoadVector> load_;
  mutable Real time_ = 0;

 public:
  Real t = 0;
  Vector u, v;
  std::vector<Change> changes;
};

}  // namespace viscobar::testing_support

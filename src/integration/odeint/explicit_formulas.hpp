#pragma once

#include <algorithm>
#include <boost/numeric/odeint/stepper/runge_kutta_dopri5.hpp>
#include <boost/numeric/odeint/stepper/symplectic_rkn_sb3a_mclachlan.hpp>
#include <cmath>
#include <limits>
#include <span>
#include <vector>

#include "integration/step_polynomial.hpp"

namespace viscobar {

/// The explicit form y' = (w, (rho M)^{-1} F(t, u, w)) that Odeint asks for: the mass is inverted in every evaluation.
/// The w of a massless node follows from its row, its entry in y stands still.
class FirstOrder {
 public:
  FirstOrder(PenalisedSystem& of, Statistics& counted) : system(of), statistics_(counted) {}

  void operator()(double t, std::span<const double> y, std::span<double> rate) {
    const std::size_t n = system.size();
    const std::span<const double> u = y.first(n);
    const std::span<double> w = rate.first(n), a = rate.subspan(n, n);
    std::ranges::copy(y.subspan(n, n), w.begin());
    system.complete_velocity(t, u, w);
    system.force(t, u, w, a);
    system.bar().accelerate(a);
    ++statistics_.rhs_evaluations;
  }

  PenalisedSystem& system;

 private:
  Statistics& statistics_;
};

/// The acceleration in a rate (w, a).
inline void take_acceleration(std::span<const double> rate, StepPolynomial::End& end) {
  std::ranges::copy(rate.subspan(end.a.size(), end.a.size()), end.a.begin());
}

/// max |error_i weight_i|; infinite when the new state is not finite.
inline double weighted_error(std::span<const double> error, std::span<const double> weights,
                             std::span<const double> state) {
  double largest = 0.0, sum = 0.0;
  for (std::size_t i = 0; i < weights.size(); ++i) {
    largest = std::max(largest, std::abs(error[i] * weights[i]));
    sum += state[i];
  }
  return std::isfinite(sum) ? largest : std::numeric_limits<double>::infinity();
}

/// Dormand and Prince's explicit formulas of order 5 with an error estimate of order 4; the rate at the end of a step
/// is the first one of the next.
class Dopri5 {
 public:
  static constexpr double error_order = 5.0;  // of a step

  Dopri5(PenalisedSystem& system, Statistics& statistics)
      : form_(system, statistics),
        state_(2 * system.size()),
        rate_(state_),
        next_(state_),
        next_rate_(state_),
        error_(state_) {}

  void begin_leg(StepPolynomial::End& start) {
    std::copy_n(start.y.begin(), state_.size(), state_.begin());
    form_(start.t, state_, rate_);
    take_acceleration(rate_, start);
  }

  double attempt(double t, double h, std::span<const double> weights, StepPolynomial::End& reached) {
    const auto rate = [this](const std::vector<double>& y, std::vector<double>& out, double at) { form_(at, y, out); };
    stepper_.do_step(rate, state_, rate_, t, next_, next_rate_, h, error_);
    const double error = weighted_error(error_, weights, next_);
    if (error <= 1.0) {
      state_.swap(next_);
      rate_.swap(next_rate_);
      std::ranges::copy(state_, reached.y.begin());
      take_acceleration(rate_, reached);
    }
    return error;
  }

 private:
  FirstOrder form_;
  std::vector<double> state_, rate_, next_, next_rate_, error_;
  boost::numeric::odeint::runge_kutta_dopri5<std::vector<double>> stepper_;
};

/// McLachlan's symmetric symplectic Runge-Kutta-Nystroem formulas of order 4 with six stages, for u'' = a(t, u): no
/// viscosity, no dashpot, a mass at each node. Time is one more coordinate, of rate 1, because the formulas are those
/// of an autonomous system.
class Symplectic {
 public:
  using Formulas = boost::numeric::odeint::symplectic_rkn_sb3a_mclachlan<std::vector<double>>;

  Symplectic(PenalisedSystem& system, Statistics& statistics)
      : system_(system),
        statistics_(statistics),
        still_(system.size(), 0.0),
        coordinates_(system.size() + 1),
        rates_(system.size() + 1) {}

  void begin_leg(StepPolynomial::End& start) { find_acceleration(start); }

  /// Makes a step; its error is not estimated.
  void step(double t, double h, std::span<const double> start, StepPolynomial::End& reached) {
    const std::size_t n = still_.size();
    std::ranges::copy(start.first(n), coordinates_.begin());
    std::ranges::copy(start.subspan(n, n), rates_.begin());
    coordinates_[n] = t;
    rates_[n] = 1.0;
    const auto acceleration = [&](const std::vector<double>& q, std::vector<double>& out) {
      accelerate(q[n], std::span(q).first(n), std::span(out).first(n));
      out[n] = 0.0;
    };
    stepper_.do_step(acceleration, coordinates_, rates_, t, h);
    std::copy_n(coordinates_.begin(), n, reached.y.begin());
    std::copy_n(rates_.begin(), n, std::span(reached.y).subspan(n).begin());
    find_acceleration(reached);
  }

 private:
  void find_acceleration(StepPolynomial::End& end) { accelerate(end.t, std::span(end.y).first(still_.size()), end.a); }
  void accelerate(double t, std::span<const double> u, std::span<double> a) {
    system_.force(t, u, still_, a);
    system_.bar().accelerate(a);
    ++statistics_.rhs_evaluations;
  }

  PenalisedSystem& system_;
  Statistics& statistics_;
  std::vector<double> still_, coordinates_, rates_;
  Formulas stepper_;
};

}  // namespace viscobar

#pragma once

#include <algorithm>
#include <boost/numeric/odeint/stepper/runge_kutta_dopri5.hpp>
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
    system.acceleration(t, u, w, a);
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

}  // namespace viscobar

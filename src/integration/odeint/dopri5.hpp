#pragma once

#include <boost/numeric/odeint/stepper/runge_kutta_dopri5.hpp>
#include <span>
#include <vector>

#include "integration/odeint/first_order.hpp"
#include "integration/step_polynomial.hpp"

namespace viscobar {

/// Dormand and Prince's explicit formulas of order 5 with an error estimate of order 4; the rate at the end of a step
/// is the first one of the next.
class Dopri5 {
 public:
  static constexpr double error_order = 5.0;  // of a step

  Dopri5(PenalisedSystem& system, Statistics& statistics)
      : form_(system, statistics), state_(2 * system.size()), rate_(state_), next_(state_), next_rate_(state_) {}

  void begin_leg(StepPolynomial::End& start) {
    std::copy_n(start.y.begin(), state_.size(), state_.begin());
    form_(start.t, state_, rate_);
    std::copy_n(rate_.begin() + static_cast<std::ptrdiff_t>(start.a.size()), start.a.size(), start.a.begin());
  }

  double attempt(double t, double h, std::span<const double> weights, StepPolynomial::End& reached) {
    error_.resize(state_.size());
    const auto rate = [this](const std::vector<double>& y, std::vector<double>& out, double at) { form_(at, y, out); };
    stepper_.do_step(rate, state_, rate_, t, next_, next_rate_, h, error_);
    const double error = weighted_error(error_, weights, next_);
    if (error <= 1.0) {
      state_.swap(next_);
      rate_.swap(next_rate_);
      std::copy_n(state_.begin(), state_.size(), reached.y.begin());
      std::copy_n(rate_.begin() + static_cast<std::ptrdiff_t>(reached.a.size()), reached.a.size(), reached.a.begin());
    }
    return error;
  }

 private:
  FirstOrder form_;
  std::vector<double> state_, rate_, next_, next_rate_, error_;
  boost::numeric::odeint::runge_kutta_dopri5<std::vector<double>> stepper_;
};

}  // namespace viscobar

#pragma once

#include <boost/numeric/odeint/stepper/symplectic_rkn_sb3a_mclachlan.hpp>
#include <span>
#include <vector>

#include "dynamics/penalised_system.hpp"
#include "integration/step_polynomial.hpp"
#include "viscobar/run/run.hpp"

namespace viscobar {

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
    std::copy_n(start.begin(), n, coordinates_.begin());
    std::copy_n(start.begin() + static_cast<std::ptrdiff_t>(n), n, rates_.begin());
    coordinates_[n] = t;
    rates_[n] = 1.0;
    const auto acceleration = [&](const std::vector<double>& q, std::vector<double>& out) {
      accelerate(q[n], std::span(q).first(n), std::span(out).first(n));
      out[n] = 0.0;
    };
    stepper_.do_step(acceleration, coordinates_, rates_, t, h);
    std::copy_n(coordinates_.begin(), n, reached.y.begin());
    std::copy_n(rates_.begin(), n, reached.y.begin() + static_cast<std::ptrdiff_t>(n));
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

#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <span>

#include "dynamics/penalised_system.hpp"
#include "integration/layout.hpp"
#include "viscobar/run/run.hpp"

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
    std::copy_n(y.begin() + static_cast<std::ptrdiff_t>(n), n, w.begin());
    system.complete_velocity(t, u, w);
    system.force(t, u, w, a);
    system.bar().accelerate(a);
    ++statistics_.rhs_evaluations;
  }

  PenalisedSystem& system;

 private:
  Statistics& statistics_;
};

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

}  // namespace viscobar

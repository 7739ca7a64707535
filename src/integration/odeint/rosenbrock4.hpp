#pragma once

#include <algorithm>
#include <cmath>
#include <span>
#include <vector>

#include "dynamics/relaxing_rows.hpp"
#include "integration/odeint/dense_rosenbrock.hpp"
#include "integration/odeint/explicit_formulas.hpp"

namespace viscobar {

/// Linearly implicit formulas of order 4, L-stable, with an error estimate of order 3: one dense factorisation of order
/// 2 n and six solves a step. They are given z = (u, tau w), tau the power of two next to L / c below it: so the rows
/// have one unit, and which of them is a pivot does not depend on the units of the scene.
class Rosenbrock4 {
 public:
  static constexpr double error_order = 4.0;  // of a step

  Rosenbrock4(PenalisedSystem& system, Statistics& statistics)
      : form_(system, statistics),
        statistics_(statistics),
        size_(2 * system.size()),
        rate_(size_),
        load_rate_(system.size()),
        state_(size_),
        tau_(power_of_two(system.bar().bar().length * system.bar().bar().slowness())),
        dense_(
            size_,
            [this](double t, const double* z, double* rate) {
              to_state(z, state_);
              form_(t, state_, {rate, size_});
              multiply_velocities({rate, size_}, tau_);
            },
            [this](double t, double* rate) {
              find_time_rate(t, {rate, size_});
              multiply_velocities({rate, size_}, tau_);
            }) {}
  Rosenbrock4(const Rosenbrock4&) = delete;
  Rosenbrock4& operator=(const Rosenbrock4&) = delete;

  void begin_leg(StepPolynomial::End& start) {
    find_jacobian();
    std::copy_n(start.y.begin(), size_, dense_.state());
    multiply_velocities({dense_.state(), size_}, tau_);
    to_state(dense_.state(), state_);
    form_(start.t, state_, rate_);
    take_acceleration(rate_, start);
  }

  double attempt(double t, double h, std::span<const double> weights, StepPolynomial::End& reached) {
    dense_.attempt(t, h);
    ++statistics_.matrix_factorisations;
    statistics_.linear_solves += 6;
    to_state(dense_.error(), rate_);
    to_state(dense_.next(), state_);
    const double error = weighted_error(rate_, weights, state_);
    if (error <= 1.0) {
      const bool stiff = StepPolynomial::spoils_acceleration(form_.system, h);
      if (stiff) {
        dense_.rate(rate_.data());
        multiply_velocities(rate_, 1.0 / tau_);
      }
      dense_.accept();
      to_state(dense_.state(), state_);
      std::ranges::copy(state_, reached.y.begin());
      if (!stiff) form_(reached.t, state_, rate_);
      take_acceleration(rate_, reached);
    }
    return error;
  }

 private:
  // Products with it are exact.
  static double power_of_two(double value) { return std::exp2(std::floor(std::log2(value))); }

  static void multiply_velocities(std::span<double> y, double factor) {
    for (double& w : y.subspan(y.size() / 2)) w *= factor;
  }
  void to_state(const double* z, std::vector<double>& y) const {
    std::copy_n(z, size_, y.begin());
    multiply_velocities(y, 1.0 / tau_);
  }

  // On a leg the rate is linear in y: by the rows' own matrices, so that no constant part takes digits from it.
  void find_jacobian() {
    const PenalisedSystem& system = form_.system;
    const std::size_t n = system.size();
    BandedMatrix damping, stiffness;
    system.dynamic_stiffness(0.0, 1.0, 0.0, damping);
    system.dynamic_stiffness(0.0, 0.0, 1.0, stiffness);
    std::vector<unsigned char> held(n);
    for (std::size_t i = 0; i < n; ++i)
      if (std::isinf(stiffness.diagonal[i])) held[i] = 1, stiffness.diagonal[i] = damping.diagonal[i] = 0.0;
    std::vector<double> u(n), w(n), elastic(n), viscous(n);
    for (std::size_t j = 0; j < size_; ++j) {
      std::ranges::fill(u, 0.0);
      std::ranges::fill(w, 0.0);
      (j < n ? u[j] : w[j - n]) = j < n ? 1.0 : 1.0 / tau_;
      stiffness.multiply(u, elastic);
      for (const std::size_t end : {std::size_t{0}, n - 1}) {
        if (!system.bar().inertia().massless(end)) continue;
        w[end] = 0.0;
        damping.multiply(w, viscous);
        if (!held[end]) w[end] = -(elastic[end] + viscous[end]) / damping.diagonal[end];
      }
      damping.multiply(w, viscous);
      for (std::size_t i = 0; i < n; ++i) viscous[i] = -(elastic[i] + viscous[i]);
      system.bar().inertia().accelerate(viscous);
      for (std::size_t i = 0; i < n; ++i) {
        dense_.jacobian(i, j) = w[i];
        dense_.jacobian(n + i, j) = tau_ * viscous[i];
      }
    }
  }

  void find_time_rate(double t, std::span<double> out) {
    std::ranges::fill(out, 0.0);
    PenalisedSystem& system = form_.system;
    if (!system.load().varies()) return;
    const std::size_t n = system.size();
    const Bar& bar = system.bar().bar();
    const auto [before, after] = system.load().beside(t);
    if (!(before < after)) return;
    for (std::size_t i = 0; i < n; ++i) load_rate_[i] = -system.load().at(i, before);
    for (std::size_t i = 0; i < n; ++i) load_rate_[i] = (load_rate_[i] + system.load().at(i, after)) / (after - before);
    const std::span<double> a = out.subspan(n, n);
    std::ranges::copy(load_rate_, a.begin());
    // A massless node passes the load's effect on its velocity on to its neighbour.
    for (const auto& row : relaxing_rows(system.contacts())) {
      out[row.unknown] = row.load_share * load_rate_[row.unknown];
      a[row.neighbours[0].unknown] +=
          bar.viscosity / system.bar().elements().stretch_beside(row.unknown) * out[row.unknown];
    }
    system.bar().inertia().accelerate(a);
  }

  FirstOrder form_;
  Statistics& statistics_;
  std::size_t size_;
  std::vector<double> rate_, load_rate_, state_;  // the last as y
  double tau_;                                    // of the scene
  DenseRosenbrock dense_;
};

}  // namespace viscobar

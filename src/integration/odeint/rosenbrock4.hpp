#pragma once

#include <algorithm>
#include <array>
#include <boost/numeric/odeint/stepper/rosenbrock4.hpp>
#include <span>
#include <vector>

#include "integration/odeint/explicit_formulas.hpp"
#include "integration/step_matrix.hpp"

namespace viscobar {

/// Linearly implicit formulas of order 4, L-stable, with an error estimate of order 3, by Odeint's coefficients. f(t,
/// y) is the rate of y = (u, w), J and f_t are its derivatives, and g = gamma h:
///
///     (1 - g J) k_i = g (f(t_i, y + sum_{j<i} a_ij k_j) + sum_{j<i} c_ij k_j / h + theta_i h f_t),    i = 1, ..., 6,
///     y_1 = y + sum_{j<6} a_6j k_j + k_6,    error = k_6.
///
/// Time is one more unknown, of rate 1. Its increment in stage i is theta_i h, by the same formulas. With Odeint's own
/// coefficients of h f_t the order is 2 only.
///
/// F is linear in u and w as long as no contact changes. So the row of u goes into that of w, and a stage is one
/// tridiagonal solve with the matrix D(1, g, g^2) of PenalisedSystem::dynamic_stiffness():
///
///     D(1, g, g^2) k_w = g (F(t_i, u_i + g r, w_i) + rho M sum c_ij k_w,j / h + theta_i h F_t),    k_u = g (r + k_w),
///     r = w_i + sum c_ij k_u,j / h.
///
/// The row of a massless node holds with the velocity that follows from it in place of w. That of y stands still.
class Rosenbrock4 {
 public:
  static constexpr double error_order = 4.0;  // of a step

  Rosenbrock4(PenalisedSystem& system, Statistics& statistics)
      : form_(system, statistics),
        statistics_(statistics),
        n_(system.size()),
        state_(2 * n_),
        at_(state_),
        rate_(state_),
        load_rate_(n_),
        momentum_(n_) {
    for (std::vector<double>& stage : stages_) stage.resize(2 * n_);
  }

  void begin_leg(StepPolynomial::End& start) {
    std::copy_n(start.y.begin(), 2 * n_, state_.begin());
    form_(start.t, state_, rate_);
    take_acceleration(rate_, start);
  }

  double attempt(double t, double h, std::span<const double> weights, StepPolynomial::End& reached) {
    std::ranges::fill(load_rate_, 0.0);
    form_.system.load().add_rate(t, load_rate_);
    const double g = gamma * h;
    factorise_step(form_.system, 1.0, g, g * g, matrix_, factor_);
    ++statistics_.matrix_factorisations;
    std::array<double, count> time{};
    for (std::size_t i = 0; i < count; ++i) {
      double at = t;
      time[i] = 1.0;
      for (std::size_t j = 0; j < i; ++j) at += a[i][j] * time[j] * h, time[i] += c[i][j] * time[j];
      time[i] *= gamma;
      solve_stage(i, at, h, time[i] * h);
    }
    for (std::size_t k = 0; k < 2 * n_; ++k) at_[k] += stages_.back()[k];
    const double error = weighted_error(stages_.back(), weights, at_);
    if (error <= 1.0) {
      std::ranges::copy(at_, reached.y.begin());
      if (StepPolynomial::spoils_acceleration(form_.system, h)) {
        // By the formulas' own interpolation, of order 3: the rate would make of an error of y, however small, its
        // multiple by the fastest decay. It is (1 - s) y_0 + s y_1 + s (1 - s) (p + s q).
        for (std::size_t k = n_; k < 2 * n_; ++k) {
          double bent = 0.0;
          for (std::size_t j = 0; j < d.size(); ++j) bent += d[j] * stages_[j][k];
          reached.a[k - n_] = (at_[k] - state_[k] - bent) / h;
        }
      } else {
        form_(reached.t, at_, rate_);
        take_acceleration(rate_, reached);
      }
      state_.swap(at_);
    }
    return error;
  }

 private:
  static constexpr std::size_t count = 6;
  using Row = std::array<double, count>;
  inline static const boost::numeric::odeint::default_rosenbrock_coefficients<double> tableau;
  inline static const double gamma = tableau.gamma;
  inline static const std::array<Row, count> a{{{},
                                                {tableau.a21},
                                                {tableau.a31, tableau.a32},
                                                {tableau.a41, tableau.a42, tableau.a43},
                                                {tableau.a51, tableau.a52, tableau.a53, tableau.a54},
                                                {tableau.a51, tableau.a52, tableau.a53, tableau.a54, 1.0}}};
  inline static const std::array<Row, count> c{{{},
                                                {tableau.c21},
                                                {tableau.c31, tableau.c32},
                                                {tableau.c41, tableau.c42, tableau.c43},
                                                {tableau.c51, tableau.c52, tableau.c53, tableau.c54},
                                                {tableau.c61, tableau.c62, tableau.c63, tableau.c64, tableau.c65}}};
  // p + q
  inline static const std::array<double, 5> d{tableau.d21 + tableau.d31, tableau.d22 + tableau.d32,
                                              tableau.d23 + tableau.d33, tableau.d24 + tableau.d34,
                                              tableau.d25 + tableau.d35};

  void solve_stage(std::size_t i, double t, double h, double time) {
    PenalisedSystem& system = form_.system;
    const double g = gamma * h;
    std::vector<double>& stage = stages_[i];
    const auto combine = [&](const Row& by, double scale, std::size_t begin, std::size_t end, double* out) {
      for (std::size_t j = 0; j < i; ++j) {
        const double factor = scale * by[j], *of_j = stages_[j].data();
        if (factor == 0.0) continue;
        for (std::size_t k = begin; k < end; ++k) out[k] += factor * of_j[k];
      }
    };
    std::ranges::copy(state_, at_.begin());
    combine(a[i], 1.0, 0, 2 * n_, at_.data());
    std::ranges::fill(stage, 0.0);
    combine(c[i], 1.0 / h, 0, 2 * n_, stage.data());
    const std::span<double> u = std::span(rate_).first(n_), w = std::span(rate_).last(n_);
    std::ranges::copy(std::span(at_).last(n_), w.begin());
    system.complete_velocity(t, std::span(at_).first(n_), w);
    for (std::size_t k = 0; k < n_; ++k) {
      stage[k] += w[k];
      u[k] = at_[k] + g * stage[k];
    }
    const std::span<double> right = std::span(stage).last(n_);
    system.bar().inertia().matrix().multiply(right, momentum_);
    system.force(t, u, w, right);
    ++statistics_.rhs_evaluations;
    for (std::size_t k = 0; k < n_; ++k) right[k] = g * (right[k] + momentum_[k] + time * load_rate_[k]);
    factor_.solve(right);
    ++statistics_.linear_solves;
    for (std::size_t k = 0; k < n_; ++k) stage[k] = g * (stage[k] + right[k]);
    for (const std::size_t end : {std::size_t{0}, n_ - 1})
      if (system.bar().inertia().massless(end)) right[end] = 0.0;
  }

  FirstOrder form_;
  Statistics& statistics_;
  std::size_t n_;
  std::vector<double> state_, at_, rate_, load_rate_, momentum_;
  std::array<std::vector<double>, count> stages_;
  BandedMatrix matrix_;
  TridiagonalFactor factor_;
};

}  // namespace viscobar

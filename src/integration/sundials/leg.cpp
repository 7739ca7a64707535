#include "integration/sundials/leg.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <utility>

#include "integration/accounts/energy_flow.hpp"
#include "integration/step_matrix.hpp"
#include "run/step_failure.hpp"

namespace viscobar::sundials {

namespace {

/// The forces of contacts have not been found: a shorter step is easier.
struct NoConvergence {};

// x <- A^{-1} x, A by rows, which is lost.
void eliminate(std::span<double> a, std::span<double> x) {
  const std::size_t n = x.size();
  for (std::size_t k = 0; k < n; ++k)
    for (std::size_t i = k + 1; i < n; ++i) {
      const double share = a[i * n + k] / a[k * n + k];
      for (std::size_t j = k + 1; j < n; ++j) a[i * n + j] -= share * a[k * n + j];
      x[i] -= share * x[k];
    }
  for (std::size_t i = n; i-- > 0;) {
    for (std::size_t j = i + 1; j < n; ++j) x[i] -= a[i * n + j] * x[j];
    x[i] /= a[i * n + i];
  }
}

}  // namespace

void Leg::solve(double m, double c, double k, std::span<double> x) {
  if (!factorised_ || m != m_ || c != c_ || k != k_ || revision_ != system.contacts().revision()) {
    factorise_step(system, m, c, k, matrix_, factor_);
    m_ = m, c_ = c, k_ = k, revision_ = system.contacts().revision();
    factorised_ = true, columns_known_ = false;
    ++statistics.matrix_factorisations;
  }
  factor_.solve(x);
  ++statistics.linear_solves;
  // A sweep carries what is not finite to the ends.
  if (!std::isfinite(x.front()) || !std::isfinite(x.back())) throw not_finite();
}

void Leg::find_columns() {
  if (std::exchange(columns_known_, true)) return;
  columns_.clear();
  for (std::size_t i = 0; system.contacts().bend() && i < system.contacts().size(); ++i) {
    if (!system.contacts()[i].law.bent() || !system.contacts().closed(i)) continue;
    Column& column = columns_.emplace_back(Column{i, std::vector<double>(layout.nodes, 0.0)});
    const std::size_t node = system.contacts()[i].unknown;
    column.z[node] = 1.0;
    if (system.contacts()[i].joint > 0) column.z[node - 1] = -1.0;
    factor_.solve(column.z);
    ++statistics.linear_solves;
  }
  newton_.resize(columns_.size() * (columns_.size() + 1));
}

void Leg::solve(PenalisedSystem& forces, double m, double c, double k, const Increment& to, std::span<double> x) {
  solve(m, c, k, x);
  if (!system.contacts().bend()) return;
  find_columns();
  const std::size_t count = columns_.size(), n = layout.nodes;
  for (Column& at : columns_) {
    const Contact& contact = forces.contacts()[at.contact];
    const double u = contact.of({to.u, n}) + (to.explicit_u ? contact.of({to.explicit_u, n}) : 0.0);
    at.clearance = contact.sign * u + forces.contacts().offset(at.contact);
    at.w = contact.of({to.w, n});
    at.force = forces.contacts()[at.contact].law.force(at.clearance, at.w);
    at.start = contact.of(x), at.y = 0.0;
  }
  // y_j - start_j - sum_l z_jl added_l = 0; its Jacobian is 1 + z (k dN/dd + c dN/dd'), positive definite where D is.
  constexpr int most = 50;
  const std::span<double> residual = std::span(newton_).last(count);
  double change = std::numeric_limits<double>::infinity(), size = 0.0;
  for (int iteration = 0; change > 1e-13 * size && count > 0; ++iteration) {
    if (iteration == most) throw NoConvergence{};
    for (Column& at : columns_) {
      const double u = at.clearance + forces.contacts()[at.contact].sign * (k / to.factor) * at.y;
      const double v = at.w + c / to.factor * at.y;
      at.added = to.factor * (forces.contacts()[at.contact].law.force(u, v) - at.force);
      const PenaltyLaw tangent = forces.contacts()[at.contact].law.tangent(u, v);
      at.slope = k * tangent.stiffness + c * tangent.damping;
    }
    for (std::size_t j = 0; j < count; ++j) {
      const Contact& contact = forces.contacts()[columns_[j].contact];
      residual[j] = columns_[j].y - columns_[j].start;
      for (std::size_t l = 0; l < count; ++l) {
        const double coupling = contact.of(columns_[l].z);
        residual[j] -= coupling * columns_[l].added;
        newton_[j * count + l] = (j == l ? 1.0 : 0.0) + coupling * columns_[l].slope;
      }
    }
    eliminate(std::span(newton_).first(count * count), residual);
    change = size = 0.0;
    for (std::size_t j = 0; j < count; ++j) {
      columns_[j].y -= residual[j];
      change = std::max(change, std::abs(residual[j]));
      size = std::max({size, std::abs(columns_[j].y), std::abs(columns_[j].start)});
    }
    if (!std::isfinite(change)) throw NoConvergence{};
  }
  for (const Column& at : columns_)
    for (std::size_t i = 0; i < x.size(); ++i) x[i] += at.added * at.z[i];
}

// Solves for (u, w) or for a derivative of it, whose forces are those.
void Leg::solve_momentum(PenalisedSystem& forces, double t, double gamma, std::span<const double> y, double factor,
                         std::span<const double> z, std::span<double> x) {
  const std::size_t n = layout.nodes;
  const double *u = y.data(), *w = u + n;
  double *x_u = x.data(), *x_w = x_u + n, *explicit_u = field.data();
  for (std::size_t i = 0; i < n; ++i) {
    x_u[i] = gamma * w[i] + factor * z[i];
    explicit_u[i] = u[i] + x_u[i];
  }
  const std::span<double> right(x_w, n);
  forces.force(t, field, {w, n}, right);
  for (double& entry : right) entry *= gamma;
  subtract_inertia(-factor, z.subspan(n, n), right);
  solve(forces, 1.0, gamma, gamma * gamma, {u, x_u, w, gamma}, right);
  for (std::size_t i = 0; i < n; ++i) x_u[i] += gamma * x_w[i];
}

void Leg::solve_first_order(double t, double gamma, std::span<const double> y, double factor, std::span<const double> z,
                            std::span<double> x) {
  solve_momentum(system, t, gamma, y, factor, z, x);
  ++statistics.rhs_evaluations;
  const std::size_t n = layout.nodes;
  if (layout.size == 2 * n) return;
  const double *u = y.data(), *w = u + n, *x_u = x.data(), *x_w = x_u + n;
  for (std::size_t i = 0; i < n; ++i) field[i] = w[i] + x_w[i];
  for (std::size_t i = 0; i < acceleration.size(); ++i) acceleration[i] = (x_w[i] - factor * z[n + i]) / gamma;
  for (std::size_t i = 0; i < new_u.size(); ++i) new_u[i] = u[i] + x_u[i];
  account_rates(t, new_u, field, acceleration, x);
  account_correction = 0.0;
  for (std::size_t k = 2 * n; k < layout.first_derivative; ++k) {
    x[k] = gamma * x[k] + factor * z[k];
    account_correction = std::max(account_correction, std::abs(x[k]));
  }
  if (derivatives.empty()) return;
  for (std::size_t i = 0; i < n; ++i) new_w[i] = w[i] + x_w[i];
  const Moment at{t, new_u, new_w, acceleration};
  for (std::size_t k = 0; k < derivatives.size(); ++k) {
    derivatives[k]->drive(at);
    const auto s = layout.derivative(y, k), z_s = layout.derivative(z, k);
    const auto x_s = layout.derivative(x, k);
    solve_momentum(derivatives[k]->motion(), t, gamma, s, factor, z_s, x_s);
    impulse_rates(*derivatives[k], at, s, x_s, x_s.impulses());
    for (std::size_t i = 2 * n; i < layout.block; ++i) x_s[i] = gamma * x_s[i] + factor * z_s[i];
  }
}

void Leg::impulse_rates(Derivative& derivative, const Moment& at, std::span<const double> s, std::span<const double> x,
                        std::span<double> rates) {
  layout.each_impulse([&](std::size_t k, std::size_t end) {
    // Each has its rows and the node beside them, and with a side that resists the next one, too.
    const std::size_t last = end_rows(system.contacts(), end).last, beside = system.bar().side() ? 2 : 1;
    const std::size_t rows = end == 0 ? last : end - last;
    const std::size_t reach = std::min(layout.nodes, rows + 1 + beside);
    const auto sum = [&](std::size_t i) { return s[i] + (x.empty() ? 0.0 : x[i]); };
    for (std::size_t m = 0; m < reach; ++m) {
      const std::size_t i = end == 0 ? m : end - m;
      field[i] = sum(i);
    }
    rates[k] = derivative.momentum_loss(end, at, field, sum(layout.nodes + end));
  });
}

void Leg::evaluate(double t, std::span<double> y, std::span<double> rate) {
  const std::span<double> w = layout.u(rate), a = layout.w(rate);
  system.acceleration(t, layout.u(y), w, a);
  account_rates(t, layout.u(y), w, a, rate);
  derivative_rates(t, y, rate);
  ++statistics.rhs_evaluations;
}

void Leg::right_hand_side(double t, std::span<double> y, std::span<double> rate) {
  std::ranges::copy(layout.w(y), rate.begin());
  system.complete_velocity(t, layout.u(y), layout.u(rate));
  evaluate(t, y, rate);
}

void Leg::derivative_rates(double t, std::span<const double> y, std::span<double> y_rate) {
  if (derivatives.empty()) return;
  const Moment at{t, y.first(layout.nodes), layout.u(y_rate), layout.w(y_rate)};
  for (std::size_t k = 0; k < derivatives.size(); ++k) {
    Derivative& derivative = *derivatives[k];
    derivative.drive(at);
    const auto s = layout.derivative(y, k);
    const auto rate = layout.derivative(y_rate, k);
    std::ranges::copy(s.w(), rate.begin());
    derivative.motion().complete_velocity(t, s.u(), rate.u());
    derivative.motion().acceleration(t, s.u(), rate.u(), rate.w());
    impulse_rates(derivative, at, s, {}, rate.impulses());
  }
}

void Leg::subtract_inertia(double factor, std::span<const double> x, std::span<double> out) {
  const BandedMatrix& inertia = system.bar().inertia().matrix();
  const std::size_t n = out.size();
  if (inertia.is_diagonal()) {
    for (std::size_t i = 0; i < n; ++i) out[i] -= factor * inertia.diagonal[i] * x[i];
    return;
  }
  inertia.multiply(x, field);
  for (std::size_t i = 0; i < n; ++i) out[i] -= factor * field[i];
}

void Leg::account_rates(double t, std::span<const double> u, std::span<const double> w, std::span<const double> a,
                        std::span<double> y_rate) {
  if (layout.account() == 0) return;
  const std::array<double, 3> rates = energy_rates(system, layout, t, u, w, [a] { return a; });
  std::copy_n(rates.begin(), layout.account(), y_rate.begin() + static_cast<std::ptrdiff_t>(2 * layout.nodes));
}

NonlinearSolver make_step_solver(Leg& leg, const Context& context) {
  NonlinearSolver solver(SUNNonlinSolNewEmpty(context.get()));
  if (!solver) throw std::bad_alloc();
  solver->content = &leg;
  auto& ops = *solver->ops;
  ops.gettype = [](SUNNonlinearSolver) noexcept { return SUNNONLINEARSOLVER_ROOTFIND; };
  ops.initialize = [](SUNNonlinearSolver) noexcept { return 0; };
  // The system is known in closed form: what the integrator offers for evaluating it is not needed.
  ops.setsysfn = [](SUNNonlinearSolver, SUNNonlinSolSysFn) noexcept { return 0; };
  ops.solve = [](SUNNonlinearSolver self, N_Vector, N_Vector correction, N_Vector, sunrealtype, boolean,
                 void*) noexcept {
    Leg& of = *static_cast<Leg*>(self->content);
    bool converged = true;
    const int flag = guarded(of, [&] {
      try {
        of.solve_step(of, values(correction));
      } catch (const NoConvergence&) {
        converged = false;
      }
      of.correction = values(correction);
    });
    return converged ? flag : SUN_NLS_CONV_RECVR;
  };
  ops.free = [](SUNNonlinearSolver self) noexcept {
    SUNNonlinSolFreeEmpty(self);
    return 0;
  };
  return solver;
}

void fail(Leg& leg, const std::string& call, int flag, const std::string& name, Library library) {
  if (leg.error) std::rethrow_exception(std::exchange(leg.error, nullptr));
  const auto& [values, meaning, why] = return_flag(library, flag);
  throw StepFailure(why, fmt::format("{} ({} returned {}{}{})", meaning, call, name,
                                     leg.library_message.empty() ? "" : ": ", leg.library_message));
}

}  // namespace viscobar::sundials

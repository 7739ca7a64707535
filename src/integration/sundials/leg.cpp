#include "integration/sundials/leg.hpp"

#include <fmt/format.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace viscobar::sundials {

namespace {

double largest(std::span<const double> x) {
  return Eigen::Map<const Eigen::ArrayXd>(x.data(), static_cast<Eigen::Index>(x.size())).abs().maxCoeff();
}

}  // namespace

double ErrorWeights::displacement_tolerance() const {
  return (tolerance_.relative * largest_u_ + tolerance_.absolute) / tightening_;
}

void ErrorWeights::fill(std::span<double> y, double noise, std::span<double> weights) {
  largest_u_ = std::max(largest_u_, largest(layout_.u(y)));
  largest_w_ = std::max(largest_w_, largest(layout_.w(y)));
  // Below a few units of rounding no step could pass.
  const double relative = std::max(tolerance_.relative / tightening_, 16.0 * std::numeric_limits<double>::epsilon());
  const double absolute = tolerance_.absolute / tightening_;
  std::ranges::fill(layout_.u(weights), 1.0 / (relative * largest_u_ + absolute));
  const auto w = layout_.w(weights);
  // An error test that sees noise shrinks the step, which makes more of it.
  std::ranges::fill(w, 1.0 / std::max(relative * largest_w_ + absolute, 4.0 * noise));
  std::ranges::fill(w.first(massive_begin_), 0.0);
  std::ranges::fill(w.subspan(massive_end_), 0.0);
  std::ranges::fill(weights.subspan(2 * layout_.nodes), 0.0);
}

void Leg::solve(double m, double c, double k, std::span<double> x) {
  if (!factorised_ || m != m_ || c != c_ || k != k_ || revision_ != system.revision()) {
    system.dynamic_stiffness(m, c, k, matrix_);
    factor_.factorise(matrix_);
    m_ = m, c_ = c, k_ = k, revision_ = system.revision();
    factorised_ = true;
    ++statistics.matrix_factorisations;
  }
  factor_.solve(x);
  ++statistics.linear_solves;
  // A sweep carries what is not finite to the ends.
  if (!std::isfinite(x.front()) || !std::isfinite(x.back())) throw StepFailure("the solution is no longer finite");
}

void Leg::subtract_inertia(double factor, std::span<const double> x, std::span<double> out) {
  const SymmetricTridiagonal& inertia = system.bar().inertia();
  const std::size_t n = out.size();
  if (inertia.off_diagonal.empty()) {
    for (std::size_t i = 0; i < n; ++i) out[i] -= factor * inertia.diagonal[i] * x[i];
    return;
  }
  inertia.multiply(x, field);
  for (std::size_t i = 0; i < n; ++i) out[i] -= factor * field[i];
}

void Leg::account_rates(double t, std::span<const double> w, std::span<double> y_rate) {
  if (layout.dissipated) y_rate[*layout.dissipated] = system.dissipated_power(w);
  if (layout.work) y_rate[*layout.work] = system.load_power(t, w);
}

namespace {

struct StepSolver {
  Leg* leg;
  void (*solve)(Leg&, std::span<double>);
};

}  // namespace

NonlinearSolver make_step_solver(Leg& leg, void (*solve)(Leg&, std::span<double>), const Context& context) {
  NonlinearSolver solver(SUNNonlinSolNewEmpty(context.get()));
  if (!solver) throw std::bad_alloc();
  solver->content = new StepSolver{&leg, solve};
  auto& ops = *solver->ops;
  ops.gettype = [](SUNNonlinearSolver) noexcept { return SUNNONLINEARSOLVER_ROOTFIND; };
  ops.initialize = [](SUNNonlinearSolver) noexcept { return 0; };
  // The system is known in closed form: what the integrator offers for evaluating it is not needed.
  ops.setsysfn = [](SUNNonlinearSolver, SUNNonlinSolSysFn) noexcept { return 0; };
  ops.solve = [](SUNNonlinearSolver self, N_Vector, N_Vector correction, N_Vector, sunrealtype, boolean,
                 void*) noexcept {
    auto& step = *static_cast<StepSolver*>(self->content);
    return guarded(*step.leg, [&] { step.solve(*step.leg, values(correction)); });
  };
  ops.free = [](SUNNonlinearSolver self) noexcept {
    delete static_cast<StepSolver*>(self->content);
    self->content = nullptr;
    SUNNonlinSolFreeEmpty(self);
    return 0;
  };
  return solver;
}

void fail(Leg& leg, const char* call, std::string flag) {
  if (leg.error) std::rethrow_exception(std::exchange(leg.error, nullptr));
  throw StepFailure(
      fmt::format("{} returned {}{}{}", call, flag, leg.library_message.empty() ? "" : ": ", leg.library_message));
}

}  // namespace viscobar::sundials

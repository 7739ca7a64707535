#include <ida/ida.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <tuple>

#include "integration/stepwise_run.hpp"
#include "integration/sundials/multistep.hpp"
#include "viscobar/integration/integrate.hpp"

namespace viscobar {

namespace {

using namespace sundials;

const MultistepLibrary library{
    "IDA",          IDAGetDky,     IDAGetLastOrder, IDAGetCurrentTime, IDAGetLastStep,        IDASetMaxOrd,
    IDASetStopTime, IDASetMaxStep, IDASetUserData,  IDAWFtolerances,   IDASetNonlinearSolver, IDAGetReturnFlagName,
    Library::ida,   true};

// The corrector of IDA asks for x with G(t, y_pred + x, y'_pred + cj x) = 0, where
//     G_u = u' - w,      G_w = rho M w' - F(t, u, u').
// G_u gives x_w = cj x_u - q with q = w_pred - u'_pred, and then G_w
//     D(cj^2, cj, 1) x_u = F(t, u_pred, u'_pred) - rho M (w'_pred - cj q),
// which is also right for massless rows, with viscosity (a first-order equation) and without (an algebraic one).
void solve_step(Leg& leg, std::span<double> correction) {
  double t = 0.0, cj = 0.0;
  N_Vector predicted = nullptr, predicted_rate = nullptr, y = nullptr, y_rate = nullptr, residual = nullptr;
  void* user = nullptr;
  IDAGetNonlinearSystemData(leg.memory, &t, &predicted, &predicted_rate, &y, &y_rate, &residual, &cj, &user);
  const Layout& layout = leg.layout;
  const std::size_t n = layout.nodes;
  const std::span<const double> state = values(predicted), rates = values(predicted_rate);
  const auto solve_momentum = [&](PenalisedSystem& forces, const double* u, const double* u_rate, double* x_u) {
    const double *w = u + n, *w_rate = u_rate + n;
    double* x_w = x_u + n;
    const std::span<double> right(x_u, n);
    forces.force(t, {u, n}, {u_rate, n}, right);
    for (std::size_t i = 0; i < n; ++i) x_w[i] = w_rate[i] - cj * (w[i] - u_rate[i]);
    leg.subtract_inertia(1.0, {x_w, n}, right);
    leg.solve(forces, cj * cj, cj, 1.0, {u, nullptr, u_rate, 1.0}, right);
    for (std::size_t i = 0; i < n; ++i) x_w[i] = cj * x_u[i] - (w[i] - u_rate[i]);
  };
  const double *u = state.data(), *w = u + n, *u_rate = rates.data(), *w_rate = u_rate + n;
  double *x_u = correction.data(), *x_w = x_u + n;
  solve_momentum(leg.system, u, u_rate, x_u);
  ++leg.statistics.rhs_evaluations;
  if (layout.size == 2 * n) return;
  for (std::size_t i = 0; i < n; ++i) leg.field[i] = w[i] + x_w[i];
  for (std::size_t i = 0; i < leg.acceleration.size(); ++i) leg.acceleration[i] = w_rate[i] + cj * x_w[i];
  for (std::size_t i = 0; i < leg.new_u.size(); ++i) leg.new_u[i] = u[i] + x_u[i];
  leg.account_rates(t, leg.new_u, leg.field, leg.acceleration, correction);
  leg.account_correction = 0.0;
  for (std::size_t k = 2 * n; k < layout.first_derivative; ++k) {
    correction[k] = (correction[k] - u_rate[k]) / cj;
    leg.account_correction = std::max(leg.account_correction, std::abs(correction[k]));
  }
  if (leg.derivatives.empty()) return;
  for (std::size_t i = 0; i < n; ++i) leg.new_w[i] = u_rate[i] + cj * x_u[i];
  const Moment at{t, leg.new_u, leg.new_w, leg.acceleration};
  for (std::size_t k = 0; k < leg.derivatives.size(); ++k) {
    Derivative& derivative = *leg.derivatives[k];
    derivative.drive(at);
    const auto s = layout.derivative(state, k), s_rate = layout.derivative(rates, k);
    const auto x = layout.derivative(correction, k);
    solve_momentum(derivative.motion(), s.data(), s_rate.data(), x.data());
    leg.impulse_rates(derivative, at, s, x, x.impulses());
    for (std::size_t i = 2 * n; i < layout.block; ++i) x[i] = (x[i] - s_rate[i]) / cj;
  }
}

class IdaStepper final : public Multistep {
 public:
  IdaStepper(const StepperParts& parts, const Tolerance& tolerance)
      : Multistep(library, parts, tolerance, solve_step, true),
        rate_(make_vector(parts.layout.size, context_, parts.layout.first_derivative)) {}

 private:
  void begin_leg(double t) override {
    set_consistent_rate(t);
    begin_bdf(highest_bdf, t);
  }
  void begin_bdf(int order, double t) override {
    if (memory_)
      check("ReInit", IDAReInit(memory_.get(), t, state_.get(), rate_.get()));
    else
      create(t);
    begin_stretch(memory_.get(), order);
  }
  std::pair<const char*, int> step() override {
    return {"Solve", IDASolve(memory_.get(), stop_, &t_, state_.get(), rate_.get(), IDA_ONE_STEP)};
  }

  // y' that satisfies the equations: u' = w and rho M w' = F; massless velocities are dependent, their rate is free.
  void set_consistent_rate(double t) {
    std::ranges::copy(leg_.layout.w(values(state_)), values(rate_).begin());
    leg_.evaluate(t, values(state_), values(rate_));
  }

  void create(double t) {
    memory_.reset(IDACreate(context_.get()));
    if (!memory_) throw std::bad_alloc();
    // The library wants a residual function; the step solver evaluates the residual itself.
    const auto unused_residual = [](double, N_Vector, N_Vector, N_Vector, void*) noexcept { return -1; };
    const int begun = IDAInit(memory_.get(), unused_residual, t, state_.get(), rate_.get());
    // It has freed its vectors then, and IDAFree would do so again.
    if (begun == IDA_MEM_FAIL) std::ignore = memory_.release(), throw std::bad_alloc();
    check("Init", begun);
    VISCOBAR_KEEP_MESSAGES(IDA, memory_.get(), context_, leg_.library_message);
    configure(memory_.get(), t);
    // From rest the library begins with a thousandth of the run and finds its step by failing; ten times need not do.
    check("SetMaxErrTestFails", IDASetMaxErrTestFails(memory_.get(), 50));
  }

  Vector rate_;
  Memory<IDAFree> memory_;
};

}  // namespace

Statistics integrate(const BarSystem& system, const StartingPoint& start, std::span<const double> times,
                     const Ida& method, const Observers& observers) {
  return run_stepwise("ida", system, method.penalty, start, times, observers,
                      [&](const StepperParts& parts) { return std::make_unique<IdaStepper>(parts, method.tolerance); });
}

}  // namespace viscobar

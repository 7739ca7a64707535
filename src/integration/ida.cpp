#include <ida/ida.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <tuple>
#include <utility>

#include "integration/error_weights.hpp"
#include "integration/hull.hpp"
#include "integration/longest_step.hpp"
#include "integration/rest_watch.hpp"
#include "integration/stepwise_run.hpp"
#include "integration/sundials/leg.hpp"
#include "viscobar/integration/integrate.hpp"

namespace viscobar {

namespace {

using namespace sundials;

struct IdaDeleter {
  void operator()(void* memory) const noexcept { IDAFree(&memory); }
};

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
  const double *u = values(predicted).data(), *w = u + n;
  const double *u_rate = values(predicted_rate).data(), *w_rate = u_rate + n;
  double *x_u = correction.data(), *x_w = x_u + n;
  const std::span<double> right(x_u, n);
  leg.system.force(t, {u, n}, {u_rate, n}, right);
  ++leg.statistics.rhs_evaluations;
  for (std::size_t i = 0; i < n; ++i) x_w[i] = w_rate[i] - cj * (w[i] - u_rate[i]);
  leg.subtract_inertia(1.0, {x_w, n}, right);
  leg.solve(cj * cj, cj, 1.0, right);
  for (std::size_t i = 0; i < n; ++i) x_w[i] = cj * x_u[i] - (w[i] - u_rate[i]);
  if (layout.size == 2 * n) return;
  for (std::size_t i = 0; i < n; ++i) leg.field[i] = w[i] + x_w[i];
  for (std::size_t i = 0; i < leg.acceleration.size(); ++i) leg.acceleration[i] = w_rate[i] + cj * x_w[i];
  leg.account_rates(t, leg.field, leg.acceleration, correction);
  leg.account_correction = 0.0;
  for (std::size_t k = 2 * n; k < layout.size; ++k) {
    correction[k] = (correction[k] - u_rate[k]) / cj;
    leg.account_correction = std::max(leg.account_correction, std::abs(correction[k]));
  }
}

class IdaStepper {
 public:
  IdaStepper(PenalisedSystem& system, const Layout& layout, const Tolerance& tolerance, double end,
             Statistics& statistics)
      : leg_(system, layout, statistics),
        weights_(system, layout, tolerance, end, multistep_accumulation),
        end_(end),
        state_(make_vector(layout.size, context_)),
        rate_(make_vector(layout.size, context_)),
        interpolated_(make_vector(layout.size, context_)),
        solver_(make_step_solver(leg_, solve_step, context_)) {}

  void begin_run(std::vector<std::size_t> sampled_entries) {
    probed_.emplace(std::move(sampled_entries));
    probe_ = make_probe(*probed_, context_);
  }

  void restart(double t, double stop, std::span<const double> y) {
    stop_ = stop;
    weights_.tighten(leg_.statistics.events);
    std::ranges::copy(y, values(state_).begin());
    set_consistent_rate(t);
    rest_.begin_leg(leg_.system, t);
    begin(highest_order, t);
  }

  double advance() {
    double t = 0.0;
    const int flag = IDASolve(memory_.get(), stop_, &t, state_.get(), rate_.get(), IDA_ONE_STEP);
    require_memory();
    if (flag < 0) fail(leg_, "IDASolve", flag, flag_name(IDAGetReturnFlagName(flag)), ida_flags());
    advice_ = rest_.stepped(t, leg_.layout.w(values(state_)), weights_.promised_velocity());
    return t_ = t;
  }

  void before_step() {
    switch (std::exchange(advice_, RestWatch::Advice::go_on)) {
      case RestWatch::Advice::go_on: return;
      case RestWatch::Advice::damp: begin(2, t_); return weights_.pass_over(rest_.oscillation());
      case RestWatch::Advice::release:
        weights_.pass_over(0.0);
        return check("IDASetMaxOrd", IDASetMaxOrd(memory_.get(), highest_order));
      case RestWatch::Advice::give_back: return begin(highest_order, t_);
    }
  }

  std::size_t order() const {
    int order = 1;
    IDAGetLastOrder(memory_.get(), &order);
    return static_cast<std::size_t>(order);
  }

  void interpolate(double t, std::span<double> y) {
    check("IDAGetDky", IDAGetDky(memory_.get(), t, 0, interpolated_.get()));
    std::ranges::copy(values(interpolated_), y.begin());
  }

  std::span<const double> sample(double t, int derivative) {
    check("IDAGetDky", IDAGetDky(memory_.get(), t, derivative, probe_.get()));
    return values(probe_);
  }

  void select(std::span<const std::size_t> sampled) { probed_->selected.assign(sampled.begin(), sampled.end()); }
  void hull(std::span<double> lowest, std::span<double> highest) {
    double end = 0.0, length = 0.0;
    check("IDAGetCurrentTime", IDAGetCurrentTime(memory_.get(), &end));
    check("IDAGetLastStep", IDAGetLastStep(memory_.get(), &length));
    taylor_hull(
        order(), length, [&](int k) { return sample(end, k); }, lowest, highest);
  }

  double largest() const { return weights_.largest_displacement(); }
  double displacement_tolerance() const { return weights_.displacement_tolerance(); }
  ErrorWeights& weights() { return weights_; }
  double account_correction() const { return leg_.account_correction; }

 private:
  static constexpr int highest_order = 5;

  void begin(int order, double t) {
    if (memory_)
      check("IDAReInit", IDAReInit(memory_.get(), t, state_.get(), rate_.get()));
    else
      create(t);
    check("IDASetMaxOrd", IDASetMaxOrd(memory_.get(), order));
    check("IDASetStopTime", IDASetStopTime(memory_.get(), stop_));
    advice_ = RestWatch::Advice::go_on;
    weights_.pass_over(0.0);
  }

  // y' that satisfies the equations: u' = w and rho M w' = F; massless velocities are dependent, their rate is free.
  void set_consistent_rate(double t) {
    const Layout& layout = leg_.layout;
    const std::span<double> state = values(state_), rate = values(rate_);
    std::ranges::copy(layout.w(state), layout.u(rate).begin());
    leg_.system.force(t, layout.u(state), layout.w(state), layout.w(rate));
    leg_.system.accelerate(layout.w(rate));
    leg_.account_rates(t, layout.w(state), layout.w(rate), rate);
    ++leg_.statistics.rhs_evaluations;
  }

  void create(double t) {
    memory_.reset(IDACreate(context_.get()));
    if (!memory_) throw std::bad_alloc();
    void* memory = leg_.memory = memory_.get();
    // The library wants a residual function; the step solver evaluates the residual itself.
    const auto unused_residual = [](double, N_Vector, N_Vector, N_Vector, void*) noexcept { return -1; };
    const int begun = IDAInit(memory, unused_residual, t, state_.get(), rate_.get());
    // It has freed its vectors then, and IDAFree would do so again.
    if (begun == IDA_MEM_FAIL) std::ignore = memory_.release(), throw std::bad_alloc();
    check("IDAInit", begun);
    VISCOBAR_KEEP_MESSAGES(IDA, memory, context_, leg_.library_message);
    check("IDASetUserData", IDASetUserData(memory, this));
    check("IDAWFtolerances", IDAWFtolerances(memory, error_weights));
    check("IDASetNonlinearSolver", IDASetNonlinearSolver(memory, solver_.get()));
    if (leg_.system.load_varies()) check("IDASetMaxStep", IDASetMaxStep(memory, longest_step(leg_.system, end_ - t)));
    // From rest the library begins with a thousandth of the run and finds its step by failing; ten times need not do.
    check("IDASetMaxErrTestFails", IDASetMaxErrTestFails(memory, 50));
  }

  void check(const char* call, int flag) {
    require_memory();
    if (flag != IDA_SUCCESS) fail(leg_, call, flag, flag_name(IDAGetReturnFlagName(flag)), ida_flags());
  }

  static int error_weights(N_Vector y, N_Vector weights, void* user) noexcept {
    auto* stepper = static_cast<IdaStepper*>(user);
    stepper->weights_.fill(values(y), values(weights));
    return 0;
  }

  Context context_;
  Leg leg_;
  ErrorWeights weights_;
  RestWatch rest_;
  RestWatch::Advice advice_ = RestWatch::Advice::go_on;
  double end_, stop_ = 0.0, t_ = 0.0;  // of the run, of the leg, and now
  Vector state_, rate_, interpolated_;
  std::optional<Probed> probed_;
  Vector probe_;
  NonlinearSolver solver_;
  std::unique_ptr<void, IdaDeleter> memory_;
};

}  // namespace

Statistics integrate(const BarSystem& system, const StartingPoint& start, std::span<const double> times,
                     const Ida& method, const Observers& observers) {
  return run_in_parts(start, observers, [&](const StartingPoint& from) {
    PenalisedSystem penalised(system, method.penalty);
    const Layout layout(penalised, observers.energy);
    Statistics statistics = statistics_before(from);
    IdaStepper stepper(penalised, layout, method.tolerance, times.back(), statistics);
    return run_stepwise("ida", penalised, layout, stepper, statistics, from, times, observers);
  });
}

}  // namespace viscobar

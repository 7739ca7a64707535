#include <cvode/cvode.h>

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

struct CvodeDeleter {
  void operator()(void* memory) const noexcept { CVodeFree(&memory); }
};

// The corrector of CVODE asks for x with  x = gamma f(t, y_pred + x) - rl1 z,  z the scaled rate of the predictor.
void solve_step(Leg& leg, std::span<double> correction) {
  double t = 0.0, gamma = 0.0, rl1 = 0.0;
  N_Vector predicted = nullptr, current = nullptr, rate = nullptr, scaled_rate = nullptr;
  void* user = nullptr;
  CVodeGetNonlinearSystemData(leg.memory, &t, &predicted, &current, &rate, &gamma, &rl1, &scaled_rate, &user);
  leg.solve_first_order(t, gamma, values(predicted), -rl1, values(scaled_rate), correction);
}

using Memory = std::unique_ptr<void, CvodeDeleter>;

class CvodeStepper {
 public:
  CvodeStepper(PenalisedSystem& system, const Layout& layout, const Cvode& method, double end, Statistics& statistics)
      : leg_(system, layout, statistics),
        weights_(system, layout, method.tolerance, end, multistep_accumulation),
        formulas_(method.formulas),
        end_(end),
        state_(make_vector(layout.size, context_)),
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
    rest_.begin_leg(leg_.system, t);
    begin(t);
  }

  double advance() {
    double t = 0.0;
    const int flag = CVode(memory_, stop_, state_.get(), &t, CV_ONE_STEP);
    require_memory();
    if (flag < 0) fail(leg_, "CVode", flag, flag_name(CVodeGetReturnFlagName(flag)), cvode_flags());
    if (formulas_ == Formulas::automatic)
      advice_ = rest_.stepped(t, leg_.layout.w(values(state_)), weights_.promised_velocity());
    return t_ = t;
  }

  void before_step() {
    switch (std::exchange(advice_, RestWatch::Advice::go_on)) {
      case RestWatch::Advice::go_on: return;
      case RestWatch::Advice::damp: begin(bdf_, CV_BDF, 2, t_); return weights_.pass_over(rest_.oscillation());
      case RestWatch::Advice::release:
        weights_.pass_over(0.0);
        return check("CVodeSetMaxOrd", CVodeSetMaxOrd(memory_, highest_bdf));
      case RestWatch::Advice::give_back: return begin(bdf_, CV_BDF, highest_bdf, t_);
    }
  }

  std::size_t order() const {
    int order = 1;
    CVodeGetLastOrder(memory_, &order);
    return static_cast<std::size_t>(order);
  }

  void interpolate(double t, std::span<double> y) {
    check("CVodeGetDky", CVodeGetDky(memory_, t, 0, interpolated_.get()));
    std::ranges::copy(values(interpolated_), y.begin());
  }

  std::span<const double> sample(double t, int derivative) {
    check("CVodeGetDky", CVodeGetDky(memory_, t, derivative, probe_.get()));
    return values(probe_);
  }

  void select(std::span<const std::size_t> sampled) { probed_->selected.assign(sampled.begin(), sampled.end()); }
  void hull(std::span<double> lowest, std::span<double> highest) {
    double end = 0.0, length = 0.0;
    check("CVodeGetCurrentTime", CVodeGetCurrentTime(memory_, &end));
    check("CVodeGetLastStep", CVodeGetLastStep(memory_, &length));
    taylor_hull(
        order(), length, [&](int k) { return sample(end, k); }, lowest, highest);
  }

  double largest() const { return weights_.largest_displacement(); }
  double displacement_tolerance() const { return weights_.displacement_tolerance(); }
  ErrorWeights& weights() { return weights_; }
  double account_correction() const { return leg_.account_correction; }

 private:
  static constexpr int highest_adams = 12, highest_bdf = 5;

  void begin(double t) { stiff() ? begin(bdf_, CV_BDF, highest_bdf, t) : begin(adams_, CV_ADAMS, highest_adams, t); }

  void begin(Memory& memory, int formulas, int order, double t) {
    memory_ = memory.get();
    if (memory_)
      check("CVodeReInit", CVodeReInit(memory_, t, state_.get()));
    else
      create(memory, formulas, t);
    check("CVodeSetMaxOrd", CVodeSetMaxOrd(memory_, order));
    leg_.memory = memory_;
    advice_ = RestWatch::Advice::go_on;
    weights_.pass_over(0.0);
    check("CVodeSetStopTime", CVodeSetStopTime(memory_, stop_));
  }

  // Adams' formulas, of order up to 12, where every motion is an oscillation that has to be resolved anyway; backward
  // differentiation where something fast dies out: modes of the mesh that are overdamped (eta omega >= 2 E at the
  // highest, omega = sqrt(12 E / rho) / h), or a massless node.
  bool stiff() const {
    if (formulas_ != Formulas::automatic) return formulas_ == Formulas::bdf;
    const BarSystem& bar = leg_.system.bar();
    const Bar& material = bar.bar();
    const double highest = std::sqrt(12.0 * material.modulus / material.density) / bar.mesh().smallest();
    return bar.has_massless() || material.viscosity * highest >= 2.0 * material.modulus;
  }

  void create(Memory& memory, int formulas, double t) {
    memory.reset(CVodeCreate(formulas, context_.get()));
    if (!memory) throw std::bad_alloc();
    memory_ = memory.get();
    const int begun = CVodeInit(memory_, right_hand_side, t, state_.get());
    // It has freed its vectors then, and CVodeFree would do so again.
    if (begun == CV_MEM_FAIL) std::ignore = memory.release(), throw std::bad_alloc();
    check("CVodeInit", begun);
    VISCOBAR_KEEP_MESSAGES(CVode, memory_, context_, leg_.library_message);
    check("CVodeSetUserData", CVodeSetUserData(memory_, this));
    check("CVodeWFtolerances", CVodeWFtolerances(memory_, error_weights));
    check("CVodeSetNonlinearSolver", CVodeSetNonlinearSolver(memory_, solver_.get()));
    if (leg_.system.load_varies())
      check("CVodeSetMaxStep", CVodeSetMaxStep(memory_, longest_step(leg_.system, end_ - t)));
    // The formulas of order 3 to 5 are unstable near the imaginary axis, where a lightly damped contact spring is.
    if (formulas == CV_BDF) check("CVodeSetStabLimDet", CVodeSetStabLimDet(memory_, SUNTRUE));
  }

  void check(const char* call, int flag) {
    require_memory();
    if (flag != CV_SUCCESS) fail(leg_, call, flag, flag_name(CVodeGetReturnFlagName(flag)), cvode_flags());
  }

  // Needed at the start of a leg only: the steps use the momentum rows themselves.
  static int right_hand_side(double t, N_Vector y, N_Vector rate, void* user) noexcept {
    Leg& leg = static_cast<CvodeStepper*>(user)->leg_;
    return guarded(leg, [&] {
      const Layout& layout = leg.layout;
      const std::span<double> state = values(y), out = values(rate);
      const std::span<double> w = layout.u(out);  // the rate of u
      std::ranges::copy(layout.w(state), w.begin());
      leg.system.complete_velocity(t, layout.u(state), w);
      leg.system.force(t, layout.u(state), w, layout.w(out));
      leg.system.accelerate(layout.w(out));
      leg.account_rates(t, w, layout.w(out), out);
      ++leg.statistics.rhs_evaluations;
    });
  }

  static int error_weights(N_Vector y, N_Vector weights, void* user) noexcept {
    auto* stepper = static_cast<CvodeStepper*>(user);
    stepper->weights_.fill(values(y), values(weights));
    return 0;
  }

  Context context_;
  Leg leg_;
  ErrorWeights weights_;
  Formulas formulas_;
  RestWatch rest_;
  RestWatch::Advice advice_ = RestWatch::Advice::go_on;
  double end_, stop_ = 0.0, t_ = 0.0;  // of the run, of the leg, and now
  Vector state_, interpolated_;
  std::optional<Probed> probed_;
  Vector probe_;
  NonlinearSolver solver_;
  Memory adams_, bdf_;      // made when first needed
  void* memory_ = nullptr;  // the one at work
};

}  // namespace

Statistics integrate(const BarSystem& system, const StartingPoint& start, std::span<const double> times,
                     const Cvode& method, const Observers& observers) {
  if (system.has_massless() && !system.damped())
    throw std::invalid_argument(
        "cvode cannot take massless contact nodes without viscosity: their equations are algebraic; use ida");
  return run_in_parts(start, observers, [&](const StartingPoint& from) {
    PenalisedSystem penalised(system, method.penalty);
    const Layout layout(penalised, observers.energy);
    Statistics statistics = statistics_before(from);
    CvodeStepper stepper(penalised, layout, method, times.back(), statistics);
    return run_stepwise("cvode", penalised, layout, stepper, statistics, from, times, observers);
  });
}

}  // namespace viscobar

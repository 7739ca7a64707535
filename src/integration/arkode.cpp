#include <algorithm>
#include <memory>
#include <span>
#include <tuple>

#include "integration/step_polynomial.hpp"
#include "integration/stepwise_run.hpp"
#include "integration/sundials/leg.hpp"
#include "viscobar/integration/integrate.hpp"

namespace viscobar {

namespace {

using namespace sundials;

struct ArkodeStage {
  double t = 0.0, gamma = 0.0;
  N_Vector predicted = nullptr, current = nullptr, rate = nullptr, known = nullptr;
};

// The stage at work, or the last one of the step made.
ArkodeStage stage(const Leg& leg) {
  ArkodeStage now;
  void* user = nullptr;
  ARKodeGetNonlinearSystemData(leg.memory, &now.t, &now.predicted, &now.current, &now.rate, &now.gamma, &now.known,
                               &user);
  return now;
}

// A stage of ARKODE asks for x with  x = gamma f(t, y_pred + x) + z,  z what is known from the stages before.
void solve_stage(Leg& leg, std::span<double> correction) {
  const ArkodeStage now = stage(leg);
  leg.solve_first_order(now.t, now.gamma, values(now.predicted), 1.0, values(now.known), correction);
}

// Steps of ARKODE's ESDIRK547L2SA2 on the legs of a run.
//
// The mass matrix is never given to the library, yet it is inverted once a leg only, for the rate at its beginning:
// the rates of the stages follow from their own equations, f = (x - z) / gamma, and the last stage of a stiffly
// accurate method is the new state.
class ArkodeStepper final : public PolynomialStepper {
 public:
  ArkodeStepper(const StepperParts& parts, const Tolerance& tolerance)
      : PolynomialStepper(parts, tolerance),
        leg_(parts.system, motion_, parts.statistics, parts.derivatives, solve_stage),
        outer_(parts.layout),
        end_(parts.times.back()),
        state_(make_vector(leg_.layout.size, context_)),
        rate_(make_vector(leg_.layout.size, context_)),
        solver_(make_step_solver(leg_, context_)) {}

  void restart(double t, double stop, std::span<const double> y) override {
    stop_ = stop;
    weights_.tighten(leg_.statistics.events);
    copy_motion(y, outer_, values(state_), motion_);
    step_.end().t = t;
    std::ranges::copy(y, step_.end().y.begin());
    leg_.right_hand_side(t, values(state_), values(rate_));
    keep_rates();
    step_.restart();
    // A reset keeps the step of the leg before, which chatter makes right more often than a first step found anew.
    if (memory_)
      check("ARKodeReset", ARKodeReset(memory_.get(), t, state_.get()));
    else
      create(t);
    if (const double step = resolving(stop - t); step < stop - t)
      check("ARKodeSetInitStep", ARKodeSetInitStep(memory_.get(), step));
    check("ARKodeSetStopTime", ARKodeSetStopTime(memory_.get(), stop_));
  }

  double advance() override {
    double t = 0.0;
    const int flag = ARKodeEvolve(memory_.get(), stop_, state_.get(), &t, ARK_ONE_STEP);
    // It has freed what interpolates then, and ARKodeFree would do so again.
    if (flag == ARK_MEM_FAIL) std::ignore = memory_.release(), throw std::bad_alloc();
    require_memory();
    if (flag < 0) fail(leg_, "ARKodeEvolve", flag, flag_name(ARKodeGetReturnFlagName(flag)), Library::arkode);
    step_.advance();
    step_.end().t = t;
    copy_motion(values(state_), motion_, step_.end().y, outer_);
    std::ranges::copy(values(stage(leg_).rate), values(rate_).begin());
    keep_rates();
    double length = 0.0;
    check("ARKodeGetLastStep", ARKodeGetLastStep(memory_.get(), &length));
    step_.tolerate(weights_.displacement_tolerance());
    // The last stage is the new state, and its correction leads there from the old one.
    step_.finish(length, leg_.correction.first(leg_.layout.nodes));
    return t;
  }

 private:
  // All but the energy account, which one of the two has not.
  static void copy_motion(std::span<const double> from, const Layout& as, std::span<double> to, const Layout& become) {
    std::ranges::copy(from.first(2 * as.nodes), to.begin());
    std::ranges::copy(from.subspan(as.first_derivative), to.subspan(become.first_derivative).begin());
  }

  void keep_rates() {
    const std::span<double> rates = values(rate_);
    std::ranges::copy(motion_.w(rates), step_.end().a.begin());
    std::ranges::copy(rates.subspan(motion_.first_derivative), step_.end().derivative_rates.begin());
  }

  void create(double t) {
    memory_.reset(ARKStepCreate(nullptr, right_hand_side, t, state_.get(), context_.get()));
    require_memory();
    if (!memory_) throw std::bad_alloc();
    void* memory = leg_.memory = memory_.get();
    VISCOBAR_KEEP_MESSAGES(ARKStep, memory, context_, leg_.library_message);
    check("ARKodeSetUserData", ARKodeSetUserData(memory, this));
    check("ARKodeWFtolerances", ARKodeWFtolerances(memory, error_weights));
    check("ARKStepSetTableNum", ARKStepSetTableNum(memory, ARKODE_ESDIRK547L2SA2_7_4_5, ARKODE_ERK_NONE));
    check("ARKodeSetNonlinearSolver", ARKodeSetNonlinearSolver(memory, solver_.get()));
    check("ARKodeSetPredictorMethod", ARKodeSetPredictorMethod(memory, 0));  // the state that the step begins with
    check("ARKodeSetDeduceImplicitRhs", ARKodeSetDeduceImplicitRhs(memory, SUNTRUE));
    if (leg_.system.load().varies())
      check("ARKodeSetMaxStep", ARKodeSetMaxStep(memory, longest_step(leg_.system, end_ - t)));
    // The step is interpolated by StepPolynomial; the least that the library can be asked to keep for its own.
    check("ARKodeSetInterpolantType", ARKodeSetInterpolantType(memory, ARK_INTERP_LAGRANGE));
    check("ARKodeSetInterpolantDegree", ARKodeSetInterpolantDegree(memory, 0));
    // Between two changes the steps are of one size; a controller that looks at the last error alone makes fewer.
    check("StepControl", control_.give_to(memory, context_));
    // The step of the leg before may be far too long for a stiff contact.
    check("ARKodeSetMaxErrTestFails", ARKodeSetMaxErrTestFails(memory, 50));
  }

  void check(const char* call, int flag) {
    require_memory();
    if (flag != ARK_SUCCESS) fail(leg_, call, flag, flag_name(ARKodeGetReturnFlagName(flag)), Library::arkode);
  }

  // Asked for at the beginning of each step, where it is known, and once to find the first step.
  static int right_hand_side(double t, N_Vector y, N_Vector rate, void* user) noexcept {
    ArkodeStepper& self = *static_cast<ArkodeStepper*>(user);
    return guarded(self.leg_, [&] {
      if (t == self.step_.end().t)
        std::ranges::copy(values(self.rate_), values(rate).begin());
      else
        self.leg_.right_hand_side(t, values(y), values(rate));
    });
  }

  static int error_weights(N_Vector y, N_Vector weights, void* user) noexcept {
    auto* stepper = static_cast<ArkodeStepper*>(user);
    stepper->weights_.fill(values(y), values(weights));
    return 0;
  }

  Context context_;
  Leg leg_;
  const Layout outer_;       // with the energy account
  double end_, stop_ = 0.0;  // of the run, and of the leg
  Vector state_, rate_;      // at the end of the last step
  NonlinearSolver solver_;
  StepControl control_;
  Memory<ARKodeFree> memory_;
};

}  // namespace

Statistics integrate(const BarSystem& system, const StartingPoint& start, std::span<const double> times,
                     const Arkode& method, const Observers& observers) {
  return run_stepwise("arkode", system, method.penalty, start, times, observers, [&](const StepperParts& parts) {
    return std::make_unique<ArkodeStepper>(parts, method.tolerance);
  });
}

}  // namespace viscobar

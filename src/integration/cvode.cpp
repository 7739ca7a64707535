#include <cvode/cvode.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <tuple>

#include "integration/stepwise_run.hpp"
#include "integration/sundials/multistep.hpp"
#include "run/parts.hpp"
#include "viscobar/integration/integrate.hpp"

namespace viscobar {

namespace {

using namespace sundials;

const MultistepLibrary library{"CVode",
                               CVodeGetDky,
                               CVodeGetLastOrder,
                               CVodeGetCurrentTime,
                               CVodeGetLastStep,
                               CVodeSetMaxOrd,
                               CVodeSetStopTime,
                               CVodeSetMaxStep,
                               CVodeSetUserData,
                               CVodeWFtolerances,
                               CVodeSetNonlinearSolver,
                               CVodeGetReturnFlagName,
                               Library::cvode,
                               false};

// The corrector of CVODE asks for x with  x = gamma f(t, y_pred + x) - rl1 z,  z the scaled rate of the predictor.
void solve_step(Leg& leg, std::span<double> correction) {
  double t = 0.0, gamma = 0.0, rl1 = 0.0;
  N_Vector predicted = nullptr, current = nullptr, rate = nullptr, scaled_rate = nullptr;
  void* user = nullptr;
  CVodeGetNonlinearSystemData(leg.memory, &t, &predicted, &current, &rate, &gamma, &rl1, &scaled_rate, &user);
  leg.solve_first_order(t, gamma, values(predicted), -rl1, values(scaled_rate), correction);
}

class CvodeStepper final : public Multistep {
 public:
  CvodeStepper(const StepperParts& parts, const Cvode& method)
      : Multistep(library, parts, method.tolerance, solve_step, method.formulas == Formulas::automatic),
        formulas_(method.formulas),
        shortness_(15.0 * std::pow(method.tolerance.relative, -1.0 / 6.0)) {}

 private:
  using Memory = sundials::Memory<CVodeFree>;

  static constexpr int highest_adams = 12;

  void begin_leg(double t) override { stiff() ? begin_bdf(highest_bdf, t) : begin(adams_, CV_ADAMS, highest_adams, t); }
  void begin_bdf(int order, double t) override { begin(bdf_, CV_BDF, order, t); }
  std::pair<const char*, int> step() override {
    return {"", CVode(leg_.memory, stop_, state_.get(), &t_, CV_ONE_STEP)};
  }

  void begin(Memory& memory, int formulas, int order, double t) {
    leg_.memory = memory.get();
    if (memory)
      check("ReInit", CVodeReInit(memory.get(), t, state_.get()));
    else
      create(memory, formulas, t);
    begin_stretch(memory.get(), order);
  }

  // Adams' formulas, of order up to 12, where every motion is an oscillation that has to be resolved anyway; backward
  // differentiation where something fast dies out: a massless node, or modes of the mesh that are overdamped (eta omega
  // >= 2 E at the highest, omega = sqrt(12 E / rho) / h). Adams' formulas are stable for steps of some times that in
  // which the fastest mode dies out. Backward differentiation of order 5 makes steps of some tol^(1/6) of what it
  // resolves, the waves and the springs of closed contacts: where these are no longer, Adams' formulas make fewer.
  bool stiff() const {
    if (formulas_ != Formulas::automatic) return formulas_ == Formulas::bdf;
    const BarSystem& bar = leg_.system.bar();
    const Bar& material = bar.bar();
    const double highest = std::sqrt(12.0 * material.modulus / material.density) / bar.elements().finest();
    if (bar.inertia().has_massless()) return true;
    if (material.viscosity * highest < 2.0 * material.modulus) return false;
    const Contacts& contacts = leg_.system.contacts();
    double slow_enough = shortness_ * bar.bar().wave_speed() / material.length;
    for (std::size_t i = 0; i < contacts.size(); ++i) {
      if (!contacts.closed(i)) continue;
      if (contacts[i].law.bent() || contacts[i].law.linear().damping > 0.0) return true;  // its spring does not swing
      slow_enough = std::max(slow_enough, std::min(shortness_ / 650.0, 0.6) * contacts[i].rate);
    }
    return fastest_decay(bar) > slow_enough;
  }

  // The rate at which neighbours die out that move to and fro: 4 eta / (rho h^2) with a lumped mass, three times that
  // with the consistent one, in whose rows these weigh less.
  static double fastest_decay(const BarSystem& bar) {
    const BandedMatrix& inertia = bar.inertia().matrix();
    const std::size_t middle = bar.size() / 2;
    const double own = inertia.diagonal[middle], h = bar.elements().finest();
    const double beside = middle < inertia.off_diagonal.size() ? 2.0 * inertia.off_diagonal[middle] : 0.0;
    return 4.0 * bar.bar().viscosity / (bar.bar().density * h * h) * (own + beside) / (own - beside);
  }

  void create(Memory& memory, int formulas, double t) {
    memory.reset(CVodeCreate(formulas, context_.get()));
    if (!memory) throw std::bad_alloc();
    const int begun = CVodeInit(memory.get(), right_hand_side, t, state_.get());
    // It has freed its vectors then, and CVodeFree would do so again.
    if (begun == CV_MEM_FAIL) std::ignore = memory.release(), throw std::bad_alloc();
    check("Init", begun);
    VISCOBAR_KEEP_MESSAGES(CVode, memory.get(), context_, leg_.library_message);
    configure(memory.get(), t);
    // The formulas of order 3 to 5 are unstable near the imaginary axis, where a lightly damped contact spring is.
    if (formulas == CV_BDF) check("SetStabLimDet", CVodeSetStabLimDet(memory.get(), SUNTRUE));
  }

  // Needed at the start of a leg only: the steps use the momentum rows themselves.
  static int right_hand_side(double t, N_Vector y, N_Vector rate, void* user) noexcept {
    Leg& leg = static_cast<CvodeStepper*>(static_cast<Multistep*>(user))->leg_;
    return guarded(leg, [&] { leg.right_hand_side(t, values(y), values(rate)); });
  }

  Formulas formulas_;
  double shortness_;    // of steps of order 5; by what was measured, and so is the share of the contacts
  Memory adams_, bdf_;  // made when first needed
};

}  // namespace

Statistics integrate(const BarSystem& system, const StartingPoint& start, std::span<const double> times,
                     const Cvode& method, const Observers& observers) {
  if (system.inertia().has_massless() && !system.bar().damped()) throw Unfit("cvode", algebraic_rows("cvode"));
  return run_stepwise("cvode", system, method.penalty, start, times, observers,
                      [&](const StepperParts& parts) { return std::make_unique<CvodeStepper>(parts, method); });
}

}  // namespace viscobar

#include <fmt/format.h>

#include <algorithm>

#include "integration/odeint/explicit_formulas.hpp"
#include "run/parts.hpp"
#include "viscobar/integration/integrate.hpp"

namespace viscobar {

std::string_view name(Stepper stepper) {
  constexpr std::string_view names[] = {"automatic", "rosenbrock4", "dopri5"};
  return names[static_cast<std::size_t>(stepper)];
}

namespace {

constexpr double most_steps = 1e9;

// Steps of dopri5 a transit time from which on rosenbrock4 is cheaper at a tolerance of 1e-6: its steps cost 1.7 times
// as much, and their number goes by the fourth root of the tolerance (tests/measurements/odeint_steppers.py).
constexpr double implicit_worth = 150.0;

// |R(z)| of dopri5 stays below 1 on the negative real axis up to here.
constexpr double real_stability = 3.3;

// On the imaginary axis up to 1, where its error estimate is 8e-4 of what a mode has: one that grows there is seen at a
// thousand tolerances. Modes that viscosity damps by a hundredth of their rate do not grow up to 1.9, where the
// estimate is a fiftieth.
constexpr double imaginary_stability = 0.95, damped = 0.01;

struct Spectrum {
  double frequency;   // of undamped motion, all contacts closed
  double open;        // the same, all open, as near as known: end rows couple less than the consistent mass
  double decay;       // of what only dies out
  double decay_open;  // the same, all contacts open
};

// Bounds: the largest eigenvalue of K against M element by element, plus what a contact adds to its node.
Spectrum spectrum(const BarSystem& system, const Penalty& penalty) {
  const Bar& bar = system.bar();
  const double h = system.elements().finest();
  const bool diagonal = system.inertia().matrix().off_diagonal.empty();
  const double mesh = (diagonal ? 4.0 : 12.0) / (h * h * bar.density);
  double square = mesh * bar.modulus, decay = mesh * bar.viscosity;
  if (system.side()) {
    square += system.side()->largest_stiffness() / bar.density;
    decay += system.side()->largest_drag() / bar.density;
  }
  const std::vector<double> masses = system.inertia().effective_masses();
  double contact_square = 0.0, contact_decay = 0.0, support_square = 0.0, support_decay = 0.0;
  for (const Contact& contact : system.contacts()) {
    const auto& stop = system.stop(contact);
    const PenaltyLaw law = stop ? (stop->linear() ? PenaltyLaw{stop->stiffness, stop->damping} : PenaltyLaw{})
                                : penalty_law(penalty, contact.weight,
                                              penalty.restitution < 1.0 ? system.inertia().contact_mass(contact) : 0.0);
    double mass = contact.joint > 0 ? system.inertia().contact_mass(contact) : masses[contact.unknown];
    if (mass == 0.0) {
      if (bar.viscosity > 0.0)
        decay = std::max(
            decay, (bar.modulus + law.stiffness * system.elements().stretch_beside(contact.unknown)) / bar.viscosity);
      continue;
    }
    if (contact.where == Where::span && !diagonal) mass = bar.density * contact.weight / 3.0;
    contact_square = std::max(contact_square, law.stiffness / mass);
    contact_decay = std::max(contact_decay, law.damping / mass);
  }
  for (const Support& support : system.supports()) {
    support_square = std::max(support_square, support.stiffness / masses[support.unknown]);
    support_decay = std::max(support_decay, support.dashpot / masses[support.unknown]);
  }
  if (system.inertia().has_massless() && bar.viscosity > 0.0) decay = std::max(decay, bar.modulus / bar.viscosity);
  const double open = system.inertia().matrix().one_sided.empty() ? square : square * (8.0 / 12.0);
  return {std::sqrt(square + std::max(contact_square, support_square)), std::sqrt(open + support_square),
          decay + std::max(contact_decay, support_decay), decay + support_decay};
}

}  // namespace

OdeintPlan plan(const BarSystem& system, double duration, const Odeint& method) {
  OdeintPlan plan;
  plan.stepper = method.stepper;
  const Spectrum bound = spectrum(system, method.penalty);
  const double explicit_steps = duration * bound.decay / real_stability;
  // Whose Jacobian is not constant.
  const auto bent = std::ranges::find_if(system.contacts(), [&](const Contact& contact) {
    return system.stop(contact) && !system.stop(contact)->linear();
  });
  if (bent != system.contacts().end()) {
    if (method.stepper == Stepper::rosenbrock4)
      plan.refusal =
          Finding{"method.stepper", fmt::format("rosenbrock4 wants a Jacobian that is constant between contact "
                                                "changes, and a contact by {} has none; use dopri5",
                                                name(system.stop(*bent)->law))};
    plan.stepper = Stepper::dopri5;
  }
  if (plan.stepper == Stepper::automatic) {
    // At its bound of stability dopri5 leaves a node without mass a velocity that no tolerance bounds.
    const double transits = duration / (system.bar().length * system.bar().slowness());
    const double worth = implicit_worth * transits * std::pow(1e-6 / method.tolerance.relative, 0.25);
    // A contact asks for short steps while it is closed alone. Where anything damps the bar it may rest in it.
    const bool losing = system.bar().damped() || method.penalty.restitution < 1.0;
    const bool rests = losing && duration * bound.frequency > 100.0 * worth;
    const bool stiff = system.inertia().has_massless() || duration * bound.decay_open / real_stability > worth || rests;
    plan.stepper = stiff ? Stepper::rosenbrock4 : Stepper::dopri5;
  }
  if (plan.refusal) return plan;
  if (system.inertia().has_massless() && !system.bar().damped()) {
    plan.refusal = algebraic_rows("odeint");
  } else if (plan.stepper == Stepper::dopri5) {
    plan.least_steps = explicit_steps;
    if (bound.open * system.bar().viscosity < 2.0 * damped * system.bar().modulus)
      plan.longest_step = imaginary_stability / bound.open;
  }
  if (!plan.refusal && plan.least_steps > most_steps)
    plan.refusal = Finding{"method.name",
                           fmt::format("{} would make at least {:.1e} steps: it is explicit, and the scene is stiff; "
                                       "use cvode or arkode",
                                       name(plan.stepper), plan.least_steps)};
  return plan;
}

}  // namespace viscobar

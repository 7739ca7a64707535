#include "viscobar/analysis/cost_estimate.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "viscobar/analysis/regime.hpp"

namespace viscobar {

namespace {

// Seconds, measured by tests/measurements/sweep.cpp.
constexpr double start = 3e-4;  // reading, building the system
struct StepCost {
  double step, node;
};

StepCost step_cost(MethodName method) {
  switch (method) {
    case MethodName::ida: return {3e-6, 60e-9};
    case MethodName::fully_discrete:
    case MethodName::finite_difference: return {1e-7, 6e-9};
    default: return {1e-6, 22e-9};
  }
}

// Steps of an adaptive method in a unit of time: what moves and survives, resolved to the tolerance.
double flight_rate(const Case& run) {
  const Bar& bar = run.scene.bar;
  double rate = std::sqrt(bar.modulus / bar.density) / run.mesh().spacing();
  if (bar.viscosity > 0.0) rate = std::min(rate, bar.modulus / bar.viscosity);
  return rate;
}

// A contact adds a few new starts, a chattering one a start for each bounce.
double contact_steps(const Case& run, const BarSystem& system) {
  constexpr double steps_a_start = 30.0, quiet_contacts = 4.0, bounces_a_contact = 0.1;
  double steps = 0.0;
  for (const ContactRegime& contact : contact_regimes(run, system)) {
    double starts = quiet_contacts;
    if (contact.chatters && contact.effective_mass > 0.0)
      starts += bounces_a_contact * run.end / (std::numbers::pi * std::sqrt(contact.effective_mass * *run.epsilon));
    steps += starts * steps_a_start;
  }
  return steps;
}

}  // namespace

double estimated_seconds(const Case& run) {
  const auto nodes = static_cast<double>(run.mesh().nodes());
  const StepCost cost = step_cost(run.method);
  if (is_scheme(run.method)) {
    const double searches = run.scene.span ? 3.0 : 1.0;
    return start + run.end / *run.step * (cost.step + searches * cost.node * nodes);
  }
  const BarSystem system = make_system(run);
  if (run.method == MethodName::exponential) {
    const double cubic = 1e-8 * nodes * nodes * nodes, sub_steps = 10.0 * run.end * flight_rate(run);
    return start + cubic + sub_steps * 4e-9 * nodes * nodes;
  }
  const double growth = std::pow(run.tolerance.relative / 1e-6, -1.0 / 6.0);
  const double steps = 50.0 + run.end * flight_rate(run) * growth * 5.0 + contact_steps(run, system) * growth;
  return start + steps * (cost.step + cost.node * nodes);
}

}  // namespace viscobar

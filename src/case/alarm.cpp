#include "case/alarm.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "case/method_table.hpp"

namespace viscobar {

namespace {

// Sound openings stay at 0.4, the delay of a critically damped spring, and below 5 where an impact is passed over.
constexpr double late_opening_limit = 10.0;

// A balance that is off by more of the energy deserves a word, however loose the tolerances are.
constexpr double balance_limit = 0.05;

bool is_exact(const Case& run) { return method_row(run.method).accuracy == Accuracy::rounding; }

double promised_balance(const Case& run, const BarSystem& system, double energy, double steps) {
  const Bar& bar = run.scene.bar;
  const double momentum = std::sqrt(2.0 * energy * bar.density * bar.length);
  // An error du of the nodes is a strain of up to 2 du / h.
  const double force = 2.0 * static_cast<double>(run.elements) * std::sqrt(2.0 * energy * bar.modulus / bar.length);
  if (is_exact(run) || is_scheme(run.method)) {
    const State start = system.initial_state();
    double far = run.end * momentum / (bar.density * bar.length);
    for (const double u : start.u) far = std::max(far, std::abs(u));
    return 1e-9 * energy + std::sqrt(steps) * std::numeric_limits<double>::epsilon() * far * force;
  }
  const Allowance absolute = allowance(run.tolerance, system, run.end);
  return 200.0 * (run.tolerance.relative * energy + absolute.velocity * momentum + absolute.displacement * force);
}

// Strains by a rounding of the displacements have it: a bar at rest has no other.
double energy_of_rounding(const Bar& bar, const BarSystem& system) {
  double far = 0.0;
  for (const double u : system.initial_state().u) far = std::max(far, std::abs(u));
  const double rounding = std::numeric_limits<double>::epsilon() * far;
  return 0.5 * bar.modulus / bar.length * static_cast<double>(system.mesh().elements) * rounding * rounding;
}

}  // namespace

std::optional<std::string> overflow(const Statistics& statistics) {
  const auto& energy = statistics.energy;
  if (!energy || std::isfinite(energy->initial + energy->final + energy->work + energy->dissipated))
    return std::nullopt;
  return "the energy of the bar is no longer a number: the data, or the motion, are too large for the squares of double "
         "precision; choose units in which displacements and stresses are nearer to 1";
}

std::vector<Alarm> alarms(const Setup& setup, const BarSystem& system, const Statistics& statistics) {
  const Case& run = setup.run;
  std::vector<Alarm> all;
  if (!statistics.completed) return all;
  const bool scheme = is_scheme(run.method);
  if (statistics.energy && (scheme || is_exact(run) || is_adaptive(run.method))) {
    const EnergyAccount& energy = *statistics.energy;
    const double off = std::abs(energy.balance_error());
    // An account that is off has made the energies on the way larger by no more than that.
    double largest = std::max({energy.initial, std::abs(energy.work),
                               std::max({energy.final, std::abs(energy.dissipated), energy.largest}) - off});
    if (const auto& waves = statistics.representation)
      largest = std::max(largest, run.scene.bar.density * run.scene.bar.length * waves->velocity * waves->velocity);
    largest = std::max(largest, energy_of_rounding(run.scene.bar, system));
    const double sound = promised_balance(run, system, largest, static_cast<double>(statistics.steps));
    if (!(off <= std::min(sound, balance_limit * largest)))
      all.push_back(
          {fmt::format("the energy balance is off by {:.2g}, where the tolerances promise {:.2g} and the largest "
                       "energy on the way is {:.2g}",
                       energy.balance_error(), sound, largest),
           !(off <= std::max(sound, 0.01 * largest))});
    if (const double taken = energy.dissipated - energy.end_inertia; !scheme && taken < -sound)
      all.push_back({fmt::format("energy grew without a cause: the dissipated energy is {:.2g}", taken),
                     taken < -0.01 * largest});
    // Nothing gives energy to a bar that nothing works on, whatever is lost again; beside that size all the above is
    // small.
    const bool rebounds = scheme && run.restitution.value_or(0.0) > 0.0;
    const bool moved = run.scene.left_input.motion || run.scene.right_input.motion;
    if (energy.work == 0.0 && !moved && !rebounds && energy.largest > 4.0 * energy.initial &&
        energy.largest > promised_balance(run, system, energy.initial, static_cast<double>(statistics.steps)))
      all.push_back({fmt::format("energy grew without a cause: from {:.2g} at the start to {:.2g} on the way",
                                 energy.initial, energy.largest),
                     true});
    if (energy.work == 0.0 && is_penalised(run.method) && !system.contacts().empty() && !has_stops(run.scene)) {
      const double softest = std::ranges::min(system.contacts(), {}, &Contact::weight).weight / setup.epsilon;
      const double deepest = std::sqrt(2.0 * (energy.initial + std::abs(energy.end_inertia) + sound) / softest);
      if (statistics.max_penetration > deepest)
        all.push_back(
            {fmt::format("a penetration of {:.3g} is deeper than the energy of the bar can press the spring, {:.3g}",
                         statistics.max_penetration, deepest),
             true});
    }
  }
  if (const LateOpening& late = statistics.late_opening; late.ratio > late_opening_limit)
    all.push_back(
        {fmt::format("the contact that opens at t = {:.9g} still pulls then, {:.2g} times as much as the tolerances "
                     "explain",
                     late.time, late.ratio),
         late.ratio > 10.0 * late_opening_limit});
  return all;
}

}  // namespace viscobar

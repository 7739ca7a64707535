#include "record/run_outcome.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <new>

#include "case/alarm.hpp"
#include "case/regime.hpp"
#include "dynamics/natural_scales.hpp"

namespace viscobar {

namespace {

/// Warns that the impacts of a scheme gave energy: how much, when, and the remedies; none if it can be rounding.
std::optional<std::string> growth_warning(const Case& run, const Statistics& done) {
  const EnergyAccount& energy = *done.energy;
  const double scale = energy.initial + energy.final + std::abs(energy.work) + std::abs(energy.dissipated);
  const double rounding = 100.0 * std::numeric_limits<double>::epsilon() * static_cast<double>(done.steps) * scale;
  if (energy.growth <= rounding) return std::nullopt;
  return fmt::format(
      "energy: up to t = {1:.6g} impacts gave the bar {0:.3g}, although an obstacle at rest does no work; "
      "the bar had {2:.3g} at the start. With contact.restitution = {3} an impact of this scheme may give energy; "
      "remedies: a smaller method.step, or method.impact = \"moreau\", which never gives energy",
      energy.growth, energy.growth_time, energy.initial, run.restitution.value_or(0.0));
}

/// Warns of data that polynomial pieces approximate badly: their error, and a remedy.
std::optional<std::string> representation_warning(const Statistics& done) {
  constexpr double roundings = 1e4;
  if (!done.representation || done.representation->error <= roundings * done.representation->rounding)
    return std::nullopt;
  return fmt::format(
      "initial data or load are represented to {:.2g} only, as a displacement at the end, where roundings make {:.2g}: "
      "no polynomial pieces follow them closer; what helps: formulas without roots of zero or endless wiggles",
      done.representation->error, done.representation->rounding);
}

/// Warns of a bar that has gone through an obstacle: how deep, and the epsilon to take.
std::optional<std::string> penetration_warning(const Setup& setup, const BarSystem& system, const Statistics& done) {
  const Case& run = setup.run;
  if (!is_penalised(run.method) || !done.account || has_stops(run.scene)) return std::nullopt;
  double largest = 0.0;
  for (const EndAccount* end : {&done.account->left, &done.account->right})
    largest = std::max({largest, std::abs(end->lowest), std::abs(end->highest)});
  // Between the ends the account has no displacements.
  if (run.scene.span) largest = std::max({largest, run.scene.span->gap, natural_scales(system, run.end).displacement});
  if (!is_no_obstacle(done.max_penetration, largest)) return std::nullopt;
  return fmt::format(
      "penetration: the bar went {:.3g} deep into an obstacle, beside displacements of {:.3g}: that is a spring rather "
      "than an obstacle; {}",
      done.max_penetration, largest, stiffer_advice(setup));
}

/// Warns of a peak reaction without a limit. A viscous bar is left out: each of its impacts has such a peak, and the
/// text and the page say so.
std::optional<std::string> peak_warning(const Setup& setup, const BarSystem& system, const Statistics& done) {
  if (setup.run.scene.bar.viscosity > 0.0 || !done.account) return std::nullopt;
  std::size_t closings = done.account->left.closings + done.account->right.closings;
  for (const ContactAccount& joint : done.account->joints) closings += joint.closings;
  if (closings == 0) return std::nullopt;
  const auto why = peak_remark(setup, system);
  return why ? std::optional("peak reaction: " + *why) : std::nullopt;
}

/// Warns of impacts without a contact: the bar pulls its node away at once, which is an error of the mesh. Those of a
/// fine mesh take next to nothing of its momentum.
std::optional<std::string> touch_warning(const Scene& scene, const BarSystem& system, const Statistics& done) {
  if (!done.account || !done.energy || scene.span) return std::nullopt;  // a span obstacle has closings of its own
  const std::vector<double> ones(system.size(), 1.0);
  const double momentum = std::sqrt(2.0 * done.energy->largest * system.inertia().matrix().quadratic_form(ones));
  for (const auto& [end, there, words] : {std::tuple{&done.account->left, is_obstacle(scene.left), "left"},
                                          {&done.account->right, is_obstacle(scene.right), "right"}})
    if (there && end->closings == 0 && std::abs(end->impulse) > 0.01 * momentum)
      return fmt::format(
          "touches: the {} end strikes its obstacle and is pulled away at once, which is an error of the mesh: its "
          "impulse of {:.3g} is of no contact; take more elements",
          words, end->impulse);
  return std::nullopt;
}

/// Warns of sensitivities that end before the run: when, and why.
std::optional<std::string> sensitivity_warning(const Statistics& done) {
  if (!done.sensitivity || !done.sensitivity->lost) return std::nullopt;
  return fmt::format("sensitivities: there are none from t = {:.9g} on: {}", *done.sensitivity->lost,
                     done.sensitivity->why);
}

/// How many contact changes have no derivative of their time, though what follows has.
std::optional<std::string> graze_warning(const Outcome& outcome, const Statistics& done) {
  const std::size_t grazes = std::ranges::count_if(outcome.changes, [](const std::vector<ChangeSensitivity>& change) {
    return std::ranges::any_of(change, [](const ChangeSensitivity& s) { return std::isnan(s.time); });
  });
  if (grazes == 0 || (done.sensitivity && done.sensitivity->lost)) return std::nullopt;
  return fmt::format(
      "sensitivities: {} of {} contact changes are grazes, whose times have no derivatives (null in contact_times)",
      grazes, outcome.changes.size());
}

}  // namespace

void fail(Outcome& outcome, Ending ending, const std::string& error) {
  if (outcome.ending != Ending::completed) return;
  outcome.ending = ending;
  outcome.error = error;
}

void simulate_into(Outcome& outcome, const Setup& setup, const BarSystem& system, const std::optional<Checkpoint>& from,
                   const Observers& observers, std::span<const double> times) {
  try {
    outcome.statistics = from            ? simulate(setup, system, *from, observers)
                         : times.empty() ? simulate(setup, system, observers)
                                         : simulate(setup, system, times, observers);
    if (!outcome.statistics->completed) {
      fail(outcome, Ending::interrupted, "interrupted");
      outcome.statistics->energy.reset();  // whose final one is not known
    }
  } catch (const IntegrationError& error) {
    outcome.statistics = error.statistics;
    fail(outcome, Ending::failed, error.what());
  } catch (const std::invalid_argument& error) {
    fail(outcome, Ending::refused, error.what());
  } catch (const std::bad_alloc&) {
    fail(outcome, Ending::failed, "there is not enough memory");
  } catch (const std::exception& error) {
    fail(outcome, Ending::failed, error.what());
  }
  if (!outcome.statistics) return;
  outcome.reached_time = outcome.statistics->reached_time;
  outcome.steps = outcome.statistics->steps;
  outcome.events = outcome.statistics->events;
}

void judge(Outcome& outcome, const Setup& setup, const BarSystem& system,
           const std::function<void(const std::string& warning)>& warn) {
  if (!outcome.statistics) return;
  const Statistics& done = *outcome.statistics;
  const auto pass_on = [&](const std::optional<std::string>& warning) {
    if (warning) warn(*warning);
  };
  pass_on(strain_remark(setup, system));
  pass_on(jump_remark(setup, system));
  pass_on(sensitivity_warning(done));
  pass_on(graze_warning(outcome, done));
  if (!done.energy) return;
  if (const auto problem = overflow(done)) return fail(outcome, Ending::failed, *problem);
  pass_on(growth_warning(setup.run, done));
  pass_on(representation_warning(done));
  pass_on(penetration_warning(setup, system, done));
  pass_on(touch_warning(setup.run.scene, system, done));
  pass_on(peak_warning(setup, system, done));
  for (const Alarm& alarm : alarms(setup, system, done)) {
    const std::string what = fmt::format(
        "{}; take another method.name or a smaller method.relative_tolerance, and where it is more than the tolerances "
        "promise, report it as an error of viscobar, with the scene",
        alarm.what);
    alarm.ruinous ? fail(outcome, Ending::failed, what) : warn(what);
  }
}

}  // namespace viscobar

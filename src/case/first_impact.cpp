#include "case/first_impact.hpp"

#include <algorithm>
#include <cmath>

namespace viscobar {

namespace {

constexpr double most_nodal_steps = 1e8;

}  // namespace

std::optional<std::vector<FirstImpact>> first_impacts(const Case& run) {
  Case trial = run;
  const Bar& bar = run.scene.bar;
  trial.method = MethodName::fully_discrete;
  trial.step = std::min(run.mesh().spacing() / std::sqrt(bar.modulus / bar.density), run.end / 500.0);
  trial.output_every = run.end;
  // Waves tell it exactly, where they are what is asked for.
  const bool exact = run.method == MethodName::characteristics;
  if (exact) trial.method = run.method;
  if (!exact && run.end / *trial.step * static_cast<double>(run.elements) > most_nodal_steps) return std::nullopt;

  const std::size_t places = static_cast<std::size_t>(is_obstacle(run.scene.left)) +
                             static_cast<std::size_t>(is_obstacle(run.scene.right)) +
                             static_cast<std::size_t>(run.scene.span.has_value());
  std::vector<FirstImpact> found;
  Observers observers;
  observers.event = [&](const Event& event) {
    if (event.change != Change::closing) return;
    if (std::any_of(found.begin(), found.end(), [&](const FirstImpact& f) { return f.where == event.where; })) return;
    const std::optional<EndMotion> still;
    const auto& motion = event.where == Where::left    ? run.scene.left_input.motion
                         : event.where == Where::right ? run.scene.right_input.motion
                                                       : still;
    const double obstacle = motion ? motion->velocity(event.time) : 0.0;
    found.push_back({event.where, event.time, std::abs(event.velocity - obstacle)});
  };
  observers.progress = [&](double) { return found.size() == places ? RunControl::stop : RunControl::go_on; };
  if (places == 0) return found;
  const BarSystem system = make_system(trial);
  const State start = system.initial_state();
  // What lies on its obstacle and moves into it hits at once.
  for (const Contact& contact : system.contacts()) {
    const double u = start.u[contact.unknown], v = contact.sign * start.v[contact.unknown];
    if (v >= 0.0 || contact.clearance(u) > 1e-12 * std::abs(u)) continue;
    const auto same = [&](const FirstImpact& f) { return f.where == contact.where; };
    const auto known = std::find_if(found.begin(), found.end(), same);
    if (known == found.end())
      found.push_back({contact.where, 0.0, -v});
    else
      known->speed = std::max(known->speed, -v);
  }
  if (found.size() == places) return found;
  simulate(trial, system, observers);
  return found;
}

}  // namespace viscobar

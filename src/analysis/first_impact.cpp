#include "viscobar/analysis/first_impact.hpp"

#include <algorithm>
#include <cmath>

namespace viscobar {

namespace {

constexpr double most_nodal_steps = 1e8;

struct AllHaveHit {};

}  // namespace

std::optional<std::vector<FirstImpact>> first_impacts(const Case& run) {
  Case trial = run;
  const Bar& bar = run.scene.bar;
  trial.method = MethodName::fully_discrete;
  trial.step = std::min(run.mesh().spacing() / std::sqrt(bar.modulus / bar.density), run.end / 500.0);
  trial.output_every = run.end;
  if (run.end / *trial.step * static_cast<double>(run.elements) > most_nodal_steps) return std::nullopt;

  const std::size_t places = static_cast<std::size_t>(is_obstacle(run.scene.left)) +
                             static_cast<std::size_t>(is_obstacle(run.scene.right)) +
                             static_cast<std::size_t>(run.scene.span.has_value());
  std::vector<FirstImpact> found;
  Observers observers;
  observers.event = [&](const Event& event) {
    if (event.change != Change::closing) return;
    if (std::any_of(found.begin(), found.end(), [&](const FirstImpact& f) { return f.where == event.where; })) return;
    found.push_back({event.where, event.time, std::max(0.0, -event.velocity)});
    if (found.size() == places) throw AllHaveHit();
  };
  if (places == 0) return found;
  try {
    simulate(trial, make_system(trial), observers);
  } catch (const AllHaveHit&) {
  }
  return found;
}

}  // namespace viscobar

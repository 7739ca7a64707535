// First contacts and chatter, by runs that end with them.
#include <algorithm>
#include <cmath>
#include <utility>

#include "case/chatter.hpp"
#include "case/regime.hpp"
#include "run/contact_places.hpp"

namespace viscobar {

namespace {

struct Sight {
  Foresight found;
  bool complete = false;  ///< all first impacts are among it
};

auto impact_at(auto& impacts, Where where, std::size_t joint) {
  return std::ranges::find_if(impacts,
                              [=](const FirstImpact& one) { return one.where == where && one.joint == joint; });
}

/// First contacts and chatter that the run meets in so many steps.
Sight foreseen_by(Case run, double most_steps, const std::function<bool()>& stop) {
  const Setup trial = resolve(std::move(run));
  const Scene& scene = trial.run.scene;
  const std::size_t places = contact_places(scene).size();
  Sight sight;
  Foresight& found = sight.found;
  auto& impacts = found.impacts;
  const BarSystem system = trial.system();
  // A node that lies on its obstacle and moves into it hits at once.
  const State start = system.initial_state();
  for (const Contact& contact : system.contacts()) {
    const double u = contact.of(start.u), v = contact.sign * contact.of(start.v);
    if (v >= 0.0 || contact.clearance(u) > 1e-12 * std::abs(u)) continue;
    if (const auto before = impact_at(impacts, contact.where, contact.joint); before != impacts.end())
      before->speed = std::max(before->speed, -v);
    else
      impacts.push_back({contact.where, contact.joint, 0.0, -v});
  }
  ChatterWatch watch(system);
  if (is_penalised(trial.run.method)) found.chatters = false;
  const double way_and_back = 2.0 * scene.bar.transit();
  double steps = 0.0;
  Observers observers;
  observers.event = [&](const Event& event) {
    if (found.chatters && watch.heard(event)) found.chatters = true;
    const std::size_t joint = event.where == Where::joint ? event.node : 0;
    if (event.change != Change::closing || impact_at(impacts, event.where, joint) != impacts.end()) return;
    const EndInput& input = event.where == Where::left ? scene.left_input : scene.right_input;
    const bool moves = joint == 0 && event.where != Where::span && input.motion;
    const double obstacle = moves ? input.motion->velocity(event.time) : 0.0;
    impacts.push_back({event.where, joint, event.time, std::abs(event.velocity - obstacle)});
  };
  observers.progress = [&](double time) {
    const bool met = impacts.size() == places;
    const bool heard =
        found.chatters.value_or(true) || (met && !impacts.empty() && time > impacts.back().time + way_and_back);
    return (met && heard) || ++steps > most_steps || (stop && stop()) ? RunControl::stop : RunControl::go_on;
  };
  try {
    if (impacts.size() < places || found.chatters) simulate(trial, system, observers);
  } catch (const IntegrationError&) {
    steps = INFINITY;
  }
  sight.complete = impacts.size() == places || steps <= most_steps;
  if (steps > most_steps && found.chatters == false) found.chatters.reset();
  return sight;
}

}  // namespace

std::optional<Foresight> foresee(const Setup& setup, const std::function<bool()>& stop) {
  const Case& run = setup.run;
  if (!meets_obstacle(run.scene)) return Foresight{};
  Case trial = run;
  trial.output_every = run.end;
  trial.directions.clear();
  const auto elements = static_cast<double>(run.elements);
  // Waves tell it exactly, where they are what is asked for.
  const bool exact = run.method == MethodName::characteristics;
  Sight own = foreseen_by(trial, exact ? 1e300 : 3e6 / elements, stop);
  if (own.complete) return own.found;
  trial.method = MethodName::fully_discrete;
  trial.step = std::min(setup.mesh.spacing() / run.scene.bar.wave_speed(), run.end / 500.0);
  constexpr double most_nodal_steps = 1e8;
  if (1.5 * run.end / *trial.step * elements > most_nodal_steps) return std::nullopt;
  // A rigid obstacle is met no later.
  trial.scene.left_input.stop = trial.scene.right_input.stop = {};
  const double step = *trial.step;
  const Sight fine = foreseen_by(trial, 1e300, stop);
  trial.step = 2.0 * step;
  const Sight coarse = foreseen_by(trial, 1e300, stop);
  if (!fine.complete) return std::nullopt;
  for (FirstImpact impact : fine.found.impacts) {
    if (impact_at(own.found.impacts, impact.where, impact.joint) != own.found.impacts.end()) continue;
    const auto other = impact_at(coarse.found.impacts, impact.where, impact.joint);
    const bool both = other != coarse.found.impacts.end();
    // A scheme has contact changes at the ends of its steps, and begins half a step late.
    impact.time_error = both ? std::max(2.0 * step, std::abs(other->time - impact.time)) : impact.time;
    impact.speed_error = both ? std::abs(other->speed - impact.speed) : impact.speed;
    own.found.impacts.push_back(impact);
  }
  std::ranges::stable_sort(own.found.impacts, {}, &FirstImpact::time);
  return own.found;
}

}  // namespace viscobar

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <utility>

#include "dynamics/natural_scales.hpp"
#include "studies/accuracy/plan.hpp"
#include "studies/parallel.hpp"

namespace viscobar::accuracy {

namespace {

constexpr int most_tries = 4;

constexpr double nudge = 1e-9;  // of the natural velocity

// The velocity changed by a wave that no symmetry hides.
Case nudged(const Case& run, double by) {
  Case other = run;
  const double length = run.scene.bar.length;
  other.scene.velocity = [velocity = run.scene.velocity, by, length](double x) {
    return velocity(x) + by * std::cos(2.0 * x / length);
  };
  return other;
}

std::string plural(std::size_t count) { return fmt::format("{} contact change{}", count, count == 1 ? "" : "s"); }

}  // namespace

// max |change of u| / change of the data as a displacement, on the finest mesh that was run.
double Plan::magnification() const {
  const Setting* finest = nullptr;
  for (const auto& [setting, known] : samples_)
    if (setting.epsilon == chosen_.epsilon) finest = &setting;
  if (!finest) return 1.0;
  const Case run = with(*finest);
  const NaturalScales scales = natural_scales(make_system(run), run.end);
  const double by = nudge * scales.velocity(), moved = by * std::min(run.end, scales.time);
  const std::optional<Sample> other = sample_of(nudged(run, by), study_.stop);
  if (!other) throw Stopped();
  const auto apart = distance(sample(*finest), *other, Goal::displacement, {});
  return apart.value / moved;
}

// The waves tell what they change the motion by; contact changes may magnify it.
ErrorEstimate Plan::judge_exact(const Sample& solution) {
  ErrorEstimate estimate;
  estimate.of = study_.request.of;
  estimate.largest = largest_ = largest(solution, study_.request.of);
  if (!requested_) requested_ = study_.request.error * largest_;
  estimate.requested = requested_;
  estimate.reasons.push_back(
      "characteristics: the bar has no viscosity, and its waves are followed without a mesh; the "
      "elements are places of output only");
  const NaturalScales scales = natural_scales(make_system(base_), base_.end);
  const double by = nudge * scales.velocity(), moved = by * std::min(base_.end, scales.time);
  const auto began = std::chrono::steady_clock::now();
  const std::optional<Sample> other = sample_of(nudged(base_, by), study_.stop);
  if (!other) throw Stopped();
  estimate.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count();
  const Distance found = distance(solution, *other, study_.request.of, grain());
  const double gain = std::max(found.value / moved, study_.request.of == Goal::displacement ? 1.0 : 0.0);
  if (const auto& waves = solution.statistics.representation) {
    estimate.space = waves->error * gain;
    estimate.time = waves->rounding * gain;
  }
  estimate.total = estimate.space + estimate.time;
  if (!found.same_changes && (study_.request.of == Goal::contact_times || found.value > *requested_))
    estimate.doubt = fmt::format(
        "a change of the initial velocity by {:.0e} of it changes which contacts there are: {} "
        "and {}",
        nudge, plural(found.first), plural(found.other));
  if (estimate.total > *requested_ && estimate.doubt.empty())
    estimate.doubt =
        "initial data and load are no polynomial pieces to the digits that were asked for, and no setting "
        "brings them closer: write them without roots of zero or endless wiggles";
  estimate.kept = estimate.total <= *requested_ && estimate.doubt.empty();
  ErrorEstimate::Run made;
  made.elements = base_.elements;
  made.seconds = other->statistics.integration_seconds;
  made.changes = other->statistics.events;
  estimate.runs.push_back(made);
  return estimate;
}

void Plan::explain(ErrorEstimate& estimate, const Case& run) const {
  const AccuracyRequest::Given& given = study_.request.given;
  const auto because = [&](bool given_by_user, const std::string& key, const std::string& why) {
    estimate.reasons.push_back(given_by_user ? key + ": as the scene says" : why);
  };
  because(given.method, fmt::format("{}", name(run.method)),
          run.method == MethodName::rigid ? "rigid: no penalty, so nothing but mesh and tolerance is to be paid for"
                                          : fmt::format("{}: what suits the scene", name(run.method)));
  because(given.mass, fmt::format("{} mass", name(effective_mass(run))),
          fmt::format("{} mass: errors fall with the power {:g} of the mesh where the motion is smooth",
                      name(effective_mass(run)), theory_));
  because(given.elements, fmt::format("{} elements", run.elements),
          fmt::format("{} elements: from {}", run.elements,
                      estimate.order ? fmt::format("the observed power {:.2g} of the mesh", *estimate.order)
                                     : "the difference to coarser meshes, which show no power to rely on"));
  if (penalised_)
    because(given.epsilon, fmt::format("epsilon {:.3g}", *run.epsilon),
            fmt::format("epsilon {:.3g}: its error is a tenth of the request, from two penalties", *run.epsilon));
  if (stepping_)
    because(given.step, fmt::format("step {:.3g}", *run.step),
            fmt::format("step {:.3g}: from two steps on a coarse mesh", *run.step));
  else if (!exact_time_)
    because(given.tolerance, fmt::format("tolerance {:.3g}", run.tolerance.relative),
            fmt::format("tolerance {:.3g}: its error is a tenth of the request, from two tolerances on a coarse mesh",
                        run.tolerance.relative));
}

// What of the scene forbids the error, and what it would have to be; empty where nothing does.
std::string Plan::kept_by_scene(const ErrorEstimate& estimate, double order, double penalty_order) const {
  const AccuracyRequest::Given& given = study_.request.given;
  const double much = 0.15 * *requested_, share = time_share * *requested_;
  const auto needs = [](const std::string& key, double is, double would) {
    return fmt::format("{} = {:.4g} is kept as the scene has it; the error that was asked for needs about {:.2g}", key,
                       is, would);
  };
  if (given.elements && estimate.space > 0.8 * *requested_) {
    const auto elements = static_cast<double>(chosen_.elements);
    return needs("mesh.elements", elements,
                 elements * std::pow(estimate.space / (0.8 * *requested_), 1.0 / std::clamp(order, 0.5, theory_)));
  }
  if (given.tolerance && !stepping_ && estimate.time > much)
    return needs("method.relative_tolerance", chosen_.fineness, chosen_.fineness * share / estimate.time);
  if (given.step && stepping_ && estimate.time > much)
    return needs("method.step", chosen_.fineness, chosen_.fineness * share / estimate.time);
  if (given.epsilon && penalised_ && estimate.penalty > much)
    return needs("contact.epsilon", chosen_.epsilon,
                 chosen_.epsilon * std::pow(share / estimate.penalty, 1.0 / penalty_order));
  return {};
}

ErrorEstimate Plan::judge(Sample solution) {
  again_ = false;
  if (waves_) return judge_exact(solution);
  ErrorEstimate estimate;
  estimate.of = study_.request.of;
  estimate.largest = largest(solution, study_.request.of);
  if (study_.request.relative) requested_ = study_.request.error * estimate.largest;
  estimate.requested = requested_;
  samples_.insert_or_assign(chosen_, std::move(solution));
  const Case judged = with(chosen_);
  const std::size_t elements = chosen_.elements, coarse = std::max<std::size_t>(elements / 4, 3);
  run(rungs(elements));
  bool same = true;
  const std::vector<MeshStep> steps = ladder(elements, study_.request.of, &same);
  const SpaceError space = space_error(steps, theory_of_goal(elements));
  const Part time = time_error(coarse), penalty = penalty_error(coarse);
  estimate.space = space.error;
  estimate.order = space.trusted;
  estimate.effectivity = space.effectivity;
  estimate.time = time.error;
  estimate.penalty = penalty.error;
  estimate.total = estimate.space + estimate.time + estimate.penalty;

  const bool enough = estimate.total <= *requested_;
  std::string doubt = doubt_;
  if (!same && doubt.empty()) {
    const auto changes = [&](std::size_t of) { return plural(sample(rungs(of).back()).statistics.events); };
    const std::size_t half = steps.back().coarse;
    doubt = fmt::format("the meshes of {} and {} elements do not have the same contacts, with {} and {}", half,
                        elements, changes(half), changes(elements));
  }
  if (!enough)
    if (const std::string fixed = kept_by_scene(estimate, space.order, penalty.order); !fixed.empty()) doubt = fixed;
  if (doubt_.empty() && (!same || !enough) && tries_ + 1 < most_tries) {
    ++tries_;
    const Setting before = chosen_;
    if (!study_.request.given.elements && (!same || estimate.space > 0.8 * *requested_)) {
      const std::size_t finer = same ? std::max(2 * elements, wanted_elements(space, elements)) : 2 * elements;
      if (affordable(finer))
        chosen_.elements = finer;
      else if (doubt.empty())
        doubt = fmt::format("about {} elements would keep the error that was asked for, more than are tried", finer);
    }
    if (doubt.empty() || chosen_.elements != before.elements) {
      refine_time(time);
      refine_penalty(penalty);
      again_ = chosen_ != before;
    }
  }
  if (!enough && doubt.empty() && !again_) doubt = "the settings that were tried do not reach what was asked for";
  estimate.doubt = doubt;
  estimate.kept = enough && doubt.empty();
  estimate.runs = runs_;
  estimate.seconds = seconds_;
  explain(estimate, judged);
  std::sort(estimate.runs.begin(), estimate.runs.end(),
            [](const auto& a, const auto& b) { return a.elements < b.elements; });
  return estimate;
}

}  // namespace viscobar::accuracy

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "case/regime.hpp"
#include "dynamics/natural_scales.hpp"
#include "studies/accuracy/plan.hpp"

namespace viscobar::accuracy {

namespace {

constexpr int most_tries = 4;

Setting nudged(Setting setting) {
  setting.nudged = true;
  return setting;
}

// True if the places that are kept move as one at all times.
bool flat(const Sample& sample) {
  constexpr double alike = 1e-9;
  const double most = alike * largest(sample, Goal::displacement);
  for (std::size_t k = 0; k < sample.rows(); ++k) {
    const auto [low, high] = std::minmax_element(sample.row(k), sample.row(k) + sample.x.size());
    if (*high - *low > most) return false;
  }
  return true;
}

std::string plural(std::size_t count) { return fmt::format("{} contact change{}", count, count == 1 ? "" : "s"); }

}  // namespace

// All but the solution.
std::vector<Setting> Plan::wanted_by_judge() const {
  if (waves_) return {nudged(chosen_)};
  std::vector<Setting> all = rungs_;
  for (const auto& pair : {time_pair(coarse()), penalty_pair(coarse())})
    all.insert(all.end(), pair.begin(), pair.end());
  if (const auto stopped = without_rebound()) all.push_back(*stopped);
  std::erase(all, chosen_);
  return all;
}

// The mesh below the finest with restitution 0. The rebound that is lost between the two is no less than on the finest.
std::optional<Setting> Plan::without_rebound() const {
  if (!loses_rebound_ || rungs_.empty()) return std::nullopt;
  Setting stopped = rungs_[rungs_.size() - std::min<std::size_t>(rungs_.size(), 2)];
  stopped.stopped = true;
  return stopped;
}

// Adds to the error what finer meshes change more than coarser ones show; returns why it is not to be relied on.
std::string Plan::count_what_grows(SpaceError& space, const std::vector<MeshStep>& steps, const Part& time) {
  constexpr double far = 5.0, rounding_share = 1e-12;  // of what rounding and integration leave
  const auto raise = [&](double error) {
    if (space.error > 0.0) space.effectivity *= error / space.error;
    space.error = error;
    space.trusted.reset();
  };
  if (const auto stopped = without_rebound(); stopped && !flat(runs_.of(chosen_))) {
    Setting thrown = *stopped;
    thrown.stopped = false;
    const double lost = apart(thrown, *stopped);
    const bool counts = lost > std::min(space.error, *requested_);
    raise(space.error + lost);
    if (!counts) return {};
    return fmt::format(
        "the result is that of its mesh: finer ones of a viscous bar lose the rebound of nodes that reach the span "
        "obstacle one after another, and tend to restitution 0, {:.2g} from this",
        lost);
  }
  if (space.settles || steps.back().distance <= far * (time.error + rounding_share * largest_)) return {};
  raise(std::max(space.error, largest_));
  return fmt::format(
      "the result does not settle: the runs on {}, {} and {} elements are further from each other the finer they are",
      steps.end()[-2].coarse, steps.back().coarse, steps.back().fine);
}

// The change of the data as a displacement.
double Plan::moved_by_nudge() const {
  return nudge_ * std::min(base_.end, natural_scales(resolve(base_).system(), base_.end).time);
}

// max |change of u| / change of the data, on the finest mesh that was run.
double Plan::magnification() {
  std::optional<Setting> finest;
  for (const Setting& known : runs_.known())
    if (known.epsilon == chosen_.epsilon) finest = known;
  if (!finest) return 1.0;
  const double bound = std::exchange(runs_.most_seconds, RunLimits().seconds);
  runs_.make({nudged(*finest)});
  runs_.most_seconds = bound;
  return difference(runs_.of(*finest), runs_.of(nudged(*finest)), Goal::displacement) / moved_by_nudge();
}

ErrorEstimate Plan::begun_estimate() {
  ErrorEstimate estimate;
  estimate.of = study_.request.of;
  estimate.largest = largest_ = largest(runs_.of(chosen_), study_.request.of);
  if (study_.request.relative) requested_ = study_.request.error * largest_;
  if (!as_it_is_) estimate.requested = requested_;
  return estimate;
}

// The waves tell what they change the motion by; contact changes may magnify it.
ErrorEstimate Plan::judge_exact() {
  const Sample& solution = runs_.of(chosen_);
  ErrorEstimate estimate = begun_estimate();
  estimate.reasons.push_back(
      "characteristics: the bar has no viscosity, and its waves are followed without a mesh; the "
      "elements are places of output only");
  const Sample& other = runs_.of(nudged(chosen_));
  const double moved = difference(solution, other, study_.request.of, resolution());
  const SameChanges changes = compare_changes(solution, other, resolution());
  const double gain = std::max(moved / moved_by_nudge(), study_.request.of == Goal::displacement ? 1.0 : 0.0);
  if (const auto& waves = solution.statistics.representation) {
    estimate.space = waves->error * gain;
    estimate.time = waves->rounding * gain;
  }
  estimate.total = estimate.space + estimate.time;
  if (!changes.same && (study_.request.of == Goal::contact_times || moved > *requested_))
    estimate.doubt = fmt::format(
        "a change of the initial velocity by {:.0e} of it changes which contacts there are: {} "
        "and {}",
        nudge_share, plural(changes.coarse), plural(changes.fine));
  if (estimate.total > *requested_ && estimate.doubt.empty())
    estimate.doubt =
        "initial data and load are no polynomial pieces to the digits that were asked for, and no setting "
        "brings them closer: write them without roots of zero or endless wiggles";
  estimate.kept = !as_it_is_ && estimate.total <= *requested_ && estimate.doubt.empty();
  tell_runs(estimate);
  return estimate;
}

// From coarse to fine.
void Plan::tell_runs(ErrorEstimate& estimate) const {
  estimate.seconds = runs_.seconds();
  const std::vector<Setting> needed = wanted_by_judge();
  for (const auto& [setting, statistics] : runs_.made()) {
    if (setting == chosen_) continue;
    ErrorEstimate::Run made;
    made.elements = setting.elements;
    if (!exact_time_ && !waves_) made.setting = setting.fineness;
    if (penalised_) made.epsilon = setting.epsilon;
    made.seconds = statistics.integration_seconds;
    made.changes = statistics.events;
    made.search = std::ranges::find(needed, setting) == needed.end();
    estimate.runs.push_back(made);
  }
  std::stable_sort(estimate.runs.begin(), estimate.runs.end(),
                   [](const auto& a, const auto& b) { return a.elements < b.elements; });
}

void Plan::explain(ErrorEstimate& estimate, const Case& run) const {
  const Setup setup = resolve(run);
  const AccuracyRequest::Given& given = by_user_;
  const auto because = [&](bool given_by_user, const std::string& key, const std::string& why) {
    estimate.reasons.push_back(given_by_user ? key + ": as the scene says" : why);
  };
  because(given.method, fmt::format("{}", name(run.method)),
          run.method == MethodName::rigid ? "rigid: no penalty, so nothing but mesh and tolerance is to be paid for"
                                          : fmt::format("{}: what suits the scene", name(run.method)));
  because(given.mass, fmt::format("{} mass", name(setup.mass)),
          fmt::format("{} mass: errors fall with the power {:g} of the mesh where the motion is smooth",
                      name(setup.mass), theory_));
  because(given.elements, fmt::format("{} elements", run.elements),
          fmt::format("{} elements: from {}", run.elements,
                      estimate.order ? fmt::format("the observed power {:.2g} of the mesh", *estimate.order)
                                     : "the difference to coarser meshes, which show no power to rely on") +
              (unit_ == 1                ? ""
               : run.scene.chain.empty() ? "; the data break at nodes"
                                         : "; multiples of those of each bar"));
  if (penalised_)
    estimate.reasons.push_back(
        contact_law(setup) + (run.restitution && !given.restitution
                                  ? "; without this request they are thrown back: give contact.restitution to say which"
                                  : ""));
  if (penalised_)
    because(given.epsilon, fmt::format("epsilon {:.3g}", *run.epsilon),
            fmt::format("epsilon {:.3g}: from two penalties, its part of the error", *run.epsilon));
  if (stepping_)
    because(given.step, fmt::format("step {:.3g}", *run.step),
            fmt::format("step {:.3g}: from two steps on a coarse mesh", *run.step));
  else if (!exact_time_)
    because(given.tolerance, fmt::format("tolerance {:.3g}", run.tolerance.relative),
            fmt::format("tolerance {:.3g}: from two tolerances on a coarse mesh", run.tolerance.relative));
  if (begun_) estimate.reasons.emplace_back("the search began with the settings of a neighbouring case");
}

// The setting given in the scene that keeps the error from being reached, and the value needed; empty: there is none.
std::string Plan::kept_by_scene(const ErrorEstimate& estimate, double order, double penalty_order) const {
  const AccuracyRequest::Given& given = study_.request.given;
  const double space = shares_.space * *requested_, time = shares_.time * *requested_,
               penalty = shares_.penalty * *requested_;
  const auto needs = [](const std::string& key, double is, double would) {
    return fmt::format("{} = {:.4g} is kept as the scene has it; the error that was asked for needs about {:.2g}", key,
                       is, would);
  };
  if (given.elements && estimate.space > space) {
    const auto elements = static_cast<double>(chosen_.elements);
    const double would = elements * std::pow(estimate.space / space, 1.0 / std::clamp(order, 0.5, theory_));
    return needs("mesh.elements", elements, std::isfinite(would) ? would : static_cast<double>(data_error_.least()));
  }
  if (given.tolerance && !stepping_ && estimate.time > excess * time)
    return needs("method.relative_tolerance", chosen_.fineness, chosen_.fineness * time / estimate.time);
  if (given.step && stepping_ && estimate.time > excess * time)
    return needs("method.step", chosen_.fineness, chosen_.fineness * time / estimate.time);
  if (given.epsilon && penalised_ && estimate.penalty > excess * penalty)
    return needs("contact.epsilon", chosen_.epsilon,
                 chosen_.epsilon * std::pow(penalty / estimate.penalty, 1.0 / penalty_order));
  return {};
}

ErrorEstimate Plan::judge(std::optional<Sample> solution) {
  again_ = false;
  runs_.finish();
  if (solution) runs_.add(chosen_, std::move(*solution));
  std::vector<Setting> wanted = wanted_by_judge();
  wanted.push_back(chosen_);
  runs_.make(std::move(wanted));
  if (waves_) return judge_exact();
  ErrorEstimate estimate = begun_estimate();
  const Case judged = with(chosen_);
  const std::size_t elements = chosen_.elements;
  bool same = true;
  const std::vector<MeshStep> steps = ladder(rungs_, &same);
  SpaceError space = seen_error(steps);
  const Part time = time_error(coarse()), penalty = penalty_error(coarse());
  const std::string unsettled = count_what_grows(space, steps, time);
  estimate.space = space.error;
  estimate.order = space.trusted;
  estimate.effectivity = space.effectivity;
  estimate.time = time.error;
  estimate.penalty = penalty.error;
  estimate.total = estimate.space + estimate.time + estimate.penalty;
  if (as_it_is_) {
    estimate.doubt = unsettled;
    tell_runs(estimate);
    if (penalised_) estimate.reasons.push_back(contact_law(resolve(judged)));
    if (const std::size_t least = data_error_.least(); least > elements)
      estimate.reasons.push_back(
          fmt::format("the load has waves that {} elements do not have, and {} would", elements, least));
    return estimate;
  }

  const bool enough = estimate.total <= *requested_;
  if (!enough && doubt_.empty()) doubt_ = unsettled;  // no finer mesh is tried
  std::string doubt = doubt_;
  if (!same && doubt.empty()) {
    const auto changes = [&](const Setting& of) { return plural(runs_.of(of).statistics.events); };
    const Setting half = rungs_[rungs_.size() - 2];
    doubt = fmt::format("the meshes of {} and {} elements do not have the same contacts, with {} and {}", half.elements,
                        elements, changes(half), changes(chosen_));
  }
  if (!enough && unsettled.empty())
    if (const std::string fixed = kept_by_scene(estimate, space.order, penalty.order); !fixed.empty()) doubt = fixed;
  if (doubt_.empty() && (!same || !enough) && tries_ + 1 < most_tries) {
    ++tries_;
    const Setting before = chosen_;
    if (!study_.request.given.elements && (!same || estimate.space > shares_.space * *requested_)) {
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
  tell_runs(estimate);
  explain(estimate, judged);
  return estimate;
}

}  // namespace viscobar::accuracy

#include "studies/accuracy/plan.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <mutex>
#include <stdexcept>
#include <utility>

#include "case/cost_estimate.hpp"
#include "dynamics/natural_scales.hpp"
#include "studies/parallel.hpp"

namespace viscobar::accuracy {

namespace {

constexpr std::size_t least_elements = 32;  // of a solution: fewer are no faster
constexpr double penalty_share = 0.1;
constexpr double finest_tolerance = 1e-13, loosest_tolerance = 1e-4, loosest_that_methods_take = 0.1;
constexpr double least_order_of_penalty = 0.5, penalty_ratio = 10.0;

bool has_obstacle(const Scene& scene) { return is_obstacle(scene.left) || is_obstacle(scene.right) || scene.span; }

double error_of(double apart, double ratio, double order) {
  const double share = std::pow(ratio, -order);
  return apart * share / (1.0 - share);
}

}  // namespace

Plan::Plan(const AccuracyStudy& study) : study_(study), base_(study.scene) {
  const AccuracyRequest::Given& given = study_.request.given;
  const Scene& scene = base_.scene;
  waves_ = base_.method == MethodName::characteristics;
  stepping_ = is_scheme(base_.method);
  exact_time_ = base_.method == MethodName::exponential;
  penalised_ = is_penalised(base_.method) && has_obstacle(scene);
  if (const auto found = fault(study_.request, base_))
    throw std::invalid_argument(fmt::format("{}: {}", found->key, found->problem));
  // A massive node of the fourth-order mass that a dashpot stops does what it does in the limit.
  if (penalised_ && !given.mass && !given.restitution && !scene.span) {
    Case better = base_;
    better.mass = Mass::fourth_order;
    better.restitution = 0.0;
    if (base_.grading == 1.0 && validate(better).empty()) base_ = better;
  }
  theory_ = effective_mass(base_) == Mass::fourth_order ? 4.0 : 2.0;
  ratio_ = stepping_ ? 2.0 : 10.0;
  time_order_ = stepping_ ? 1.0 : 2.0 / 3.0;
  if (!study_.request.relative) requested_ = study_.request.error;

  chosen_.elements = base_.elements;
  const double length = natural_scales(make_system(base_), base_.end).displacement;
  const double share = study_.request.relative ? study_.request.error
                       : study_.request.of == Goal::displacement || study_.request.of == Goal::end_traces
                           ? study_.request.error / length
                           : 1e-6;
  if (stepping_) {
    const double crossing = scene.bar.length * std::sqrt(scene.bar.density / scene.bar.modulus);
    chosen_.fineness = given.step ? *base_.step : std::min(crossing / (4.0 * least_elements), base_.end / 200.0);
  } else if (!exact_time_) {
    chosen_.fineness =
        given.tolerance ? base_.tolerance.relative : std::clamp(time_share * share, 1e-8, loosest_tolerance);
  }
  if (penalised_)
    chosen_.epsilon = given.epsilon ? *base_.epsilon : std::clamp(share * 1e-1, 1e-8, 1e-3) * natural_epsilon(scene);
}

Case Plan::with(const Setting& setting) const {
  Case run = base_;
  run.elements = setting.elements;
  if (penalised_) run.epsilon = setting.epsilon;
  if (stepping_)
    run.step = setting.fineness;
  else if (!exact_time_ && !waves_)
    run.tolerance = run.tolerance.with_relative(setting.fineness);
  return run;
}

void Plan::tell(const std::string& what) const {
  if (study_.message) study_.message(what);
}

// Those that are not known yet, side by side, the dearest first.
void Plan::run(std::vector<Setting> settings) {
  std::sort(settings.begin(), settings.end(), [](const Setting& a, const Setting& b) { return b < a; });
  settings.erase(std::unique(settings.begin(), settings.end()), settings.end());
  std::erase_if(settings, [&](const Setting& one) { return samples_.contains(one); });
  if (settings.empty()) return;
  std::vector<std::optional<Sample>> found(settings.size());
  const auto began = std::chrono::steady_clock::now();
  const auto passed = [&] { return std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count(); };
  const auto stop = [&] {
    return (study_.stop && study_.stop()) || (bounded_ && seconds_ + passed() > study_.most_seconds);
  };
  parallel_for(
      settings.size(), [&](std::size_t i) { found[i] = sample_of(with(settings[i]), stop); }, study_.threads);
  seconds_ += passed();
  for (std::size_t i = 0; i < settings.size(); ++i) {
    if (!found[i] && study_.stop && study_.stop()) throw Stopped();
    if (!found[i]) throw TooLong();
    ErrorEstimate::Run made;
    made.elements = settings[i].elements;
    if (!exact_time_ && !waves_) made.setting = settings[i].fineness;
    if (penalised_) made.epsilon = settings[i].epsilon;
    made.seconds = found[i]->statistics.integration_seconds;
    made.changes = found[i]->statistics.events;
    runs_.push_back(made);
    samples_.emplace(settings[i], std::move(*found[i]));
  }
}

Grain Plan::grain() const {
  const Bar& bar = base_.scene.bar;
  Grain grain;
  grain.impedance = std::sqrt(bar.density * bar.modulus);
  const double share = 0.5 * requested_.value_or(0.0);
  switch (study_.request.of) {
    case Goal::displacement:
    case Goal::end_traces: grain.height = share; break;
    case Goal::contact_times: grain.duration = share; break;
    case Goal::impulse: grain.height = share / grain.impedance; break;
    case Goal::peak_reaction: break;
  }
  return grain;
}

double Plan::apart(const Setting& coarse, const Setting& fine, bool* same) const {
  const Distance found = distance(sample(coarse), sample(fine), study_.request.of, grain());
  if (same) *same = found.same_changes;
  return found.value;
}

// Elements of half as many and so on, down to what a mass can be put on.
std::vector<std::size_t> Plan::coarser(std::size_t elements) const {
  std::vector<std::size_t> all;
  for (std::size_t n = (elements + 1) / 2; n >= 4 && n < elements && all.size() < 3; n = (n + 1) / 2) {
    all.push_back(n);
    if (n == (n + 1) / 2) break;
  }
  std::reverse(all.begin(), all.end());
  return all;
}

// The settings of a ladder of meshes. Tolerances may be looser than the chosen one, which only the last step would
// notice; steps of a scheme are all the same.
std::vector<Setting> Plan::rungs(std::size_t finest) const {
  std::vector<std::size_t> meshes = coarser(finest);
  meshes.push_back(finest);
  std::vector<Setting> all;
  for (const std::size_t elements : meshes) {
    Setting best{elements, chosen_.fineness, chosen_.epsilon};
    if (!stepping_ && !samples_.contains(best)) {
      const auto known = std::find_if(samples_.begin(), samples_.end(), [&](const auto& one) {
        return one.first.elements == elements && one.first.epsilon == chosen_.epsilon &&
               one.first.fineness <= 10.0 * chosen_.fineness;
      });
      if (known != samples_.end()) best = known->first;
    }
    all.push_back(best);
  }
  return all;
}

// `same`: whether the last two agree on the contact changes.
std::vector<MeshStep> Plan::ladder(std::size_t finest, Goal of, bool* same) const {
  const std::vector<Setting> steps = rungs(finest);
  *same = true;
  std::vector<MeshStep> result;
  for (std::size_t k = 0; k + 1 < steps.size(); ++k) {
    const Distance found = distance(sample(steps[k]), sample(steps[k + 1]), of, grain());
    *same = found.same_changes;
    result.push_back(
        {steps[k].elements, steps[k + 1].elements, found.value,
         k == 0 ? 1.0 : alignment(sample(steps[k - 1]), sample(steps[k]), sample(steps[k + 1]), of, grain())});
  }
  return result;
}

double Plan::theory_of_goal(std::size_t finest) const {
  const Goal of = study_.request.of;
  if (of == Goal::displacement) return theory_;
  bool same = true;
  return space_error(ladder(finest, Goal::displacement, &same), theory_).trusted.value_or(1.0);
}

// From the two finest settings in time on one mesh.
Plan::Part Plan::time_part(const Setting& finest) const {
  std::vector<double> settings;
  for (const auto& [setting, known] : samples_)
    if (setting.elements == finest.elements && setting.epsilon == finest.epsilon) settings.push_back(setting.fineness);
  Part part{0.0, time_order_};
  if (settings.size() < 2) return part;
  const Setting fine{finest.elements, settings[0], finest.epsilon}, loose{finest.elements, settings[1], finest.epsilon};
  const double found = apart(fine, loose);
  if (settings.size() >= 3 && stepping_) {
    const Setting looser{finest.elements, settings[2], finest.epsilon};
    const double before = apart(loose, looser);
    if (before > 0.0 && found > 0.0) {
      const double order = std::log(before / found) / std::log(settings[2] / settings[1]);
      if (order > 1.0) part.order = std::min(order, 2.0);
    }
  }
  part.error = error_of(found, settings[1] / settings[0], part.order);
  return part;
}

Plan::Part Plan::penalty_part(const Setting& finest) const {
  std::vector<double> settings;
  for (const auto& [setting, known] : samples_)
    if (setting.elements == finest.elements && setting.fineness == finest.fineness) settings.push_back(setting.epsilon);
  Part part{0.0, least_order_of_penalty};
  if (settings.size() < 2) return part;
  const Setting fine{finest.elements, finest.fineness, settings[0]},
      soft{finest.elements, finest.fineness, settings[1]};
  const double found = apart(fine, soft);
  if (settings.size() >= 3) {
    const double before = apart(soft, {finest.elements, finest.fineness, settings[2]});
    if (before > 0.0 && found > 0.0) {
      const double order = std::log(before / found) / std::log(settings[2] / settings[1]);
      if (order > least_order_of_penalty) part.order = std::min(order, 1.0);
    }
  }
  part.error = error_of(found, settings[1] / settings[0], part.order);
  return part;
}

void Plan::pilot() {
  const AccuracyRequest::Given& given = study_.request.given;
  const std::size_t finest = given.elements ? std::max<std::size_t>(base_.elements / 2, 3) : least_elements;
  std::vector<Setting> settings;
  const auto at = [&](std::size_t elements) { return Setting{elements, chosen_.fineness, chosen_.epsilon}; };
  settings.push_back(at(finest));
  for (const std::size_t elements : coarser(finest)) settings.push_back(at(elements));
  run(settings);
  largest_ = largest(sample(at(finest)), study_.request.of);
  if (!requested_) requested_ = study_.request.error * largest_;
  if (!given.elements) chosen_.elements = finest;
  piloted_ = true;
}

// The error of the chosen tolerance, or step, on a mesh.
Plan::Part Plan::time_error(std::size_t elements) {
  if (exact_time_ || waves_) return {};
  const Setting finest{elements, chosen_.fineness, chosen_.epsilon};
  Setting looser = finest;
  looser.fineness *= ratio_;
  if (!stepping_ && looser.fineness > loosest_that_methods_take) {
    Setting finer = finest;
    finer.fineness /= ratio_;
    run({finest, finer});
    return {apart(finest, finer) / (1.0 - std::pow(ratio_, -time_order_)), time_order_};
  }
  run({finest, looser});
  return time_part(finest);
}

Plan::Part Plan::penalty_error(std::size_t elements) {
  if (!penalised_) return {};
  const Setting finest{elements, chosen_.fineness, chosen_.epsilon};
  Setting softer = finest;
  softer.epsilon *= penalty_ratio;
  run({finest, softer});
  return penalty_part(finest);
}

// A finer one whose error is a tenth of the request (of a scheme, 40 %); whether it is another one.
bool Plan::refine_time(const Part& part) {
  const bool given = stepping_ ? study_.request.given.step : study_.request.given.tolerance;
  const double share = (stepping_ ? 0.4 : time_share) * *requested_;
  if (given || exact_time_ || waves_ || part.error <= 1.5 * share) return false;
  const double order = stepping_ ? part.order : 0.9, least = stepping_ ? 1.0 / 16.0 : 1e-5;
  double finer = chosen_.fineness * std::clamp(std::pow(share / part.error, 1.0 / order), least, 0.5);
  if (!stepping_) finer = std::max(finer, finest_tolerance);
  return finer < std::exchange(chosen_.fineness, std::min(finer, chosen_.fineness));
}

bool Plan::refine_penalty(const Part& part) {
  const double share = penalty_share * *requested_, least = 1e-16 * natural_epsilon(base_.scene);
  if (!penalised_ || study_.request.given.epsilon || part.error <= 1.5 * share) return false;
  const double harder =
      std::max(least, chosen_.epsilon * std::clamp(std::pow(share / part.error, 1.0 / part.order), 1e-4, 0.5));
  return harder < std::exchange(chosen_.epsilon, std::min(harder, chosen_.epsilon));
}

void Plan::settle(std::size_t elements) {
  constexpr int most_rounds = 6;
  for (int k = 0; k < most_rounds && refine_time(time_error(elements)); ++k) continue;
  for (int k = 0; k < most_rounds && refine_penalty(penalty_error(elements)); ++k) continue;
}

bool Plan::affordable(std::size_t elements) const {
  Case run = with({elements, chosen_.fineness, chosen_.epsilon});
  return elements <= study_.most_elements && estimated_seconds(run) <= 10.0 * study_.most_seconds &&
         validate(run).empty();
}

// J (e / wanted)^(1/p), in eights, so that two halvings have nodes in common.
std::size_t Plan::wanted_elements(const SpaceError& known, std::size_t at) const {
  const double share = stepping_ ? 0.5 : 0.75, order = std::clamp(known.order, 0.5, theory_);
  const double longest = known.trusted ? 16.0 : 4.0;
  if (known.error <= 0.0) return least_elements;
  const double factor = std::pow(known.error / (share * reachable_), 1.0 / order);
  const double elements = static_cast<double>(at) * std::min(factor, longest);
  const auto eights = static_cast<std::size_t>(std::ceil(elements / 8.0)) * 8;
  return std::max(eights, least_elements);
}

// Meshes are refined until the last one before the solution's promises that the solution keeps the request.
void Plan::climb() {
  std::size_t known = chosen_.elements;
  const Setting first = chosen_;
  bounded_ = true;
  try {
    climb_from(known);
  } catch (const TooLong&) {
    chosen_ = first;
    chosen_.elements = known;
    doubt_ = fmt::format("meshes of more than {} elements take longer than {:.3g} s to try, and that one is too coarse",
                         known, study_.most_seconds);
  }
  bounded_ = false;
}

// `known`: the finest mesh that has been run.
void Plan::climb_from(std::size_t& known) {
  constexpr int most_rounds = 14;
  const double share = stepping_ ? 0.5 : 0.8;
  double before = 0.0;
  int stuck = 0;
  for (int round = 0; round < most_rounds; ++round) {
    bool same = true;
    run(rungs(known));
    const std::vector<MeshStep> steps = ladder(known, study_.request.of, &same);
    const SpaceError now = space_error(steps, theory_of_goal(known));
    std::size_t next = same ? wanted_elements(now, known) : 2 * known;
    if (now.error <= share * reachable_ && same && next <= known) {
      chosen_.elements = known;
      return;
    }
    next = std::max(next, known);
    const double apart = steps.empty() ? 0.0 : steps.back().distance;
    stuck = before > 0.0 && apart > 0.9 * before ? stuck + 1 : 0;
    before = apart;
    if (stuck >= 3) {
      doubt_ = fmt::format(
          "no mesh converges: runs on {} and {} elements are {:.2g} apart, no less than coarser ones; the scene "
          "multiplies a small change of its initial data by {:.2g}",
          steps.back().coarse, steps.back().fine, apart, magnification());
      chosen_.elements = known;
      return;
    }
    const double order = std::clamp(now.order, 0.5, theory_);
    const double wanted = static_cast<double>(known) * std::pow(now.error / (share * reachable_), 1.0 / order);
    constexpr std::size_t telling = 512;  // elements that show how a scene converges
    if (!affordable(next) || (known >= telling && wanted > 20.0 * static_cast<double>(study_.most_elements))) {
      doubt_ = fmt::format(
          "about {:.2g} elements would keep the error that was asked for, and {} are the most that "
          "are tried: the error falls with the power {:.2g} of the mesh here; the scene multiplies a "
          "small change of its initial data by {:.2g}",
          wanted, study_.most_elements, now.order, magnification());
      chosen_.elements = known;
      return;
    }
    const std::size_t half = next / 2;
    settle(std::max<std::size_t>(next / 4, 8));
    run(rungs(half));
    bool agree = true;
    const std::vector<MeshStep> finer = ladder(half, study_.request.of, &agree);
    if (agree && space_error(finer, theory_of_goal(half)).error <= share * reachable_) {
      chosen_.elements = half;
      return;
    }
    if (agree && predicted_error(finer, theory_of_goal(half), next).error <= 1.1 * share * reachable_) {
      chosen_.elements = next;
      return;
    }
    known = half > known ? half : next;
  }
  chosen_.elements = known;
  doubt_ = "no mesh was found that keeps the error that was asked for";
}

Case Plan::next() {
  again_ = false;
  if (waves_) return base_;
  if (!piloted_) {
    tell("the error on coarse meshes");
    pilot();
    const std::size_t coarse = study_.request.given.elements ? std::max<std::size_t>(base_.elements / 4, 3) : 16;
    settle(coarse);
    reachable_ = std::max(*requested_, time_error(coarse).error + penalty_error(coarse).error);
    if (!study_.request.given.elements) climb();
  }
  const Case run = with(chosen_);
  tell(fmt::format("{} on {} elements{}", name(run.method), run.elements,
                   stepping_     ? fmt::format(", step {:.2g}", *run.step)
                   : exact_time_ ? ""
                                 : fmt::format(", tolerance {:.2g}", run.tolerance.relative)));
  return run;
}

}  // namespace viscobar::accuracy

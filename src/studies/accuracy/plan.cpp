#include "studies/accuracy/plan.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <stdexcept>
#include <utility>

#include "dynamics/natural_scales.hpp"
#include "dynamics/pieces.hpp"

namespace viscobar::accuracy {

namespace {

// Tolerances of the runs that tell which tolerance is needed.
constexpr double finest_pilot = 1e-8, loosest_tolerance = 1e-3;

// A wave that no symmetry hides, at rest where an end is fixed: a polynomial, which adds no pieces to those of a bar.
SpaceFunction nudge(const Scene& scene, double by) {
  const bool left = std::holds_alternative<Fixed>(scene.left), right = std::holds_alternative<Fixed>(scene.right);
  return [by, left, right, length = scene.bar.length](double x) {
    const double s = x / length;
    return by * (left ? s : 1.0) * (right ? 1.0 - s : 1.0) * (1.0 - 1.4 * s);
  };
}

}  // namespace

Plan::Plan(Case as_it_is, double most_seconds, std::function<bool()> stop)
    : Plan([&] {
        AccuracyStudy study;
        study.scene = resolve(std::move(as_it_is)).settled();  // coarser meshes take the settings of this one
        study.request.error = std::numeric_limits<double>::infinity();
        study.request.given = {true, true, true, true, true, true, true};
        study.stop = std::move(stop);
        return study;
      }()) {
  as_it_is_ = true;
  runs_.most_seconds = most_seconds;
}

Plan::Plan(const AccuracyStudy& study)
    : study_(study),
      by_user_(study.request.given),
      base_(on_its_mesh(study.scene)),
      data_error_(base_, study.request.of == Goal::displacement || study.request.of == Goal::end_traces),
      runs_([this](const Setting& setting) { return with(setting); }, times_of_errors(study.scene.end),
            study.request.of == Goal::peak_reaction || has_stops(study.scene.scene), study.threads, study.stop) {
  AccuracyRequest::Given& given = study_.request.given;
  if (study.resumed) given = {true, true, true, true, true, true, true};
  const Scene& scene = base_.scene;
  waves_ = base_.method == MethodName::characteristics;
  stepping_ = is_scheme(base_.method);
  exact_time_ = base_.method == MethodName::exponential;
  penalised_ = is_penalised(base_.method) && has_penalty(scene);
  if (const auto found = fault(study_.request, resolve(base_)))
    throw std::invalid_argument(fmt::format("{}: {}", found->key, found->problem));
  // A massive node that a dashpot stops does what it does in the limit. Under a span obstacle neighbours meet it at
  // once, and only a diagonal mass keeps their impacts apart; on fourth_order a free end that meets it has order 1.
  if (!given.mass && (penalised_ ? !given.restitution : stepping_ && scene.span)) {
    Case better = base_;
    better.mass = scene.span ? Mass::lumped : Mass::fourth_order;
    if (penalised_ && study_.request.of != Goal::peak_reaction) better.restitution = 0.0;
    if (sound(better)) base_ = better;
  }
  theory_ = order_in_theory(base_);
  loses_rebound_ = stepping_ && scene.span && scene.bar.viscosity > 0.0 && base_.restitution.value_or(0.0) > 0.0;
  ratio_ = stepping_ ? 2.0 : 10.0;
  time_order_ = stepping_ ? 1.0 : base_.method == MethodName::rigid ? 0.85 : 2.0 / 3.0;
  if (!study_.request.relative) requested_ = study_.request.error;

  chosen_.elements = base_.elements;
  const NaturalScales scales = natural_scales(resolve(base_).system(), base_.end);
  const double length = scales.displacement;
  nudge_ = nudge_share * scales.velocity();
  if (stepping_)
    shares_ = {0.5, 0.1, 0.4};
  else if (penalised_)
    shares_.space = 0.55;
  const double share = study_.request.relative ? study_.request.error
                       : study_.request.of == Goal::displacement || study_.request.of == Goal::end_traces
                           ? study_.request.error / length
                           : 1e-6;
  if (stepping_) {
    const double crossing = scene.bar.transit();
    chosen_.fineness = given.step ? *base_.step : std::min(crossing / (4.0 * least_elements), base_.end / 200.0);
  } else if (!exact_time_) {
    chosen_.fineness = given.tolerance ? base_.tolerance.relative : std::clamp(share, finest_pilot, loosest_tolerance);
  }
  constexpr double loose = 1e-4;  // then eight elements may tell that the least of a solution are enough
  if (theory_ > 2.0 && !stepping_ && !penalised_ && share >= loose) pilot_elements_ = least_elements / 2;
  if (penalised_)
    chosen_.epsilon = given.epsilon ? *base_.epsilon : std::clamp(share * 1e-1, 1e-8, 1e-3) * natural_epsilon(scene);
  unit_ = data_error_.unit();
  doubled_ = study_.request.of == Goal::displacement && data_error_.rough();
  apart_ = data_error_.nodal() && unit_ == 1 && !doubled_;
  const std::size_t in_a_bar = pilot_elements_;
  pilot_elements_ = doubled_unit(std::max(pilot_elements_, std::min(data_error_.least(), study_.most_elements)));
  while (!scene.chain.empty() && pilot_elements_ < study_.most_elements && fewest_at(pilot_elements_) < in_a_bar)
    pilot_elements_ *= 2;
  timed_elements_ = pilot_elements_;
  guess_ = chosen_;
  if (study_.start && !waves_) begin_at(*study_.start);
}

Case Plan::with(const Setting& setting) const {
  Case run = base_;
  run.elements = setting.elements;
  if (penalised_) run.epsilon = setting.epsilon;
  if (stepping_)
    run.step = setting.fineness;
  else if (!exact_time_ && !waves_)
    run.tolerance = run.tolerance.with_relative(setting.fineness);
  if (setting.stopped) run.restitution = 0.0;
  if (setting.nudged) {
    const auto add = [wave = nudge(run.scene, nudge_)](SpaceFunction& velocity, double begin) {
      velocity = [own = velocity, wave, begin](double x) { return own(x) + wave(begin + x); };
    };
    add(run.scene.velocity, 0.0);
    double begin = 0.0;
    for (Member& member : run.scene.chain) add(member.velocity, std::exchange(begin, begin + member.bar.length));
  }
  return run;
}

std::size_t Plan::fewest_at(std::size_t elements) const {
  if (base_.scene.chain.empty()) return elements;
  Case run = base_;
  run.elements = elements;
  return fewest_in_a_bar(run);
}

std::size_t Plan::with_enough(std::size_t elements) const {
  while (fewest_at(elements) < 3 && elements < chosen_.elements) elements = std::min(2 * elements, chosen_.elements);
  return elements;
}

namespace {

// Impedance of the bar that an impulse moves most.
double least_impedance(const Scene& scene) {
  constexpr int looks = 200;
  double least = std::numeric_limits<double>::infinity();
  for (const SceneBar& one : scene_bars(scene))
    for (int k = 0; k <= looks; ++k)
      least = std::min(least, one.bar.impedance() * one.area(one.bar.length * k / looks));
  return least;
}

}  // namespace

Resolution Plan::resolution() const {
  Resolution resolution;
  resolution.impedance = least_impedance(base_.scene);
  const double share = 0.5 * requested_.value_or(0.0);
  switch (study_.request.of) {
    case Goal::displacement:
    case Goal::end_traces: resolution.height = share; break;
    case Goal::contact_times: resolution.duration = share; break;
    case Goal::impulse: resolution.height = share / resolution.impedance; break;
    case Goal::peak_reaction:
    case Goal::end_velocity: break;
  }
  return resolution;
}

double Plan::apart(const Setting& coarse, const Setting& fine) const {
  const auto compute = [&] { return difference(runs_.of(coarse), runs_.of(fine), study_.request.of, resolution()); };
  if (!is_field(study_.request.of)) return compute();
  const auto [place, unknown] = differences_.try_emplace({coarse, fine});
  return unknown ? place->second = compute() : place->second;
}

double Plan::aligned(const Setting& first, const Setting& second, const Setting& third) const {
  return alignment(runs_.of(first), runs_.of(second), runs_.of(third), study_.request.of, resolution());
}

Case Plan::next() {
  again_ = false;
  if (!waves_ && !piloted_ && !as_it_is_) {
    if (study_.message) study_.message("the error on coarse meshes");
    pilot();
    if (!study_.request.given.elements) climb();
  }
  const Case run = with(chosen_);
  if (!waves_) rungs_ = rungs(chosen_.elements, most_rungs);
  if (as_it_is_) return run;
  runs_.begin(wanted_by_judge());
  if (waves_) return run;
  if (study_.message)
    study_.message(fmt::format("{} on {} elements{}", name(run.method), run.elements,
                               stepping_     ? fmt::format(", step {:.2g}", *run.step)
                               : exact_time_ ? ""
                                             : fmt::format(", tolerance {:.2g}", run.tolerance.relative)));
  return run;
}

}  // namespace viscobar::accuracy

#include "studies/precision/references.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "case/massless.hpp"
#include "studies/parallel.hpp"
#include "viscobar/studies/orders/observed_order.hpp"

namespace viscobar::precision {

namespace {

// References may take this many times as long as a timed run: they are made once.
constexpr double longer = 20.0;

/// The penalised problem a decade closer to its limit, and the limit: epsilon = 0 where the contact nodes are massless,
/// epsilon / 100 where they have mass and epsilon = 0 is no system. A decade farther from it tells whether there is a
/// power.
System stiffer(System system) {
  system.epsilon /= 10.0;
  return system;
}
System softer(System system) {
  system.epsilon *= 10.0;
  return system;
}

System limit_of(const System& system, const Scene& scene) {
  if (are_massless(scene, system.mass)) return {system.elements, system.mass, System::Law::rigid, 0.0};
  return stiffer(stiffer(system));
}

bool penalised(const System& system) { return system.epsilon > 0.0; }

/// A tolerance a tenth of the row's, or a step a quarter of it; smaller still where that takes no long time, so that
/// few and coarse rows have a good reference, too.
double finer_than(const Timed& timed, double seconds) {
  constexpr double fine_tolerance = 2e-10, fine_parts = 1024.0;  // of the time that a wave takes through an element
  const bool scheme = is_scheme(timed.row.method);
  const Bar& bar = timed.run.scene.bar;
  const double enough = scheme ? timed.run.mesh().spacing() / bar.wave_speed() / fine_parts : fine_tolerance;
  // A decade of tolerance and half of a step both take about twice as long.
  double setting = timed.row.setting / (scheme ? 4.0 : 10.0), cost = timed.row.seconds * (scheme ? 7.0 : 2.0);
  for (; setting > enough && cost < 0.2 * seconds; cost *= 2.0) setting /= scheme ? 2.0 : 10.0;
  return setting;
}

/// The problems of the rows, each to be solved finer than the finest row of it.
std::map<System, Fineness> problems_of(std::span<const Timed> rows, double seconds, const Scene& scene) {
  using Finest = std::pair<double, double>;          // setting of a row, and that of its reference
  std::map<std::pair<System, bool>, Finest> finest;  // the latter: of schemes
  std::map<System, Fineness> problems;
  for (const Timed& timed : rows) {
    if (!timed.row.failure.empty()) continue;
    const bool scheme = is_scheme(timed.row.method);
    const System system = system_of(resolve(timed.run));
    Fineness& fineness = problems[system];
    if (!scheme && !is_adaptive(timed.row.method)) continue;
    const Finest own{timed.row.setting, finer_than(timed, seconds)};
    Finest& least = finest.try_emplace({system, scheme}, own).first->second;
    least = std::min(least, own);
    (scheme ? fineness.step : fineness.tolerance) = least.second;
  }
  for (const auto& [system, fineness] : std::map(problems))
    if (penalised(system)) {
      problems.try_emplace(softer(system), fineness);
      problems.try_emplace(stiffer(system), fineness);
      problems.try_emplace(limit_of(system, scene), fineness);
    }
  return problems;
}

}  // namespace

References::References(const PrecisionStudy& study, const Case& scene, std::span<const Mesh> meshes,
                       std::span<const Timed> rows) {
  const RunLimits limits{study.stop, longer * study.seconds};
  const auto problems = problems_of(rows, limits.seconds, scene.scene);
  const std::vector<std::pair<System, Fineness>> jobs(problems.begin(), problems.end());
  std::vector<SemiDiscrete> found(jobs.size());
  parallel_for(
      jobs.size() + 1,
      [&](std::size_t i) {
        if (i > 0) {
          found[i - 1] = solve_in_time(scene, jobs[i - 1].first, jobs[i - 1].second, limits);
          return;
        }
        Case exact = scene;
        exact.method = MethodName::characteristics;
        if (study.exact)
          continuous_ = closed_form(*study.exact, scene, meshes);
        else if (sound(exact))
          continuous_ = by_characteristics(scene, meshes, limits);
        else
          continuous_ = refine(
              scene, meshes, std::ranges::max(rows, {}, [](const Timed& one) { return one.row.elements; }).row.elements,
              limits);
      },
      study.threads);
  for (std::size_t i = 0; i < jobs.size(); ++i) solved_.emplace(jobs[i].first, std::move(found[i]));
}

const Field* References::exact(const Case& run) const {
  for (const Field& field : continuous_.fields)
    if (field.mesh.elements == run.mesh().elements) return &field;
  return nullptr;
}

const Field* References::field(const System& system) const {
  const auto found = solved_.find(system);
  return found != solved_.end() && found->second.field ? &*found->second.field : nullptr;
}

const Field* References::semi_discrete(const Case& run) const { return field(system_of(resolve(run))); }

ErrorParts References::parts(const Timed& timed) const {
  ErrorParts parts;
  parts.method = timed.row.method;
  parts.elements = timed.row.elements;
  parts.mass = timed.row.mass;
  const System own = system_of(resolve(timed.run));
  if (penalised(own)) parts.epsilon = own.epsilon;
  const auto found = solved_.find(own);
  parts.problem = found == solved_.end() ? "every run failed" : found->second.problem;
  if (!field(own)) return parts;
  parts.time_reference = found->second.what;
  parts.time_reference_error = found->second.error;
  const Field* exact_field = exact(timed.run);
  const auto measure_space = [&](const Field& limit) {
    if (exact_field) parts.space = largest_difference(limit, *exact_field);
  };
  if (!penalised(own)) {
    measure_space(*field(own));
  } else if (const auto limit = penalty_limit(own, timed.run.scene, parts)) {
    measure_space(*limit);
    parts.penalty = largest_difference(*field(own), *limit);
  }
  return parts;
}

std::optional<Field> References::penalty_limit(const System& own, const Scene& scene, ErrorParts& parts) const {
  const System end = limit_of(own, scene);
  const Field *soft = field(softer(own)), *here = field(own), *next = field(stiffer(own)), *last = field(end);
  if (!last && !next) {
    parts.problem = "what the penalty tends to was not found: " + solved_.at(end).problem;
    return std::nullopt;
  }
  if (!last) {
    parts.penalty_against = fmt::format("epsilon / 10 by {}, for the limit failed: {}", solved_.at(stiffer(own)).what,
                                        solved_.at(end).problem);
    return *next;
  }
  const bool rigid = end.law == System::Law::rigid;
  parts.penalty_against = solved_.at(end).what;
  if (!rigid) parts.penalty_against = fmt::format("epsilon / 100 by {}", parts.penalty_against);
  if (!next || !soft) return *last;
  // Differences to the limit itself fall with its power, and so do those between neighbours.
  Sequence differences;
  differences.within = Sequence::by_few;
  differences.add(10.0, largest_difference(*soft, rigid ? *last : *here), parts.time_reference_error);
  differences.add(1.0, largest_difference(*here, rigid ? *last : *next), parts.time_reference_error);
  differences.add(0.1, largest_difference(*next, *last), parts.time_reference_error);
  const auto order = differences.order();
  if (!order) return *last;
  parts.penalty_order = order->order;
  // The rest of the power law from epsilon / 100 to 0 would else count as error of space.
  constexpr double least_order = 0.4, greatest_order = 1.5;
  if (rigid || *parts.penalty_order < least_order || *parts.penalty_order > greatest_order) return *last;
  parts.penalty_against += ", extrapolated";
  return extrapolated(*last, *next, std::pow(10.0, *parts.penalty_order));
}

}  // namespace viscobar::precision

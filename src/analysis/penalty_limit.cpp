#include "viscobar/analysis/penalty_limit.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "viscobar/analysis/comparison.hpp"
#include "viscobar/analysis/parallel.hpp"
#include "viscobar/analysis/recording.hpp"

namespace viscobar {

std::string_view name(Verdict verdict) { return verdict == Verdict::converges ? "converges" : "plateau"; }

std::vector<double> decades(double first, double last, std::size_t per_decade) {
  std::vector<double> values;
  const double count = std::round(std::log10(first / last) * static_cast<double>(per_decade));
  for (double k = 0.0; k <= count; ++k) values.push_back(first * std::pow(10.0, -k / static_cast<double>(per_decade)));
  return values;
}

double scheme_step(const Case& run) {
  if (run.step) return *run.step;
  return run.mesh().spacing() / (100.0 * std::sqrt(run.scene.bar.modulus / run.scene.bar.density));
}

namespace {

// Differences are taken at these times, many enough that none of a contact is missed.
constexpr double comparison_points = 2000.0;

bool has_obstacle(const Scene& scene) { return is_obstacle(scene.left) || is_obstacle(scene.right) || scene.span; }

Case sound(Case run) {
  const std::vector<Finding> findings = validate(run);
  if (!findings.empty()) throw std::invalid_argument(fmt::format("{}: {}", findings[0].key, findings[0].problem));
  return run;
}

Case penalised_case(const LimitStudy& study, std::size_t elements, double epsilon) {
  Case run = study.scene;
  run.elements = elements;
  run.epsilon = epsilon;
  if (!is_penalised(run.method)) run.method = MethodName::cvode;
  const bool algebraic = run.mass == Mass::redistributed && run.scene.bar.viscosity == 0.0;
  const bool differential = run.method == MethodName::cvode || run.method == MethodName::odeint;
  if (differential && algebraic) run.method = MethodName::ida;
  run.tolerance.relative = std::min(run.tolerance.relative, 1e-10);
  run.tolerance.absolute = std::min(run.tolerance.absolute, 1e-13);
  run.output_every = run.end / comparison_points;
  return sound(std::move(run));
}

Case scheme_case(const LimitStudy& study, std::size_t elements, double step) {
  Case run = penalised_case(study, elements, study.epsilons.front());
  run.method = MethodName::fully_discrete;
  run.step = step;
  return sound(std::move(run));
}

Case rigid_case(const LimitStudy& study, std::size_t elements) {
  Case run = penalised_case(study, elements, study.epsilons.front());
  run.method = MethodName::rigid;
  return sound(std::move(run));
}

double largest_displacement(const Recording& recording) {
  double largest = 0.0;
  for (double u : recording.u) largest = std::max(largest, std::abs(u));
  return largest;
}

template <class Value>
std::optional<ObservedOrder> fit(std::span<const LimitRow> rows, Value value, double floor, double epsilon_low = 0.0,
                                 double epsilon_high = std::numeric_limits<double>::infinity()) {
  std::vector<double> x, y;
  for (const LimitRow& row : rows) {
    const std::optional<double> v = value(row);
    if (!v || *v <= floor || row.epsilon < epsilon_low || row.epsilon > epsilon_high) continue;
    x.push_back(row.epsilon);
    y.push_back(*v);
  }
  return observed_order(x, y);
}

// The difference has stopped falling when the last two decades (or what there is) took less than a factor 10^(1/4) a
// decade from it, and it is still above what the scheme's own step accounts for.
Verdict judge(std::span<const LimitRow> rows, double floor) {
  const LimitRow& last = rows.back();
  if (last.difference_to_scheme <= floor) return Verdict::converges;
  const LimitRow* earlier = &rows.front();
  for (const LimitRow& row : rows)
    if (row.epsilon >= 99.0 * last.epsilon) earlier = &row;
  if (earlier == &last) return Verdict::plateau;
  const double spanned = std::log10(earlier->epsilon / last.epsilon);
  const double fallen = std::log10(earlier->difference_to_scheme / last.difference_to_scheme);
  return fallen >= 0.25 * spanned ? Verdict::converges : Verdict::plateau;
}

}  // namespace

LimitResult penalty_limit(const LimitStudy& study) {
  if (!has_obstacle(study.scene.scene)) throw std::invalid_argument("the scene has no obstacle to penalise");
  if (study.epsilons.empty()) throw std::invalid_argument("a limit study needs at least one epsilon");
  const std::vector<std::size_t> meshes =
      study.elements.empty() ? std::vector<std::size_t>{study.scene.elements} : study.elements;
  if (!study.steps.empty() && study.steps.size() != meshes.size())
    throw std::invalid_argument("one scheme step is needed for each mesh");
  const bool rigid = study.scene.mass == Mass::redistributed;

  // Per mesh: the scheme at dt and dt / 2, the rigid limit, then each epsilon. All independent.
  const std::size_t references = rigid ? 3 : 2, runs = references + study.epsilons.size();
  std::vector<Case> cases;
  for (std::size_t m = 0; m < meshes.size(); ++m) {
    Case probe = study.scene;
    probe.elements = meshes[m];
    const double step = study.steps.empty() ? scheme_step(probe) : study.steps[m];
    cases.push_back(scheme_case(study, meshes[m], step));
    cases.push_back(scheme_case(study, meshes[m], step / 2));
    if (rigid) cases.push_back(rigid_case(study, meshes[m]));
    for (const double epsilon : study.epsilons) cases.push_back(penalised_case(study, meshes[m], epsilon));
  }
  std::vector<Recording> recordings(cases.size());
  parallel_for(
      cases.size(), [&](std::size_t i) { recordings[i] = record(Case(cases[i])); }, study.threads);

  LimitResult result;
  for (std::size_t m = 0; m < meshes.size(); ++m) {
    const Recording& scheme = recordings[m * runs];
    LimitOrders orders;
    orders.elements = meshes[m];
    orders.scheme_step = *cases[m * runs].step;
    orders.scheme_error = 2.0 * compare(scheme, recordings[m * runs + 1]).end_trace;
    orders.scheme_events = scheme.events.size();
    orders.tolerance_error = 100.0 * cases[m * runs].tolerance.relative * largest_displacement(scheme);
    const Bar& bar = study.scene.scene.bar;
    const double h = cases[m * runs].mesh().spacing();
    // zeta ~ 1 of a contact node (model section 6), in any units.
    if (bar.viscosity > 0.0) orders.boundary = bar.density * h * h * h / (bar.viscosity * bar.viscosity);
    const std::size_t first = result.rows.size();
    for (std::size_t k = 0; k < study.epsilons.size(); ++k) {
      const Recording& run = recordings[m * runs + references + k];
      LimitRow row;
      row.epsilon = study.epsilons[k];
      row.elements = meshes[m];
      row.mass = study.scene.mass;
      row.events = run.events.size();
      row.max_penetration = run.statistics.max_penetration;
      row.difference_to_scheme = compare(run, scheme).end_trace;
      if (rigid) row.difference_to_rigid = compare(run, recordings[m * runs + 2]).end_trace;
      row.steps = run.statistics.steps;
      row.seconds = run.statistics.integration_seconds;
      result.rows.push_back(row);
    }
    const std::span<const LimitRow> rows = std::span(result.rows).subspan(first);
    const double floor = 3.0 * orders.scheme_error + orders.tolerance_error;
    const auto small = [&](auto value, double lowest) {
      const auto order = orders.boundary ? fit(rows, value, lowest, 0.0, 0.01 * *orders.boundary) : std::nullopt;
      return order ? order : fit(rows, value, lowest);
    };
    const auto penetration = [](const LimitRow& row) { return std::optional(row.max_penetration); };
    const auto to_rigid = [](const LimitRow& row) { return row.difference_to_rigid; };
    const auto to_scheme = [](const LimitRow& row) { return std::optional(row.difference_to_scheme); };
    orders.penetration = small(penetration, 0.0);
    orders.to_rigid = small(to_rigid, orders.tolerance_error);
    orders.to_scheme = small(to_scheme, floor);
    if (orders.boundary) {
      orders.penetration_layer = fit(rows, penetration, 0.0, 100.0 * *orders.boundary);
      orders.to_rigid_layer = fit(rows, to_rigid, orders.tolerance_error, 100.0 * *orders.boundary);
    }
    orders.verdict = judge(rows, floor);
    result.orders.push_back(orders);
  }
  return result;
}

}  // namespace viscobar

#include "viscobar/analysis/penalty_limit.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <exception>
#include <limits>
#include <mutex>
#include <span>
#include <stdexcept>

#include "viscobar/analysis/end_traces.hpp"
#include "viscobar/analysis/parallel.hpp"

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

constexpr std::size_t comparison_intervals = 2000;

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
  run.method = penalised_method(run);
  run.tolerance.relative = std::min(run.tolerance.relative, 1e-10);
  run.tolerance.absolute = std::min(run.tolerance.absolute, 1e-13);
  run.output_every = run.end;
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

double largest_displacement(const EndTraces& traces) {
  double largest = 0.0;
  for (const double u : traces.left) largest = std::max(largest, std::abs(u));
  for (const double u : traces.right) largest = std::max(largest, std::abs(u));
  return largest;
}

// The power in the values between two epsilons that lie above a floor; those within `range` of the smallest epsilon of
// them, where the power is closest to its limit.
template <class Value>
std::optional<ObservedOrder> fit(std::span<const LimitRow> rows, Value value, double floor, double epsilon_low,
                                 double epsilon_high, double range) {
  std::vector<double> x, y;
  for (const LimitRow& row : rows) {
    const std::optional<double> v = value(row);
    if (!v || *v <= floor || row.epsilon < epsilon_low || row.epsilon > epsilon_high) continue;
    x.push_back(row.epsilon);
    y.push_back(*v);
  }
  std::size_t first = 0;
  while (first < x.size() && x[first] > 1.01 * range * x.back()) ++first;
  return observed_order(std::span(x).subspan(first), std::span(y).subspan(first));
}

// The difference has stopped falling when the last two decades (or what there is) took less than a factor 10^(1/4) a
// decade from it, and it is still above what the scheme's own step accounts for.
std::optional<Verdict> judge(std::span<const LimitRow> rows, double floor) {
  const LimitRow& last = rows.back();
  if (last.difference_to_scheme <= floor) return Verdict::converges;
  const LimitRow* earlier = &rows.front();
  for (const LimitRow& row : rows)
    if (row.epsilon >= 99.0 * last.epsilon) earlier = &row;
  if (earlier == &last) return std::nullopt;
  const double spanned = std::log10(earlier->epsilon / last.epsilon);
  const double fallen = std::log10(earlier->difference_to_scheme / last.difference_to_scheme);
  return fallen >= 0.25 * spanned ? Verdict::converges : Verdict::plateau;
}

// The runs of one mesh: the scheme at dt and dt / 2, the rigid limit where there is one, and each epsilon.
struct MeshRuns {
  std::vector<Case> cases;
  std::vector<EndTraces> traces;
  std::vector<std::exception_ptr> errors;
  std::size_t references = 2;

  bool has_rigid() const { return references == 3; }
  const EndTraces& scheme() const { return traces[0]; }
  const EndTraces& finer_scheme() const { return traces[1]; }
  const EndTraces& rigid() const { return traces[2]; }
};

MeshRuns runs_of(const LimitStudy& study, std::size_t elements, double step) {
  MeshRuns runs;
  runs.cases.push_back(scheme_case(study, elements, step));
  runs.cases.push_back(scheme_case(study, elements, step / 2));
  if (study.scene.mass == Mass::redistributed) runs.cases.push_back(rigid_case(study, elements));
  runs.references = runs.cases.size();
  for (const double epsilon : study.epsilons) runs.cases.push_back(penalised_case(study, elements, epsilon));
  runs.traces.resize(runs.cases.size());
  runs.errors.resize(runs.cases.size());
  return runs;
}

// All runs of all meshes, independent, in two passes: where contacts change, then the traces on times that show it.
void carry_out(std::vector<MeshRuns>& meshes, const LimitStudy& study) {
  struct Task {
    MeshRuns* mesh;
    std::size_t run;
  };
  std::vector<Task> tasks;
  for (MeshRuns& mesh : meshes)
    for (std::size_t i = 0; i < mesh.cases.size(); ++i) tasks.push_back({&mesh, i});
  std::mutex mutex;
  std::size_t done = 0;
  const std::size_t all = 2 * tasks.size();
  const auto each = [&](const auto& work) {
    parallel_for(
        tasks.size(),
        [&](std::size_t k) {
          const auto [mesh, i] = tasks[k];
          std::exception_ptr& error = mesh->errors[i];
          try {
            if (!error) work(*mesh, i);
          } catch (const IntegrationError&) {
            error = std::current_exception();
          }
          const std::lock_guard lock(mutex);
          if (study.progress) study.progress(++done, all);
        },
        study.threads);
  };
  each([](MeshRuns& mesh, std::size_t i) {
    // A scheme's contacts change where those of its partners do.
    if (i >= 2) mesh.traces[i].events = contact_changes(mesh.cases[i]);
  });
  std::vector<std::vector<double>> times;
  for (const MeshRuns& mesh : meshes) {
    std::vector<Event> changes;
    for (const EndTraces& trace : mesh.traces) changes.insert(changes.end(), trace.events.begin(), trace.events.end());
    times.push_back(comparison_times(study.scene.end, comparison_intervals, changes));
  }
  each([&](MeshRuns& mesh, std::size_t i) {
    mesh.traces[i] = trace_ends(mesh.cases[i], times[static_cast<std::size_t>(&mesh - meshes.data())]);
  });
  for (const MeshRuns& mesh : meshes) {
    const auto of_penalised = mesh.errors.begin() + static_cast<std::ptrdiff_t>(mesh.references);
    for (auto error = mesh.errors.begin(); error != of_penalised; ++error)
      if (*error) std::rethrow_exception(*error);
    if (std::all_of(of_penalised, mesh.errors.end(), [](const auto& error) { return error != nullptr; }))
      std::rethrow_exception(*of_penalised);
  }
}

std::string text_of(const std::exception_ptr& error) {
  try {
    std::rethrow_exception(error);
  } catch (const std::exception& known) {
    return known.what();
  }
}

void tabulate(const MeshRuns& mesh, LimitResult& result) {
  for (std::size_t i = mesh.references; i < mesh.cases.size(); ++i) {
    const Case& run = mesh.cases[i];
    if (mesh.errors[i]) {
      result.failed.push_back({*run.epsilon, run.elements, text_of(mesh.errors[i])});
      continue;
    }
    const EndTraces& traces = mesh.traces[i];
    LimitRow row;
    row.epsilon = *run.epsilon;
    row.elements = run.elements;
    row.mass = run.mass;
    row.events = traces.events.size();
    row.max_penetration = traces.statistics.max_penetration;
    row.difference_to_scheme = largest_difference(traces, mesh.scheme());
    if (mesh.has_rigid()) row.difference_to_rigid = largest_difference(traces, mesh.rigid());
    row.steps = traces.statistics.steps;
    row.seconds = traces.statistics.integration_seconds;
    result.rows.push_back(row);
  }
}

LimitOrders orders_of(const MeshRuns& mesh, std::span<const LimitRow> rows) {
  LimitOrders orders;
  const Case& scheme = mesh.cases[0];
  const Bar& bar = scheme.scene.bar;
  orders.elements = scheme.elements;
  orders.scheme_step = *scheme.step;
  orders.scheme_error = 2.0 * largest_difference(mesh.scheme(), mesh.finer_scheme());
  orders.scheme_events = mesh.scheme().events.size();
  orders.tolerance_error = 100.0 * scheme.tolerance.relative * largest_displacement(mesh.scheme());
  const double h = scheme.mesh().smallest();  // of the contact nodes
  const bool span = scheme.scene.span.has_value();
  // zeta ~ 1 of an end node on its spring 1 / epsilon; under a span the spring is h / epsilon.
  if (bar.viscosity > 0.0)
    orders.boundary = bar.density * h * h * h * (span ? h : 1.0) / (bar.viscosity * bar.viscosity);
  const double floor = 3.0 * orders.scheme_error + orders.tolerance_error;
  constexpr double every = std::numeric_limits<double>::infinity(), two_decades = 100.0;
  const auto small = [&](auto value, double lowest) {
    const auto order =
        orders.boundary ? fit(rows, value, lowest, 0.0, 0.01 * *orders.boundary, two_decades) : std::nullopt;
    return order ? order : fit(rows, value, lowest, 0.0, every, two_decades);
  };
  const auto penetration = [](const LimitRow& row) { return std::optional(row.max_penetration); };
  const auto to_rigid = [](const LimitRow& row) { return row.difference_to_rigid; };
  const auto to_scheme = [](const LimitRow& row) { return std::optional(row.difference_to_scheme); };
  orders.penetration = small(penetration, 0.0);
  orders.to_rigid = small(to_rigid, orders.tolerance_error);
  orders.to_scheme = small(to_scheme, floor);
  if (orders.boundary && !span) {
    orders.penetration_layer = fit(rows, penetration, 0.0, 100.0 * *orders.boundary, every, two_decades);
    orders.to_rigid_layer = fit(rows, to_rigid, orders.tolerance_error, 100.0 * *orders.boundary, every, two_decades);
  }
  orders.verdict = judge(rows, floor);
  return orders;
}

}  // namespace

LimitResult penalty_limit(const LimitStudy& study) {
  if (!has_obstacle(study.scene.scene)) throw std::invalid_argument("the scene has no obstacle to penalise");
  if (study.epsilons.empty()) throw std::invalid_argument("a limit study needs at least one epsilon");
  const std::vector<std::size_t> meshes =
      study.elements.empty() ? std::vector<std::size_t>{study.scene.elements} : study.elements;
  if (!study.steps.empty() && study.steps.size() != meshes.size())
    throw std::invalid_argument("one scheme step is needed for each mesh");

  std::vector<MeshRuns> runs;
  for (std::size_t m = 0; m < meshes.size(); ++m) {
    Case probe = study.scene;
    probe.elements = meshes[m];
    runs.push_back(runs_of(study, meshes[m], study.steps.empty() ? scheme_step(probe) : study.steps[m]));
  }
  carry_out(runs, study);

  LimitResult result;
  for (const MeshRuns& mesh : runs) {
    const std::size_t first = result.rows.size();
    tabulate(mesh, result);
    LimitOrders orders = orders_of(mesh, std::span(result.rows).subspan(first));
    orders.first_row = first;
    orders.row_count = result.rows.size() - first;
    result.orders.push_back(orders);
  }
  return result;
}

}  // namespace viscobar

#include "viscobar/studies/limit/limit.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <exception>
#include <limits>
#include <span>
#include <stdexcept>

#include "studies/limit/mesh_runs.hpp"
#include "studies/parallel.hpp"

namespace viscobar {

using namespace limit;

std::vector<double> decades(double first, double last, std::size_t per_decade) {
  std::vector<double> values;
  const double count = std::round(std::log10(first / last) * static_cast<double>(per_decade));
  for (double k = 0.0; k <= count; ++k) values.push_back(first * std::pow(10.0, -k / static_cast<double>(per_decade)));
  return values;
}

std::vector<double> natural_penalties(const Scene& scene, std::size_t per_decade) {
  const double unit = natural_epsilon(scene);
  return decades(1e-2 * unit, 1e-8 * unit, per_decade);
}

namespace {

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

/// Another law of impact, as far from the case's own as there is.
Case with_other_law(Case run) {
  run.directions.clear();
  run.restitution = run.restitution.value_or(1.0) > 0.5 ? 0.0 : 1.0;
  return run;
}

Case without_obstacles(Case run) {
  run.directions.clear();
  if (is_obstacle(run.scene.left)) run.scene.left = Free{};
  if (is_obstacle(run.scene.right)) run.scene.right = Free{};
  run.scene.span.reset();
  return run;
}

// Under a span obstacle neighbours meet it at once, and only a diagonal mass keeps their impacts apart.
bool one_law(const Case& run) {
  const bool apart = !run.scene.span || run.mass == Mass::lumped || run.mass == Mass::paper;
  return run.restitution.has_value() && apart;
}

double tolerance_error(const MeshRuns& mesh) {
  const Run& scheme = mesh.scheme.front();
  return 100.0 * scheme.run.tolerance.relative * largest_displacement(scheme.traces);
}

// The penalised runs that tell whether P(epsilon) settles: a decade apart where that leaves three, since what chatter
// does to the difference of two that are close hides its order.
std::vector<const Run*> telling(const std::vector<Run>& penalised) {
  std::vector<const Run*> all, apart;
  for (auto run = penalised.rbegin(); run != penalised.rend(); ++run) {
    if (run->error) continue;
    all.push_back(&*run);
    if (apart.empty() || *run->run.epsilon >= 9.99 * *apart.back()->run.epsilon) apart.push_back(&*run);
  }
  std::vector<const Run*>& chosen = apart.size() >= 3 ? apart : all;
  std::reverse(chosen.begin(), chosen.end());
  return chosen;
}

Judgement judge_mesh(MeshRuns& mesh, const LimitStudy& study, Progress& progress) {
  LimitTraces traces;
  std::vector<const Case*> cases;
  for (const Run* run : telling(mesh.penalised)) {
    traces.penalised.add(*run->run.epsilon, run->traces);
    cases.push_back(&run->run);
  }
  for (const Run& run : mesh.scheme) traces.scheme.add(*run.run.step, run.traces);
  if (mesh.rigid && massless(*mesh.rigid)) traces.rigid = mesh.rigid->traces;
  traces.one_law = one_law(study.scene);
  traces.floor = tolerance_error(mesh);
  const auto run_now = [&](Run& run) {
    progress.expect(1);
    run.trace(mesh.times);
    progress.done();
  };
  traces.other_law = [&] {
    if (mesh.other_law.empty()) {
      const std::size_t count = std::min<std::size_t>(4, cases.size());
      for (auto run = cases.end() - static_cast<std::ptrdiff_t>(count); run != cases.end(); ++run)
        mesh.other_law.push_back({with_other_law(**run)});
      for (Run& run : mesh.other_law) run.attempt([&] { run_now(run); });
    }
    TraceSequence sequence;
    for (const Run& run : mesh.other_law)
      if (!run.error) sequence.add(*run.run.epsilon, run.traces);
    return sequence;
  };
  traces.without_obstacles = [&]() -> const EndTraces& {
    if (!mesh.without_obstacles) {
      mesh.without_obstacles = Run{without_obstacles(*cases.back())};
      run_now(*mesh.without_obstacles);
    }
    return mesh.without_obstacles->traces;
  };
  return judge(traces);
}

// Smaller steps of the scheme until the verdict is known, nothing more can be learnt from them, or the next would
// exceed the budget.
void decide(std::vector<MeshRuns>& meshes, const LimitStudy& study, Progress& progress) {
  std::atomic<double> spent = 0.0;
  parallel_for(
      meshes.size(),
      [&](std::size_t m) {
        MeshRuns& mesh = meshes[m];
        for (;;) {
          mesh.judgement = judge_mesh(mesh, study, progress);
          if (mesh.judgement.evidence.lack != Lack::smaller_step) return;
          const Run& last = mesh.scheme.back();
          if (spent + scheme_refinement * last.seconds > study.budget) return;
          Run next{scheme_case(study, last.run.elements, mesh.step() / scheme_refinement)};
          progress.expect(1);
          // Else the verdict stays undecided, with the smallest step that ran.
          if (!next.attempt([&] { next.trace(mesh.times); })) return;
          spent += next.seconds;
          mesh.scheme.push_back(std::move(next));
          progress.done();
        }
      },
      study.threads);
}

std::string text_of(const std::exception_ptr& error) {
  try {
    std::rethrow_exception(error);
  } catch (const std::exception& known) {
    return known.what();
  }
}

void tabulate(const MeshRuns& mesh, LimitResult& result) {
  for (const Run& penalised : mesh.penalised) {
    const Case& run = penalised.run;
    if (penalised.error) {
      result.failed.push_back({*run.epsilon, run.elements, text_of(penalised.error)});
      continue;
    }
    const EndTraces& traces = penalised.traces;
    LimitRow row;
    row.epsilon = *run.epsilon;
    row.elements = run.elements;
    row.mass = effective_mass(run);
    row.events = traces.events.size();
    row.max_penetration = traces.statistics.max_penetration;
    row.difference_to_scheme = largest_difference(traces, mesh.scheme.back().traces);
    if (mesh.rigid && !mesh.rigid->error) row.difference_to_rigid = largest_difference(traces, mesh.rigid->traces);
    row.steps = traces.statistics.steps;
    row.seconds = traces.statistics.integration_seconds;
    result.rows.push_back(row);
  }
}

// What the penalised runs tend to, or the last of them.
const Run& limit_of_penalty(const MeshRuns& mesh) {
  if (mesh.rigid && !mesh.rigid->error && (massless(*mesh.rigid) || one_law(mesh.rigid->run))) return *mesh.rigid;
  return *std::find_if(mesh.penalised.rbegin(), mesh.penalised.rend(), [](const Run& run) { return !run.error; });
}

LimitOrders orders_of(const MeshRuns& mesh, std::span<const LimitRow> rows) {
  LimitOrders orders;
  const Case& scheme = mesh.scheme.back().run;
  const Bar& bar = scheme.scene.bar;
  orders.elements = scheme.elements;
  orders.scheme_step = *scheme.step;
  orders.scheme_error = mesh.judgement.scheme_error;
  orders.scheme_events = mesh.scheme.back().traces.events.size();
  for (std::size_t i = 0; i < mesh.scheme.size(); ++i) {
    const Run& run = mesh.scheme[i];
    orders.scheme.push_back({*run.run.step, i > 0 ? largest_difference(run.traces, mesh.scheme[i - 1].traces) : 0.0,
                             run.traces.events.size(), run.seconds});
  }
  orders.tolerance_error = tolerance_error(mesh);
  orders.verdict = mesh.judgement.verdict;
  orders.evidence = mesh.judgement.evidence;
  const double h = scheme.mesh().smallest();  // of the contact nodes
  const bool span = scheme.scene.span.has_value();
  // zeta ~ 1 of an end node on its spring 1 / epsilon; under a span the spring is h / epsilon.
  if (bar.viscosity > 0.0)
    orders.boundary = bar.density * h * h * h * (span ? h : 1.0) / (bar.viscosity * bar.viscosity);
  // Below it a difference is mostly the scheme's own error.
  const double floor = 1.5 * orders.evidence.scheme_error.value_or(orders.scheme_error) + orders.tolerance_error;
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
  return orders;
}

}  // namespace

LimitResult limit_of(const LimitStudy& study) {
  if (!meets_obstacle(study.scene.scene)) throw std::invalid_argument("the scene has no obstacle to penalise");
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
  Progress progress(study);
  carry_out(runs, study, progress);
  decide(runs, study, progress);

  LimitResult result;
  for (const MeshRuns& mesh : runs) {
    const std::size_t first = result.rows.size();
    tabulate(mesh, result);
    LimitOrders orders = orders_of(mesh, std::span(result.rows).subspan(first));
    orders.first_row = first;
    orders.row_count = result.rows.size() - first;
    if (study.derivatives) {
      const Run& limit = limit_of_penalty(mesh);
      orders.local_to_rigid = limit.run.method == MethodName::rigid;
      add_local_powers(mesh, limit.traces, orders.tolerance_error, std::span(result.rows).subspan(first));
    }
    result.orders.push_back(orders);
  }
  return result;
}

AccuracyResult limit_to_accuracy(const LimitStudy& study, const AccuracyRequest& request) {
  AccuracyStudy inner;
  inner.scene = study.scene;
  inner.scene.mass = common_mass(study.scene);
  inner.scene.method = MethodName::rigid;
  if (!validate(inner.scene).empty()) inner.scene.method = MethodName::fully_discrete;
  inner.request = request;
  inner.request.given.method = inner.request.given.mass = inner.request.given.restitution = true;
  inner.request.given.tolerance = inner.request.given.step = false;
  inner.threads = study.threads;
  return solve(inner);
}

}  // namespace viscobar

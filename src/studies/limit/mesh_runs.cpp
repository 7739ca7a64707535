#include "studies/limit/mesh_runs.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "case/massless.hpp"
#include "case/method_table.hpp"
#include "run/stopwatch.hpp"
#include "studies/accuracy/sample.hpp"
#include "studies/parallel.hpp"
#include "studies/run_limits.hpp"

namespace viscobar::limit {

namespace {

constexpr double of_limits = 100.0;  // between the two tolerances that tell a limit's error
// Shares of a budget: for the runs that tell when contacts change, and for the steps of the rows that were asked for,
// which take a third of their time; the rest is for their contacts and traces.
constexpr double part_of_scouts = 1.0 / 60.0, part_of_rows = 1.0 / 24.0;

Case checked(Case run) {
  if (const auto fault = fault_in_words(resolve(run))) throw std::invalid_argument(*fault);
  return run;
}

// Tight where that costs little of the budget: the distances of seven decades are told by one tolerance then. Runs of
// all penalties take as many steps as the longest scout, of fourth or fifth order. Steps are counted, not timed, so
// that the same study has the same rows.
double tolerance_of(const LimitStudy& study, const Case& row, std::size_t steps, double at) {
  const double seconds = static_cast<double>((study.epsilons.size() + 1) * steps) * step_seconds(row);
  const double own = study.scene.tolerance.relative;
  for (const double relative : {1e-10, 1e-8, 1e-7})
    if (relative <= own &&
        (study.budget == 0.0 || seconds * std::pow(at / relative, 0.2) <= part_of_rows * study.budget))
      return relative;
  return own;
}

// The motion has waves of the length of an element.
std::size_t intervals(const Case& run) {
  const double transits = run.end * run.scene.bar.wave_speed() / run.mesh().smallest();
  return static_cast<std::size_t>(std::clamp(2.0 * transits, 2000.0, 20000.0));
}

void set_tolerance(Run& run, double relative) { run.run.tolerance = run.run.tolerance.with_relative(relative); }

std::optional<KnownLimit> limit_of(Case run, std::optional<double> restitution) {
  run.method = MethodName::rigid;
  run.restitution = restitution;
  if (!sound(run)) return std::nullopt;
  return KnownLimit{{run}, {run}};
}

void each(const auto& runs, const LimitStudy& study, Purse& purse, const auto& work) {
  purse.expect(runs.size());
  parallel_for(
      runs.size(),
      [&](std::size_t k) {
        if (!purse.empty()) work(*runs[k]);
        purse.done();
      },
      study.threads);
}

}  // namespace

const double scheme_refinement = std::cbrt(10.0);

double step_seconds(const Case& run) {
  const StepSeconds cost = method_row(run.method).seconds;
  return cost.step + cost.node * static_cast<double>(run.mesh().nodes());
}

bool Run::trace(std::span<const double> times, Purse& purse) {
  if (error) return false;
  const unsigned seldom = run.elements < 1000 ? 128 : 1;  // looking at the clock takes as long as a short step
  const Stopwatch watch;  // the runs that a budget allows do not depend on other load of the machine
  seconds = 0.0;
  unsigned calls = 0;
  const auto spend = [&] {
    const double before = std::exchange(seconds, watch.seconds());
    purse.spend(seconds - before);
  };
  try {
    traces = trace_ends(run, times, [&](double) {
      if (purse.interrupted()) return RunControl::stop;
      if (++calls % seldom != 0) return RunControl::go_on;
      spend();
      return purse.empty() ? RunControl::stop : RunControl::go_on;
    });
    complete = traces.statistics.completed;
  } catch (const IntegrationError& failed) {
    error = failed;
  }
  spend();
  return complete;
}

double limit_error(const EndTraces& run, const EndTraces& rough) {
  return largest_difference(run, rough) + 1e-14 * largest_displacement(run);
}

LimitStudy by_one_factor(LimitStudy study) {
  if (auto meshes = accuracy::refine_by_one_factor(study.scene, study.elements)) study.elements = std::move(*meshes);
  return study;
}

EndTraces beginning_of(const EndTraces& traces, std::span<const double> times, double until) {
  EndTraces part = traces;
  const auto count = std::ranges::upper_bound(times, until) - times.begin();
  for (auto* trace : EndTraces::all(part)) trace->resize(static_cast<std::size_t>(count));
  std::erase_if(part.events, [&](const Event& change) { return change.time > until; });
  if (part.events.empty() && !traces.events.empty()) part.statistics.max_penetration = 0.0;
  return part;
}

Case penalised_case(const LimitStudy& study, std::size_t elements, double epsilon) {
  Case run = study.scene;
  run.directions.clear();
  run.elements = elements;
  run.epsilon = epsilon;
  run.method = penalised_method(run);
  run.mass = resolve(run).mass;  // of all partners
  run.output_every = run.end;
  return checked(std::move(run));
}

Case scheme_case(const LimitStudy& study, std::size_t elements, double step) {
  Case run = penalised_case(study, elements, study.epsilons.front());
  run.method = MethodName::fully_discrete;
  run.step = step;
  return checked(std::move(run));
}

MeshRuns runs_of(const LimitStudy& study, std::size_t elements, double step, Purse& purse) {
  MeshRuns mesh;
  const Case first = penalised_case(study, elements, study.epsilons.front());
  const bool massless = are_massless(first.scene, resolve(first).mass);
  mesh.one_limit = massless || study.scene.restitution.has_value();
  mesh.of_scheme = limit_of(first, study.scene.restitution);
  // An undamped spring throws a node back with the speed of its arrival.
  if (mesh.of_scheme && !mesh.one_limit) mesh.of_penalty = limit_of(first, 1.0);
  for (const double factor : {scheme_refinement * scheme_refinement, scheme_refinement, 1.0})
    mesh.scheme.push_back({scheme_case(study, elements, factor * step)});
  for (const double epsilon : study.epsilons) mesh.penalised.push_back(Run{penalised_case(study, elements, epsilon)});

  std::vector<KnownLimit*> limits;
  for (auto* limit : {&mesh.of_scheme, &mesh.of_penalty})
    if (*limit) limits.push_back(&**limit);
  // Scouts tell where contacts change, and what a run costs.
  const double roughest = std::min(of_limits * first.tolerance.relative, 1e-4);
  std::deque<Run> of_rows;
  std::vector<Run*> scouts;
  for (KnownLimit* limit : limits) scouts.push_back(&limit->rough);
  if (limits.empty())
    for (const Run& run : mesh.penalised) scouts.push_back(&of_rows.emplace_back(Run{run.run}));
  else
    for (Run* scout : scouts) set_tolerance(*scout, roughest);
  const std::array all{0.0, first.end};
  const double begun = purse.spent();
  each(scouts, study, purse, [&](Run& run) {
    if (study.budget == 0.0 || purse.spent() - begun <= part_of_scouts * study.budget) run.trace(all, purse);
  });
  std::size_t most_steps = 0;
  bool scouted = true;
  for (Run* run : scouts) {
    most_steps = std::max(most_steps, run->traces.statistics.steps);
    scouted &= std::exchange(run->complete, false);
  }
  const double tolerance = scouted ? tolerance_of(study, first, most_steps, scouts.front()->run.tolerance.relative)
                                   : first.tolerance.relative;
  for (Run& run : mesh.penalised) set_tolerance(run, tolerance);
  std::vector<Run*> again;  // a bounce is over before a rough time of its impact
  for (KnownLimit* limit : limits) {
    // Chatter has the more bounces the tighter the tolerance: it begins with a rough one.
    const bool chatters = mesh.of_penalty && limit == &*mesh.of_penalty;
    set_tolerance(limit->run, chatters ? std::max(tolerance, 1e-9) : tolerance);
    set_tolerance(limit->rough, std::min(of_limits * limit->run.run.tolerance.relative, 1e-4));
    if (limit->rough.run.tolerance.relative < roughest) again.push_back(&limit->rough);
  }
  each(again, study, purse, [&](Run& run) { run.trace(all, purse); });
  std::vector<Event> changes;
  for (Run* run : scouts) {
    changes.insert(changes.end(), run->traces.events.begin(), run->traces.events.end());
    run->complete = false;
  }
  mesh.times = comparison_times(first.end, intervals(first), changes);

  each(limits, study, purse, [&](KnownLimit& limit) {
    if (limit.rough.trace(mesh.times, purse)) limit.run.trace(mesh.times, purse);
  });
  if (mesh.of_scheme && massless)
    for (const Run* run : {&mesh.of_scheme->rough, &mesh.of_scheme->run})
      if (run->error) throw *run->error;

  // The largest steps and penalties first: what they took tells what the next ones take.
  std::vector<Run*> runs;
  for (std::size_t k = 0; k < std::max(mesh.scheme.size(), mesh.penalised.size()); ++k) {
    if (k < mesh.scheme.size()) runs.push_back(&mesh.scheme[k]);
    if (k < mesh.penalised.size()) runs.push_back(&mesh.penalised[k]);
  }
  const double decides = 0.25 * study.budget;  // reserved for the verdict, once there is a row
  std::mutex mutex;
  double under_way = 0.0;  // expected time of the runs that have begun
  double next = limits.empty() ? 0.0 : limits.front()->run.seconds, last = next;
  each(runs, study, purse, [&](Run& run) {
    if (run.run.method == MethodName::fully_discrete) return void(run.trace(mesh.times, purse));
    double expected = 0.0;
    {
      const std::lock_guard lock(mutex);
      expected = next;
      if (!purse.allows(under_way + expected, true)) return;
      under_way += expected;
    }
    run.trace(mesh.times, purse);
    const std::lock_guard lock(mutex);
    under_way -= expected;
    if (!run.complete) return;
    purse.keep(decides);
    next = run.seconds * std::clamp(run.seconds / std::max(last, 1e-6), 1.0, 10.0);
    last = run.seconds;
    purse.tell(row_of(mesh, run));
  });
  purse.keep(0.0);
  for (const Run& run : mesh.scheme)
    if (run.error) throw *run.error;
  if (std::ranges::all_of(mesh.penalised, [](const Run& run) { return run.error.has_value(); }))
    throw *mesh.penalised.front().error;
  std::erase_if(mesh.scheme, [](const Run& run) { return !run.complete; });
  return mesh;
}

bool tighten(MeshRuns& mesh, Purse& purse) {
  bool changed = false;
  for (auto* limit : {&mesh.of_scheme, &mesh.of_penalty}) {
    if (!*limit || !(*limit)->known() || (*limit)->run.run.tolerance.relative <= 1e-12) continue;
    const double grows = std::max(1.0, (*limit)->run.seconds / std::max((*limit)->rough.seconds, 1e-6));
    if (!purse.allows(grows * (*limit)->run.seconds, false)) {
      mesh.lacking_seconds = grows * (*limit)->run.seconds;
      continue;
    }
    KnownLimit next{.run = {(*limit)->run.run}, .rough = (*limit)->run};
    set_tolerance(next.run, std::max(1e-13, next.run.run.tolerance.relative / of_limits));
    if (!next.run.trace_one_more(mesh.times, purse)) continue;
    *limit = std::move(next);
    changed = true;
  }
  return changed;
}

LimitRow row_of(const MeshRuns& mesh, const Run& penalised) {
  const Case& run = penalised.run;
  const EndTraces& traces = penalised.traces;
  LimitRow row;
  row.epsilon = *run.epsilon;
  row.elements = run.elements;
  row.mass = *run.mass;
  row.tolerance = run.tolerance.relative;
  row.events = traces.events.size();
  row.max_penetration = traces.statistics.max_penetration;
  if (const KnownLimit* limit = mesh.scheme_limit())
    row.difference_to_scheme_limit = largest_difference(traces, limit->run.traces);
  if (const KnownLimit* limit = mesh.own_limit())
    row.difference_to_own_limit = largest_difference(traces, limit->run.traces);
  row.steps = traces.statistics.steps;
  row.seconds = traces.statistics.integration_seconds;
  return row;
}

}  // namespace viscobar::limit

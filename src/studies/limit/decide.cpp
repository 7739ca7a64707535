// The runs that a mesh of a study still needs until its verdict is known.
#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <utility>

#include "case/regime.hpp"
#include "studies/limit/mesh_runs.hpp"

namespace viscobar::limit {

std::optional<double> boundary_of(const Case& run) {
  const double h = run.mesh().smallest(), eta = run.scene.bar.viscosity;  // of the contact nodes
  if (!(eta > 0.0) || !run.scene.chain.empty()) return std::nullopt;      // each joint has its own
  return run.scene.bar.density * h * h * h * (run.scene.span ? h : 1.0) / (eta * eta * largest_end(run.scene));
}

double tolerance_error(const MeshRuns& mesh) {
  for (const auto* runs : {&mesh.penalised, &mesh.scheme})
    for (const Run& run : *runs)
      if (run.complete) return 100.0 * run.run.tolerance.relative * largest_displacement(run.traces);
  return 0.0;
}

namespace {

/// Another law of impact, as far from the case's own as there is.
Case with_other_law(Case run) {
  run.restitution = run.restitution.value_or(1.0) > 0.5 ? 0.0 : 1.0;
  return run;
}

Case without_obstacles(Case run) {
  if (is_obstacle(run.scene.left)) run.scene.left = Free{};
  if (is_obstacle(run.scene.right)) run.scene.right = Free{};
  run.scene.span.reset();
  for (Member& member : run.scene.chain)
    if (member.joint.kind == JointKind::contact) member.joint = {.kind = JointKind::spring};  // of no stiffness
  return run;
}

// Under a span obstacle neighbours meet it at once, and only a diagonal mass keeps their impacts apart.
bool one_law(const Case& run) {
  const bool apart = !run.scene.span || run.mass == Mass::lumped || run.mass == Mass::paper;
  return run.restitution.has_value() && apart;
}

// The penalised runs that tell whether P(epsilon) settles: a decade apart where that leaves three, since what chatter
// does to the difference of two that are close hides its order.
std::vector<const Run*> telling(const MeshRuns& mesh) {
  std::vector<const Run*> all, apart;
  for (auto run = mesh.penalised.rbegin(); run != mesh.penalised.rend(); ++run) {
    if (!run->complete) continue;
    all.push_back(&*run);
    if (apart.empty() || *run->run.epsilon >= 9.99 * *apart.back()->run.epsilon) apart.push_back(&*run);
  }
  std::vector<const Run*>& chosen = apart.size() >= 3 ? apart : all;
  std::reverse(chosen.begin(), chosen.end());
  return chosen;
}

// By the whole run, or by its beginning.
Judgement judge_mesh(MeshRuns& mesh, const LimitStudy& study, Purse& purse, std::optional<double> until = {}) {
  LimitTraces traces;
  const std::vector<const Run*> told = telling(mesh);
  std::deque<EndTraces> beginnings;
  const auto seen = [&](const EndTraces& all) -> const EndTraces& {
    return until ? beginnings.emplace_back(beginning_of(all, mesh.times, *until)) : all;
  };
  for (const Run* run : told) traces.penalised.add(*run->run.epsilon, seen(run->traces));
  for (const Run& run : mesh.scheme) traces.scheme.add(*run.run.step, seen(run.traces));
  const auto limit_trace = [&](const KnownLimit* limit) -> std::optional<LimitTrace> {
    if (!limit) return std::nullopt;
    const EndTraces& run = seen(limit->run.traces);
    return LimitTrace{run, limit_error(run, seen(limit->rough.traces))};
  };
  traces.scheme_limit = limit_trace(mesh.scheme_limit());
  traces.own_limit = limit_trace(mesh.own_limit());
  traces.one_limit = mesh.one_limit;
  traces.one_law = one_law(study.scene);
  traces.boundary = boundary_of(mesh.penalised.front().run);
  traces.floor = tolerance_error(mesh);
  traces.other_law = [&] {
    // At the smallest penalties that there are by now.
    for (const Run* run : std::span(told).last(std::min<std::size_t>(4, told.size())))
      if (mesh.other_law.empty() || *run->run.epsilon < *mesh.other_law.back().run.epsilon)
        mesh.other_law.emplace_back(Run{with_other_law(run->run)}).trace_one_more(mesh.times, purse);
    TraceSequence sequence;
    for (const Run& run : mesh.other_law)
      if (run.complete) sequence.add(*run.run.epsilon, seen(run.traces));
    return sequence;
  };
  traces.without_obstacles = [&]() -> const EndTraces& {
    if (!mesh.without_obstacles) {
      mesh.without_obstacles = Run{without_obstacles(told.back()->run)};
      // The bar with obstacles stands for it where the budget does not allow the run.
      if (!mesh.without_obstacles->trace_one_more(mesh.times, purse))
        mesh.without_obstacles->traces = mesh.penalised.back().traces;
    }
    return seen(mesh.without_obstacles->traces);
  };
  Judgement judgement = judge(traces);
  judgement.evidence.until = until;
  return judgement;
}

// Runs one more where the budget allows it; whether it is there.
bool go_on(std::deque<Run>& runs, Case next, double expected, MeshRuns& mesh, Purse& purse) {
  mesh.lacking_seconds.reset();
  if (!purse.allows(expected, false)) {
    mesh.lacking_seconds = expected;
    return false;
  }
  Run run{std::move(next)};
  if (!run.trace_one_more(mesh.times, purse)) {
    if (!run.error) mesh.lacking_seconds = std::max(expected, run.seconds);
    return false;
  }
  if (is_penalised(run.run.method)) purse.tell(row_of(mesh, run));
  runs.push_back(std::move(run));
  return true;
}

bool smaller_step(MeshRuns& mesh, const LimitStudy& study, double refinement, Purse& purse) {
  const Run& last = mesh.scheme.back();
  return go_on(mesh.scheme, scheme_case(study, last.run.elements, mesh.step() / refinement), refinement * last.seconds,
               mesh, purse);
}

bool smaller_epsilon(MeshRuns& mesh, Purse& purse) {
  constexpr double decade = 10.0;
  const Run *last = nullptr, *before = nullptr;
  for (const Run& run : mesh.penalised)
    if (run.complete) before = std::exchange(last, &run);
  if (!last || last->error || !mesh.penalised.back().complete) return false;
  Case next = last->run;
  next.epsilon = *next.epsilon / decade;
  const double grows = before ? std::clamp(last->seconds / std::max(before->seconds, 1e-6), 1.0, decade) : 1.0;
  return go_on(mesh.penalised, std::move(next), grows * last->seconds, mesh, purse);
}

// Up to where the limits, or the law of impact, tell two motions apart, where that is early in the run.
std::optional<double> telling_time(const MeshRuns& mesh) {
  const Case& run = mesh.penalised.front().run;
  const double end = run.end;
  double until = end;
  if (const KnownLimit* own = mesh.own_limit(), *other = mesh.scheme_limit(); own && other && own != other) {
    const auto of_own = EndTraces::all(own->run.traces), of_other = EndTraces::all(other->run.traces);
    double largest = 0.0;
    for (std::size_t k = 0; k < mesh.times.size(); ++k)
      for (std::size_t i = 0; i < of_own.size(); ++i)
        if (const double apart = std::abs((*of_own[i])[k] - (*of_other[i])[k]); apart > 1.01 * largest)
          largest = apart, until = 1.01 * mesh.times[k] + 1e-3 * end;
  } else if (!mesh.of_scheme && run.scene.bar.viscosity > 0.0 && !mesh.scheme.empty()) {
    // The first nodes that are hit have come to rest. The scheme knows when to its step only.
    const double h = run.mesh().smallest(), rest = run.scene.bar.density * h * h / run.scene.bar.viscosity;
    for (const Run& penalised : mesh.penalised)
      if (const std::vector<Event>& changes = penalised.traces.events; !changes.empty())
        until = std::min(until, changes.front().time + 30.0 * rest);
  }
  return until < 0.5 * end ? std::optional(until) : std::nullopt;
}

// Nodes tell their law of impact by their first rebounds: a short run, which is cheap, tells a plateau as well as the
// whole one.
std::optional<Judgement> early_plateau(const MeshRuns& mesh, const LimitStudy& study, Purse& purse) {
  const auto until = mesh.scheme.empty() || study.scene.restitution ? std::nullopt : telling_time(mesh);
  if (!until) return std::nullopt;
  const Case& run = mesh.penalised.front().run;
  LimitStudy early = study;
  early.elements = {run.elements};
  early.scene.elements = run.elements;
  early.scene.end = early.scene.output_every = *until;
  if (mesh.of_scheme) {
    const std::vector<const Run*> runs = telling(mesh);
    const double smallest = *runs.back()->run.epsilon;
    early.epsilons = decades(100.0 * smallest, smallest);
    early.steps = {std::min(mesh.step(), *until / 1000.0)};
  } else {
    const auto boundary = boundary_of(run);
    if (!boundary) return std::nullopt;
    early.epsilons = decades(*boundary, 1e-4 * *boundary);
    early.steps = {*until / 3000.0};
  }
  early.row = {};
  early.progress = {};
  early.budget = std::min(study.budget / 4.0, purse.left());
  if (!(early.budget > 0.0)) return std::nullopt;
  const LimitOrders found = viscobar::limit_of(early).orders.front();
  purse.spend(found.seconds);
  if (found.verdict != Verdict::plateau) return std::nullopt;
  Judgement judgement{found.verdict, found.evidence, found.scheme_error};
  judgement.evidence.until = found.evidence.until.value_or(*until);
  return judgement;
}

constexpr double part_known = 0.25;  // error of a plateau, as a part of it, from which its beginning tells more

// A bar that magnifies small differences hides late in the run what its beginning shows. Where limits differ there,
// they do; where they are one by theory, both sequences are to be seen to tend there as long as the bar lets them.
std::optional<Judgement> by_beginning(MeshRuns& mesh, const LimitStudy& study, Purse& purse) {
  constexpr int halvings = 8;
  if (!mesh.own_limit() || !mesh.scheme_limit() || mesh.scheme.empty()) return std::nullopt;
  double until = mesh.penalised.front().run.end;
  for (int k = 0; k < halvings; ++k) {
    until *= 0.5;
    Judgement found = judge_mesh(mesh, study, purse, until);
    while (found.evidence.missing == Missing::smaller_step &&
           mesh.scheme.back().seconds < mesh.own_limit()->run.seconds &&
           smaller_step(mesh, study, scheme_refinement, purse))
      found = judge_mesh(mesh, study, purse, until);
    const LimitEvidence& evidence = found.evidence;
    if (found.verdict == Verdict::plateau ? evidence.apart_error <= part_known * *evidence.apart
                                          : found.verdict == Verdict::converges && mesh.one_limit) {
      mesh.magnifies = true;
      return found;
    }
  }
  return std::nullopt;
}

}  // namespace

void decide(MeshRuns& mesh, const LimitStudy& study, Purse& purse) {
  constexpr double dear = 1.0 / 120.0;  // share of a budget from which on a shorter run is tried before the next one
  constexpr std::size_t enough = 3;     // runs beyond those asked for, from which on the same is done
  bool early = study.budget > 0.0;
  const std::size_t asked = mesh.penalised.size();
  for (;;) {
    mesh.judgement = judge_mesh(mesh, study, purse);
    const Missing missing = mesh.judgement.evidence.missing;
    if (missing == Missing::nothing || missing == Missing::contact || missing == Missing::runs) break;
    const Run* next = missing == Missing::smaller_step && !mesh.scheme.empty() ? &mesh.scheme.back()
                      : missing == Missing::smaller_epsilon                    ? &mesh.penalised.back()
                      : missing == Missing::tighter_tolerance                  ? &mesh.own_limit()->run
                                                                               : nullptr;
    const bool costly = (next && next->seconds > dear * study.budget) || mesh.penalised.size() >= asked + enough;
    if (early && (costly || !mesh.of_scheme)) {
      early = false;
      auto found = by_beginning(mesh, study, purse);
      if (!found) found = early_plateau(mesh, study, purse);
      if (found) {
        mesh.judgement = *found;
        break;
      }
    }
    const bool tighter = missing == Missing::tighter_tolerance && tighten(mesh, purse);
    const bool finer = (missing == Missing::smaller_step || missing == Missing::penalties) &&
                       smaller_step(mesh, study, scheme_refinement, purse);
    const bool stiffer =
        (missing == Missing::smaller_epsilon || missing == Missing::obstacle) && smaller_epsilon(mesh, purse);
    if (!tighter && !finer && !stiffer) break;
  }
  const LimitEvidence& evidence = mesh.judgement.evidence;
  if (evidence.missing != Missing::nothing || (evidence.apart && evidence.apart_error > part_known * *evidence.apart &&
                                               mesh.judgement.verdict == Verdict::plateau))
    if (const auto found = by_beginning(mesh, study, purse)) mesh.judgement = *found;
}

void refine_scheme(MeshRuns& mesh, const LimitStudy& study, Purse& purse) {
  constexpr double part_of_budget = 0.15, part_of_distance = 0.09, little = 0.02;
  const auto lacking = mesh.lacking_seconds;
  for (int k = 0; k < 2; ++k) {
    if (mesh.judgement.verdict != Verdict::converges || mesh.judgement.evidence.until || !mesh.scheme_limit()) break;
    const double s = *mesh.judgement.evidence.scheme_error;
    double nearest = std::numeric_limits<double>::infinity();
    for (const Run& run : mesh.penalised)
      if (run.complete) nearest = std::min(nearest, largest_difference(run.traces, mesh.scheme_limit()->run.traces));
    const Case& last = mesh.scheme.back().run;
    const double seconds = last.end / *last.step * step_seconds(last),
                 wanted = s / (part_of_distance * std::max(nearest, 10.0 * tolerance_error(mesh)));
    double refinement = wanted;
    if (refinement * seconds > part_of_budget * study.budget) refinement = little * study.budget / seconds;
    if (!(refinement > (k == 0 ? 2.0 : 1.0)) || !smaller_step(mesh, study, std::min(refinement, 1e6), purse)) break;
    mesh.judgement = judge_mesh(mesh, study, purse);
  }
  mesh.lacking_seconds = lacking;
}

}  // namespace viscobar::limit

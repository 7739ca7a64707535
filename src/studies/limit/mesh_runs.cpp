#include "studies/limit/mesh_runs.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <ctime>
#include <stdexcept>

#include "case/method_table.hpp"
#include "studies/parallel.hpp"

namespace viscobar::limit {

namespace {

constexpr std::size_t comparison_intervals = 2000;

Case sound(Case run) {
  const std::vector<Finding> findings = validate(run);
  if (!findings.empty()) throw std::invalid_argument(fmt::format("{}: {}", findings[0].key, findings[0].problem));
  return run;
}

Case penalised_case(const LimitStudy& study, std::size_t elements, double epsilon) {
  Case run = study.scene;
  run.directions.clear();
  run.elements = elements;
  run.epsilon = epsilon;
  run.method = penalised_method(run);
  run.mass = effective_mass(run);  // of all partners
  run.tolerance = run.tolerance.with_relative(std::min(run.tolerance.relative, 1e-10));
  run.output_every = run.end;
  return sound(std::move(run));
}

Case rigid_case(const LimitStudy& study, std::size_t elements) {
  Case run = penalised_case(study, elements, study.epsilons.front());
  run.method = MethodName::rigid;
  return run;
}

/// Of the processor, of this thread: what a budget buys does not depend on who else is at work.
double thread_seconds() {
  std::timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

}  // namespace

const double scheme_refinement = std::cbrt(10.0);

void Run::trace(std::span<const double> times) {
  const double begin = thread_seconds();
  traces = trace_ends(run, times);
  seconds = thread_seconds() - begin;
}

bool massless(const Run& rigid) { return rigid.run.mass == Mass::redistributed; }

Case scheme_case(const LimitStudy& study, std::size_t elements, double step) {
  Case run = penalised_case(study, elements, study.epsilons.front());
  run.method = MethodName::fully_discrete;
  run.step = step;
  return sound(std::move(run));
}

MeshRuns runs_of(const LimitStudy& study, std::size_t elements, double step) {
  MeshRuns runs;
  for (const double factor : {scheme_refinement * scheme_refinement, scheme_refinement, 1.0})
    runs.scheme.push_back({scheme_case(study, elements, factor * step)});
  if (Case rigid = rigid_case(study, elements); validate(rigid).empty()) runs.rigid = Run{std::move(rigid)};
  for (const double epsilon : study.epsilons) {
    Case& run = runs.penalised.emplace_back(penalised_case(study, elements, epsilon)).run;
    if (study.derivatives && method_row(run.method).differentiates)
      run.directions.push_back(direction(run, "contact.epsilon"));
  }
  return runs;
}

void carry_out(std::vector<MeshRuns>& meshes, const LimitStudy& study, Progress& progress) {
  std::vector<std::pair<MeshRuns*, Run*>> tasks;
  for (MeshRuns& mesh : meshes) mesh.each([&](Run& run) { tasks.emplace_back(&mesh, &run); });
  progress.expect(2 * tasks.size());
  const auto each = [&](const auto& work) {
    parallel_for(
        tasks.size(),
        [&](std::size_t k) {
          const auto& [mesh, run] = tasks[k];
          if (!run->error) run->attempt([&] { work(*mesh, *run); });
          progress.done();
        },
        study.threads);
  };
  each([](MeshRuns&, Run& run) {
    // A scheme's contacts change where those of its partners do.
    if (run.run.method != MethodName::fully_discrete) run.traces.events = contact_changes(run.run);
  });
  for (MeshRuns& mesh : meshes) {
    std::vector<Event> changes;
    mesh.each(
        [&](const Run& run) { changes.insert(changes.end(), run.traces.events.begin(), run.traces.events.end()); });
    mesh.times = comparison_times(study.scene.end, comparison_intervals, changes);
  }
  each([](MeshRuns& mesh, Run& run) { run.trace(mesh.times); });
  for (const MeshRuns& mesh : meshes) {
    for (const Run& run : mesh.scheme)
      if (run.error) std::rethrow_exception(run.error);
    if (mesh.rigid && mesh.rigid->error && massless(*mesh.rigid)) std::rethrow_exception(mesh.rigid->error);
    if (std::ranges::all_of(mesh.penalised, [](const Run& run) { return run.error != nullptr; }))
      std::rethrow_exception(mesh.penalised.front().error);
  }
}

}  // namespace viscobar::limit

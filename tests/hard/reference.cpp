#include "hard/reference.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "characteristics/cell_waves.hpp"
#include "support/absolute_tolerance.hpp"

namespace viscobar::hard {

namespace {

constexpr std::size_t most_dense_elements = 60;

Case by(Case run, MethodName method, double tolerance) {
  run.method = method;
  run.tolerance = run.tolerance.with_relative(tolerance);
  return run;
}

// How much the scene magnifies a shift of its initial displacement by what the tolerance promises.
double sensitivity(const Case& run, const Recording& reference, double shift) {
  Case shifted = run;
  shifted.scene.displacement = [u = run.scene.displacement, shift](double x) { return u(x) + shift; };
  return std::max(1.0, distance(record(shifted).u, reference.u) / shift);
}

// Matrix exponentials, where the mesh is small enough for them.
Case trusted(Case run) {
  if (run.elements > most_dense_elements) return by(std::move(run), MethodName::arkode, 1e-9);
  run.method = MethodName::exponential;
  return run;
}

Reference of_scheme(const Trial& trial) {
  Case reference = trial.run;
  const bool massless = trial.run.mass == Mass::redistributed;
  reference.tolerance = {1e-8, 1e-3 * absolute_tolerance(trial.run)};
  if (massless)
    reference.method = MethodName::rigid;
  else
    reference = trusted(reference);
  if (trial.run.method == MethodName::finite_difference && reference.mass == Mass::consistent)
    reference.mass = Mass::lumped;
  reference.restitution = trial.run.restitution.value_or(0.0);
  double uncertain = 0.0;
  reference.epsilon = 1e-8;
  const Recording recording = record(reference);
  if (!massless) {
    reference.epsilon = 1e-6;
    uncertain = distance(record(reference).u, recording.u);
  }
  Case finer = trial.run;
  *finer.step /= 2;
  const double change = distance(record(finer).u, trial.result.u);
  return {massless ? "rigid" : "penalised, epsilon = 1e-8", recording,
          4 * change + uncertain + promised(trial, largest(trial.result.u))};
}

Reference of_rigid(const Trial& trial) {
  Case reference = by(trial.run, MethodName::arkode, 1e-9);
  const bool massless = resolve(trial.run).mass == Mass::redistributed;
  if (!massless) reference.restitution = trial.run.restitution.value_or(0.0);
  double uncertain = 0.0;
  std::optional<Recording> softer;
  if (!massless) {  // like the root of epsilon: nine tenths of the difference to a hundred times epsilon
    reference.epsilon = 1e-7;
    softer = record(reference);
  }
  reference.epsilon = 1e-9;
  const Recording recording = record(reference);
  if (softer) uncertain = 0.2 * distance(softer->u, recording.u);
  const auto changes = static_cast<double>(recording.events.size());
  const double u = largest(recording.u);
  return {"arkode, epsilon = 1e-9", recording,
          promised(trial, u) + promised({reference, recording}, u) + uncertain +
              (1 + 2 * changes) * recording.statistics.max_penetration};
}

// At the nodes of the case; straight in time between the steps.
Reference of_characteristics(const Trial& trial) {
  const Case& run = trial.run;
  const Bar& bar = run.scene.bar;
  const std::size_t of_element = (run.scene.load ? 1600 : 6400) / run.elements + 1, cells = of_element * run.elements;
  const double step = bar.length / std::sqrt(bar.modulus / bar.density) / static_cast<double>(cells);
  const auto before = [&](double t) { return static_cast<std::size_t>(t / step); };
  std::vector<std::size_t> kept;
  for (const double t : trial.result.times)
    for (const std::size_t k : {before(t), before(t) + 1})
      if (kept.empty() || k > kept.back()) kept.push_back(k);
  const oracle::CellWaves waves(run.scene, cells, kept.back(), kept);
  Recording recording = trial.result;
  recording.u.clear();
  for (const double t : trial.result.times) {
    const auto place = static_cast<std::size_t>(std::ranges::lower_bound(kept, before(t)) - kept.begin());
    const double share = t / step - static_cast<double>(before(t));
    for (std::size_t j = 0; j <= cells; j += of_element)
      recording.u.push_back((1.0 - share) * waves.fields[place][j] + share * waves.fields[place + 1][j]);
  }
  const auto changes = static_cast<double>(trial.result.events.size());
  return {"cells of a difference scheme", recording,
          (1 + 2 * changes) * step * largest(trial.result.v) + promised(trial, largest(recording.u))};
}

}  // namespace

Reference make_reference(const Trial& trial, bool measure_sensitivity) {
  if (is_scheme(trial.run.method)) return of_scheme(trial);
  if (trial.run.method == MethodName::rigid) return of_rigid(trial);
  if (trial.run.method == MethodName::characteristics) return of_characteristics(trial);
  Case reference = trial.run;
  std::string label = "exponential";
  if (trial.run.method == MethodName::exponential) {
    reference = by(trial.run, MethodName::arkode, 1e-10);
    label = "arkode at 1e-10";
  } else if (trial.run.elements <= most_dense_elements) {
    reference.method = MethodName::exponential;
  } else {
    const MethodName other = trial.run.method == MethodName::arkode ? MethodName::ida : MethodName::arkode;
    reference = by(trial.run, other, 1e-2 * trial.run.tolerance.relative);
    label = std::string(name(other)) + " at a hundredth of the tolerance";
  }
  const Recording recording = record(reference);
  const double u = largest(recording.u);
  double tolerance = promised(trial, u);
  if (is_adaptive(reference.method)) tolerance += promised({reference, recording}, u);
  if (measure_sensitivity) tolerance *= sensitivity(reference, recording, tolerance / 100);
  return {label, recording, tolerance};
}

}  // namespace viscobar::hard

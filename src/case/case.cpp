#include "viscobar/case/case.hpp"

#include <algorithm>
#include <cmath>

#include "case/method_table.hpp"

namespace viscobar {

std::string_view name(MethodName method) { return method_row(method).name; }

bool is_scheme(MethodName method) { return method_row(method).accuracy == Accuracy::step; }

bool is_penalised(MethodName method) { return method_row(method).penalised; }

bool is_adaptive(MethodName method) { return method_row(method).accuracy == Accuracy::tolerances; }

std::vector<double> Case::output_times() const {
  std::vector<double> times;
  // A multiple of `every` that misses the end by rounding only is the end.
  const auto count = static_cast<std::size_t>(std::ceil(end / output_every * (1.0 - 1e-12)));
  times.reserve(count + 1);
  for (std::size_t k = 0; k < count; ++k) times.push_back(static_cast<double>(k) * output_every);
  times.push_back(end);
  return times;
}

Mass effective_mass(const Case& run) {
  const auto mass = method_row(run.method).mass;
  return mass ? mass(run) : run.mass.value_or(Mass::consistent);
}

Penalty penalty(const Case& run) { return {run.epsilon.value_or(1.0), run.restitution.value_or(1.0)}; }

Odeint odeint(const Case& run) { return {penalty(run), run.tolerance, run.stepper, run.step}; }

MethodName automatic_method(const Case& run) {
  const bool ends = is_obstacle(run.scene.left) || is_obstacle(run.scene.right);
  if (ends && !run.scene.span && !run.epsilon) return MethodName::rigid;
  const bool massless = ends && run.mass == Mass::redistributed;
  return run.scene.bar.viscosity > 0.0 || massless ? MethodName::arkode : MethodName::cvode;
}

std::string method_words(const Case& run) {
  return std::string(name(run.method)) + (run.automatic ? ", chosen for the scene" : "");
}

MethodName penalised_method(const Case& run) {
  Case study = run;
  if (!is_penalised(study.method)) study.method = MethodName::cvode;
  const std::vector<Finding> findings = validate(study);
  const bool refused = std::any_of(findings.begin(), findings.end(),
                                   [](const Finding& finding) { return finding.key == "method.name"; });
  return refused ? MethodName::ida : study.method;
}

BarSystem make_system(const Case& run) { return BarSystem(run.scene, run.mesh(), effective_mass(run)); }

Statistics simulate(const Case& run, const BarSystem& system, const Observers& observers) {
  return simulate(run, system, run.output_times(), observers);
}

Statistics simulate(const Case& run, const BarSystem& system, std::span<const double> times,
                    const Observers& observers) {
  return method_row(run.method).run(run, system, system.initial_state(), times, observers);
}

Statistics simulate(const Case& run, const BarSystem& system, const Checkpoint& from, const Observers& observers) {
  return method_row(run.method).run(run, system, from, run.output_times(), observers);
}

}  // namespace viscobar

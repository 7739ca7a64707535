#include "viscobar/case/case.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "case/method_table.hpp"
#include "viscobar/characteristics/characteristics.hpp"

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

namespace {

// Of a case that names none.
Mass default_mass(const Case& run) {
  if (run.elements >= 3 && run.grading == 1.0) return Mass::fourth_order;
  const Scene& scene = run.scene;
  const std::size_t ends = std::size_t{is_obstacle(scene.left)} + std::size_t{is_obstacle(scene.right)};
  const bool algebraic = run.method != MethodName::cvode && run.method != MethodName::odeint;
  const bool massless = ends > 0 && !scene.span && run.elements >= 1 + ends && (scene.bar.viscosity > 0.0 || algebraic);
  return massless ? Mass::redistributed : Mass::consistent;
}

}  // namespace

Mass effective_mass(const Case& run) {
  const auto mass = method_row(run.method).mass;
  return mass ? mass(run) : run.mass.value_or(default_mass(run));
}

Penalty penalty(const Case& run) { return {run.epsilon.value_or(1.0), run.restitution.value_or(1.0)}; }

Odeint odeint(const Case& run) { return {penalty(run), run.tolerance, run.stepper, run.step}; }

AutomaticMethod automatic_method(const Case& run) {
  const Scene& scene = run.scene;
  if (run.epsilon || scene.span) {
    const bool massless = (is_obstacle(scene.left) || is_obstacle(scene.right)) && run.mass == Mass::redistributed;
    return {scene.bar.viscosity > 0.0 || massless ? MethodName::arkode : MethodName::cvode, ""};
  }
  if (scene.bar.viscosity > 0.0) return {MethodName::rigid, ""};
  if (!validate(scene).empty()) return {MethodName::characteristics, ""};
  const auto rigid_because = [](const std::string& why) {
    return AutomaticMethod{
        MethodName::rigid,
        fmt::format("automatic chose rigid, which has the errors of a mesh, and not characteristics: {}", why)};
  };
  try {
    if (const auto time = roughens(scene, run.end))
      return rigid_because(fmt::format(
          "contact changes break the waves without end, into more than 10,000 pieces at t = {:.4g}; no mesh "
          "follows such a motion for long: a positive bar.viscosity has a smooth one",
          *time));
  } catch (const std::invalid_argument& misfit) {
    return rigid_because(misfit.what());
  } catch (const IntegrationError&) {
    // Of the load: each method meets it.
  }
  return {MethodName::characteristics, ""};
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

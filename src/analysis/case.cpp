#include "viscobar/analysis/case.hpp"

#include <algorithm>
#include <cmath>

namespace viscobar {

std::string_view name(MethodName method) {
  switch (method) {
    case MethodName::cvode: return "cvode";
    case MethodName::ida: return "ida";
    case MethodName::arkode: return "arkode";
    case MethodName::odeint: return "odeint";
    case MethodName::rigid: return "rigid";
    case MethodName::exponential: return "exponential";
    case MethodName::fully_discrete: return "fully_discrete";
    case MethodName::finite_difference: return "finite_difference";
  }
  return {};
}

bool is_scheme(MethodName method) {
  return method == MethodName::fully_discrete || method == MethodName::finite_difference;
}

bool is_penalised(MethodName method) { return !is_scheme(method) && method != MethodName::rigid; }

bool is_adaptive(MethodName method) { return !is_scheme(method) && method != MethodName::exponential; }

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
  if (run.method == MethodName::rigid) return Mass::redistributed;
  return run.method == MethodName::finite_difference && run.mass == Mass::consistent ? Mass::lumped : run.mass;
}

Penalty penalty(const Case& run) { return {run.epsilon.value_or(1.0), run.restitution.value_or(1.0)}; }

Odeint odeint(const Case& run) { return {penalty(run), run.tolerance, run.stepper, run.step}; }

MethodName penalised_method(const Case& run) {
  Case study = run;
  if (!is_penalised(study.method)) study.method = MethodName::cvode;
  const std::vector<Finding> findings = validate(study);
  const bool refused = std::any_of(findings.begin(), findings.end(),
                                   [](const Finding& finding) { return finding.key == "method.name"; });
  return refused ? MethodName::ida : study.method;
}

BarSystem make_system(const Case& run) { return BarSystem(run.scene, run.mesh(), effective_mass(run)); }

}  // namespace viscobar

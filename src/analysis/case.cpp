#include "viscobar/analysis/case.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "analysis/method_table.hpp"

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

Mass effective_mass(const Case& run) {
  const auto mass = method_row(run.method).mass;
  return mass ? mass(run) : run.mass;
}

// Beyond it the first element is less than the rounding of the nodes of a large mesh; it gained nothing long before.
constexpr double largest_grading = 1e6;

void check_grading(const Case& run, std::vector<Finding>& findings) {
  if (run.grading == 1.0) return;
  if (!is_obstacle(run.scene.left) && !is_obstacle(run.scene.right))
    findings.push_back({"mesh.grading", "has no end with an obstacle to shrink the elements towards; leave it out"});
  else if (effective_mass(run) == Mass::paper)
    findings.push_back({"mesh.grading",
                        "does not fit the mass \"paper\", which has one weight h for all nodes; leave it out, or use "
                        "\"lumped\""});
}

void check_initial_nodes(const Case& run, std::vector<Finding>& findings) {
  const Mesh mesh = run.mesh();
  for (std::size_t j = 0; j < mesh.nodes(); ++j) {
    const double x = mesh.node(j), u = run.scene.displacement(x), v = run.scene.velocity(x);
    const auto finite = [&](const char* key, double value) {
      if (!std::isfinite(value)) findings.push_back({key, fmt::format("is {} at x = {}", value, x)});
      return std::isfinite(value);
    };
    if (!finite("initial.displacement", u) || !finite("initial.velocity", v)) return;
    if (run.scene.span && u < -run.scene.span->gap) {
      findings.push_back(
          {"initial.displacement",
           fmt::format("penetrates the obstacle of [span]: u_0({}) = {} < -gap = {}", x, u, -run.scene.span->gap)});
      return;
    }
  }
}

}  // namespace

std::vector<Finding> validate(const Case& run) {
  std::vector<Finding> findings = validate(run.scene);
  const auto positive = [&](const char* key, double value) {
    if (!(std::isfinite(value) && value > 0.0))
      findings.push_back({key, fmt::format("must be positive and finite, is {}", value)});
  };
  positive("time.end", run.end);
  positive("output.every", run.output_every);
  if (run.step) positive("method.step", *run.step);
  if (run.epsilon) positive("contact.epsilon", *run.epsilon);
  if (run.restitution && !(*run.restitution >= 0.0 && *run.restitution <= 1.0))
    findings.push_back({"contact.restitution", fmt::format("must lie in [0, 1], is {}", *run.restitution)});
  const auto tolerance = [&](const char* key, double value, double largest) {
    if (!(value > 0.0 && value <= largest))
      findings.push_back({key, fmt::format("must be positive and at most {}, is {}", largest, value)});
  };
  tolerance("method.relative_tolerance", run.tolerance.relative, 0.1);
  tolerance("method.absolute_tolerance", run.tolerance.absolute, 1e300);
  if (run.elements < 1) findings.push_back({"mesh.elements", "must be at least 1"});
  if (!(run.grading >= 1.0 && run.grading <= largest_grading))
    findings.push_back({"mesh.grading", fmt::format("must lie in [1, {}], is {}", largest_grading, run.grading)});
  if (!findings.empty()) return findings;

  const Scene& scene = run.scene;
  const bool left = is_obstacle(scene.left), right = is_obstacle(scene.right);
  const bool obstacle = left || right || scene.span.has_value();
  if (run.end / run.output_every > 1e8)
    findings.push_back({"output.every", fmt::format("gives more than 1e8 output times up to end = {}", run.end)});
  if (is_fixed(scene.left) && is_fixed(scene.right) && run.elements < 2)
    findings.push_back({"mesh.elements", "both ends are fixed: 2 elements are needed for one unknown node"});
  if (effective_mass(run) == Mass::redistributed) {
    const std::size_t needed = 1 + static_cast<std::size_t>(left) + static_cast<std::size_t>(right);
    if (scene.span && run.mass == Mass::redistributed)
      findings.push_back({"mesh.mass",
                          "\"redistributed\" cannot serve a span obstacle: every node is a contact node "
                          "and must keep its mass; use \"consistent\" or \"lumped\""});
    else if (!scene.span && run.elements < needed)
      findings.push_back(
          {"mesh.elements", fmt::format("mass \"redistributed\" needs at least {} elements here", needed)});
  }
  if (is_penalised(run.method) && obstacle && !run.epsilon)
    findings.push_back({"contact.epsilon", fmt::format("is missing: {} penalises the obstacle", name(run.method))});
  if (is_scheme(run.method) && !run.step)
    findings.push_back({"method.step", fmt::format("is missing: {} has a fixed time step", name(run.method))});
  if (is_scheme(run.method) && run.step && run.end / *run.step > 1e12)
    findings.push_back({"method.step", fmt::format("gives more than 1e12 steps up to end = {}", run.end)});
  check_grading(run, findings);
  check_initial_nodes(run, findings);
  if (const auto refuse = method_row(run.method).refuse) refuse(run, findings);
  return findings;
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

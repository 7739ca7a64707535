#include <fmt/format.h>

#include <cmath>

#include "case/method_table.hpp"
#include "case/run_cost.hpp"
#include "scene/message_text.hpp"
#include "viscobar/case/case.hpp"

namespace viscobar {

namespace {

// Beyond it the first element is less than the rounding of the nodes of a large mesh; it gained nothing long before.
constexpr double largest_grading = 1e6;

void check_values(const Case& run, Findings& findings) {
  const auto positive = [&](const char* key, double value) {
    if (!(std::isfinite(value) && value > 0.0)) findings.report(key, "must be positive and finite, is {}", value);
  };
  positive("time.end", run.end);
  positive("output.every", run.output_every);
  if (run.step) positive("method.step", *run.step);
  if (run.epsilon) positive("contact.epsilon", *run.epsilon);
  if (run.restitution && !(*run.restitution >= 0.0 && *run.restitution <= 1.0))
    findings.report("contact.restitution", "must lie in [0, 1], is {}", *run.restitution);
  const auto tolerance = [&](const char* key, double value, double largest) {
    if (!(value > 0.0 && value <= largest))
      findings.report(key, "must be positive and at most {}, is {}", largest, value);
  };
  tolerance("method.relative_tolerance", run.tolerance.relative, 0.1);
  if (run.tolerance.absolute) tolerance("method.absolute_tolerance", *run.tolerance.absolute, 1e300);
  if (run.elements < 1) findings.report("mesh.elements", "must be at least 1");
  if (!(run.grading >= 1.0 && run.grading <= largest_grading))
    findings.report("mesh.grading", "must lie in [1, {}], is {}", largest_grading, run.grading);
}

void check_times(const Case& run, Findings& findings) {
  const bool timed = findings.sound({"time.end"});
  if (timed && findings.sound({"output.every"}) && run.end / run.output_every > 1e8)
    findings.report("output.every", "gives more than 1e8 output times up to end = {}", run.end);
  if (!is_scheme(run.method) || !findings.sound({"method.name"})) return;
  if (timed && findings.sound({"method.step", "mesh.elements", "bar.length", "bar.modulus", "bar.density"}) &&
      run.end / scheme_step(run) > 1e12)
    findings.report("method.step", "gives more than 1e12 steps up to end = {}", run.end);
}

void check_massless(const Case& run, Findings& findings) {
  const Scene& scene = run.scene;
  const std::size_t needed = 1 + end_obstacles(scene);
  if (scene.span && run.mass == Mass::redistributed)
    findings.report("mesh.mass",
                    "\"redistributed\" does not fit a span obstacle: every node is a contact node "
                    "and must keep its mass; use \"consistent\" or \"lumped\"");
  else if (!scene.span && run.elements < needed)
    findings.report("mesh.elements", "mass \"redistributed\" needs at least {} elements here", needed);
}

void check_input(const std::string& table, const EndCondition& end, const EndInput& input, const Case& run,
                 Findings& findings) {
  if (input.motion && run.scene.span)
    findings.report(table + (is_obstacle(end) ? ".gap" : ".motion"),
                    "moves, and an obstacle under the whole span stands still: the two do not go together yet; "
                    "take the number that it begins with, or leave [span] out");
  if (is_obstacle(end) && (input.stiffness > 0.0 || input.dashpot > 0.0) &&
      effective_mass(run) == Mass::redistributed && findings.sound({"mesh.mass", "method.name"}))
    findings.report("mesh.mass",
                    "\"redistributed\" takes the mass that the spring and the dashpot of [{}] "
                    "want from the node; use \"fourth_order\", \"consistent\" or \"lumped\"",
                    table);
}

void check_end_rows(const Case& run, Findings& findings) {
  if (run.elements < 3)
    findings.report("mesh.elements", "mass \"fourth_order\" needs at least 3 elements: its end rows reach three nodes");
  if (run.grading != 1.0)
    findings.report(
        "mesh.grading",
        "does not fit the mass \"fourth_order\", whose weights are those of elements of equal length; leave "
        "it out, or use the mass \"consistent\" or \"lumped\"");
}

void check_grading(const Case& run, Findings& findings) {
  if (run.grading == 1.0 || !findings.sound({"left.kind", "right.kind"})) return;
  if (end_obstacles(run.scene) == 0)
    findings.report("mesh.grading", "has no end with an obstacle to shrink the elements towards; leave it out");
  else if (effective_mass(run) == Mass::paper && findings.sound({"mesh.mass", "method.name"}))
    findings.report("mesh.grading",
                    "does not fit the mass \"paper\", which has one weight h for all nodes; leave it out, or use "
                    "\"lumped\"");
}

void check_memory(const Case& run, Findings& findings) {
  if (!findings.sound({"mesh.elements", "method.name", "time.end", "output.every"})) return;
  const double need = memory_need(run).bytes, limit = memory_limit();
  if (need > limit)
    findings.report("mesh.elements",
                    "{} on {} elements would need {:.3g} GB of memory, but only {:.3g} are available; take fewer{}",
                    name(run.method), run.elements, need / 1e9, limit / 1e9,
                    run.method == MethodName::exponential ? ", or another method: its matrices are dense" : "");
}

void check_initial_nodes(const Case& run, Findings& findings) {
  if (!findings.sound({"bar.length"})) return;
  Mesh mesh = run.mesh();
  if (!findings.sound({"mesh.elements"})) mesh.elements = 1;  // the nodes 0 and L are those of any mesh
  if (!findings.sound({"mesh.grading"})) mesh.grading = {};
  const auto& span = run.scene.span;
  for (std::size_t j = 0; j < mesh.nodes(); ++j) {
    const double x = mesh.node(j), u = run.scene.displacement(x), v = run.scene.velocity(x);
    if (!std::isfinite(u))
      findings.report("initial.displacement", "is {} at x = {}", printable(u), x);
    else if (span && span->depth(u) > 0.0)
      findings.report("initial.displacement", "penetrates the obstacle of [span]: u_0({}) = {} {}", x, u,
                      bound_text(*span, u));
    if (!std::isfinite(v)) findings.report("initial.velocity", "is {} at x = {}", printable(v), x);
  }
}

}  // namespace

std::vector<Finding> validate(const Case& run, const std::vector<std::string>& faulty) {
  Findings findings(faulty);
  findings.add(validate(run.scene));
  check_values(run, findings);

  const Scene& scene = run.scene;
  check_times(run, findings);
  if (is_penalised(run.method) && end_obstacles(scene) > 0 && scene.span && !run.epsilon &&
      findings.sound({"method.name"}))
    findings.report("contact.epsilon",
                    "is missing: {} penalises the obstacles, and for ends and span together there is no "
                    "natural one, for it is a penetration per stress at an end and per force on a volume "
                    "under the span",
                    name(run.method));
  if (is_fixed(scene.left) && is_fixed(scene.right) && run.elements < 2)
    findings.report("mesh.elements", "both ends are fixed: 2 elements are needed for one unknown node");
  if (findings.sound({"mesh.mass", "method.name"})) {
    if (effective_mass(run) == Mass::redistributed) check_massless(run, findings);
    if (effective_mass(run) == Mass::fourth_order) check_end_rows(run, findings);
  }
  check_input("left", scene.left, scene.left_input, run, findings);
  check_input("right", scene.right, scene.right_input, run, findings);
  check_grading(run, findings);
  check_memory(run, findings);
  check_initial_nodes(run, findings);
  if (!findings.sound({"method.name"})) return findings.take();
  const MethodRow& method = method_row(run.method);
  if (!method.takes_algebraic_rows && has_algebraic_rows(run) && findings.sound({"mesh.mass", "bar.viscosity"}))
    findings.report("method.name",
                    "{} cannot take massless contact nodes without viscosity: their equations are "
                    "algebraic; use arkode or ida, or a positive bar.viscosity",
                    method.name);
  else if (method.refuse)
    method.refuse(run, findings);
  return findings.take();
}

}  // namespace viscobar

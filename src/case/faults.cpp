#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "case/method_table.hpp"
#include "case/run_cost.hpp"
#include "dynamics/gauge.hpp"
#include "run/parts.hpp"
#include "scene/end_kinds.hpp"
#include "scene/message_text.hpp"
#include "viscobar/case/case.hpp"

namespace viscobar {

namespace {

/// The faults of a case found so far. A key with a finding has no value to judge others by.
class Findings {
 public:
  /// `faulty` are keys known to be wrong already, of which nothing more is said.
  explicit Findings(const std::vector<std::string>& faulty) : wrong_(faulty) {}

  /// Several findings of one check may have the same key.
  void add(std::vector<Finding> found) {
    std::erase_if(found, [&](const Finding& one) { return !sound({one.key}); });
    for (Finding& one : found) {
      wrong_.push_back(one.key);
      found_.push_back(std::move(one));
    }
  }
  void report(std::string_view key, std::string problem) { add({{std::string(key), std::move(problem)}}); }
  template <class... Args>
  void report(std::string_view key, fmt::format_string<Args...> problem, Args&&... args) {
    if (sound({key})) report(key, fmt::format(problem, std::forward<Args>(args)...));
  }

  bool sound(std::initializer_list<std::string_view> keys) const {
    return std::none_of(keys.begin(), keys.end(), [&](std::string_view key) {
      return std::find(wrong_.begin(), wrong_.end(), key) != wrong_.end();
    });
  }
  /// The same of all keys of tables, those of `initial` such as `initial.velocity`.
  bool sound_tables(std::initializer_list<std::string_view> tables) const {
    return std::none_of(wrong_.begin(), wrong_.end(), [&](std::string_view key) {
      return std::find(tables.begin(), tables.end(), key.substr(0, key.find('.'))) != tables.end();
    });
  }

  std::vector<Finding> take() { return std::move(found_); }

 private:
  std::vector<std::string> wrong_;
  std::vector<Finding> found_;
};

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
  std::vector<double> gauges = run.gauges;
  std::ranges::sort(gauges);
  if (const auto twice = std::ranges::adjacent_find(gauges); twice != gauges.end())
    findings.report("output.gauges", "has {} twice", *twice);
  if (!gauges.empty() && findings.sound({"bar.length"}) &&
      !(gauges.front() >= 0.0 && !is_behind(gauges.back(), run.scene.bar.length)))
    findings.report("output.gauges", "must lie on the bar, in [0, {}], and {} does not", run.scene.bar.length,
                    gauges.front() < 0.0 ? gauges.front() : gauges.back());
}

void check_times(const Setup& setup, Findings& findings) {
  const Case& run = setup.run;
  const bool timed = findings.sound({"time.end"});
  if (timed && findings.sound({"output.every"}) && run.end / run.output_every > 1e8)
    findings.report("output.every", "gives more than 1e8 output times up to end = {}", run.end);
  if (!is_scheme(run.method) || !findings.sound({"method.name"})) return;
  if (timed && findings.sound({"method.step", "mesh.elements", "bar.length", "bar.modulus", "bar.density"}) &&
      run.end / setup.step > 1e12)
    findings.report("method.step", "gives more than 1e12 steps up to end = {}", run.end);
}

void check_massless(const Case& run, Findings& findings) {
  const Scene& scene = run.scene;
  const std::size_t needed = 1 + bare_obstacles(scene);
  if (scene.span && run.mass == Mass::redistributed)
    findings.report("mesh.mass",
                    "\"redistributed\" does not fit a span obstacle: every node is a contact node "
                    "and must keep its mass; use \"consistent\" or \"lumped\"");
  else if (!scene.span && run.elements < needed)
    findings.report("mesh.elements", "mass \"redistributed\" needs at least {} elements here", needed);
}

void check_input(const std::string& table, const EndCondition& end, const EndInput& input, const Setup& setup,
                 Findings& findings) {
  if (input.motion && setup.run.scene.span)
    findings.report(table + (is_obstacle(end) ? ".gap" : ".motion"),
                    "moves, and an obstacle under the whole span stands still: the two do not go together yet; "
                    "take the number that it begins with, or leave [span] out");
  const bool takes_mass = setup.mass == Mass::redistributed && is_obstacle(end) && bare_obstacles(setup.run.scene) == 0;
  if (!takes_mass || !findings.sound({"mesh.mass", "method.name"})) return;
  if (input.stiffness > 0.0 || input.dashpot > 0.0 || input.mass > 0.0)
    findings.report("mesh.mass",
                    "\"redistributed\" takes the mass that the spring, the dashpot and the mass of [{}] "
                    "want from the node; use \"fourth_order\", \"consistent\" or \"lumped\"",
                    table);
  if (input.stop)
    findings.report("mesh.mass",
                    "\"redistributed\" takes the mass that a stop by {} meets from the node; use \"fourth_order\", "
                    "\"consistent\" or \"lumped\"",
                    name(input.stop->law));
}

// The key by which rows of the bar differ; null: they do not.
const char* unlike_rows(const Case& run) {
  return run.grading != 1.0 ? "mesh.grading" : run.nodes ? "mesh.nodes" : run.scene.section ? "bar.section" : nullptr;
}

void check_end_rows(const Case& run, Findings& findings) {
  if (!run.scene.chain.empty()) {
    if (!fourth_order_fits(run))
      findings.report(
          "mesh.mass",
          "\"fourth_order\" takes bars of 3 elements or more each, none more than {} times its neighbour by int "
          "dx / A; give those that have fewer more (bar.1.elements), or use \"consistent\"",
          largest_jump);
    return;
  }
  if (run.elements < 3)
    findings.report("mesh.elements", "mass \"fourth_order\" needs at least 3 elements: its end rows reach three nodes");
  else if (!fourth_order_fits(run) && findings.sound({"bar.length", "bar.section", "mesh.nodes"}))
    findings.report("mesh.mass",
                    "\"fourth_order\" takes elements of at most {} times their neighbours, measured by int dx / A, and "
                    "here some are longer; use \"consistent\" or \"lumped\"",
                    largest_jump);
}

void check_grading(const Setup& setup, Findings& findings) {
  const Case& run = setup.run;
  const auto towards_nothing = [&](const std::string& key) {
    findings.report(key, "has no end with {} to shrink the elements towards; leave it out",
                    run.scene.chain.empty() ? "an obstacle" : "an obstacle or a contact");
  };
  if (run.grading != 1.0 && end_obstacles(run.scene) == 0 && !has_contact_joint(run.scene) &&
      findings.sound({"left.kind", "right.kind"}))
    towards_nothing("mesh.grading");
  else if (const char* key = unlike_rows(run);
           key && setup.mass == Mass::paper && run.scene.chain.empty() && findings.sound({"mesh.mass", "method.name"}))
    findings.report(key,
                    "does not fit the mass \"paper\", which has one weight h for all nodes; leave it out, or use "
                    "\"lumped\"");
  for (std::size_t m = 0; m < run.bar_meshes.size(); ++m)
    if (const double ratio = run.bar_meshes[m].grading.ratio; ratio != 1.0 && ratio != run.grading)
      if (!meets_contact(run.scene, m, false) && !meets_contact(run.scene, m, true))
        towards_nothing(fmt::format("bar.{}.grading", m + 1));
}

/// Values of a formula have the bounds of a number, within which products of a few are numbers. True if it is outside.
bool report_area(const std::string& key, double area, double x, Findings& findings) {
  if (area >= 1e-100 && area <= 1e100) return false;
  findings.report(key, "must be {}, is {} at x = {}",
                  std::isfinite(area) && area > 0.0 ? "from 1e-100 to 1e+100" : "finite and positive", printable(area),
                  x);
  return true;
}

void check_section(const Case& run, Findings& findings) {
  if (!run.scene.section || !findings.sound({"bar.length", "bar.section", "mesh.elements", "mesh.grading"})) return;
  const Mesh mesh = run.mesh();
  for (std::size_t k = 0; k <= 2 * mesh.elements; ++k) {
    const double x = k % 2 == 0 ? mesh.node(k / 2) : 0.5 * (mesh.node(k / 2) + mesh.node(k / 2 + 1));
    if (report_area("bar.section", run.scene.section(x), x, findings)) return;
  }
}

// A joint's key, from 1.
std::string joint_key(std::size_t k, std::string_view leaf) { return fmt::format("joint.{}.{}", k, leaf); }

void check_members(const Case& run, Findings& findings) {
  const std::vector<Member>& chain = run.scene.chain;
  for (std::size_t m = 0; m < chain.size(); ++m) {
    const Member& member = chain[m];
    const auto key = [m](std::string_view leaf) { return fmt::format("bar.{}.{}", m + 1, leaf); };
    for (const bool velocity : {false, true})
      for (const double x : {0.0, member.bar.length})
        if (const double value = velocity ? member.velocity(x) : member.displacement(x); !std::isfinite(value))
          findings.report(key(velocity ? "velocity" : "displacement"), "is {} at x = {}", printable(value), x);
    for (int k = 0; k <= 200 && member.section; ++k)
      if (const double x = member.bar.length * k / 200.0; report_area(key("section"), member.section(x), x, findings))
        break;
    if (m + 1 == chain.size()) break;
    const Joint& joint = member.joint;
    const double apart = chain[m + 1].displacement(0.0) - member.displacement(member.bar.length);
    if (joint.kind == JointKind::contact && Obstacle{.gap = joint.gap}.passed_by(apart))
      findings.report(joint_key(m + 1, "gap"), "is {}, and the initial displacements overlap there by {}", joint.gap,
                      -apart);
    if (joint.kind == JointKind::bonded && std::abs(apart) > 1e-9 * run.scene.bar.length)
      findings.report(
          key("displacement"),
          "leaves a gap of {} to the next bar, and the two are bonded: that has one displacement at the joint", apart);
  }
}

// Refuses whatever does not go together with several bars in line yet.
void check_chain(const Setup& setup, Findings& findings) {
  const Case& run = setup.run;
  const Scene& scene = run.scene;
  const auto refuse = [&](bool there, const char* key, const char* what) {
    if (there) findings.report(key, "{} and several bars in line do not go together yet", what);
  };
  refuse(scene.span.has_value(), "span.gap", "an obstacle under the whole span");
  for (const bool right : {false, true}) {
    const EndCondition& end = right ? scene.right : scene.left;
    const std::size_t last = right ? scene.chain.size() - 1 : 0;
    if (std::holds_alternative<Free>(end) || !scene.chain[last].rigid() || !meets_contact(scene, last, !right))
      continue;
    const std::string key = right ? "right.kind" : "left.kind";
    if (is_fixed(end))
      findings.report(key,
                      "holds a rigid body that the next bar meets: leave the body out, and make this end an "
                      "obstacle of that bar, with the gap of the joint");
  }
  if (run.method == MethodName::finite_difference)
    findings.report("method.name",
                    "finite_difference takes one bar; for several in line use rigid, arkode, cvode, ida, odeint, "
                    "exponential, characteristics or fully_discrete");
  if ((setup.mass == Mass::redistributed || setup.mass == Mass::paper) && findings.sound({"mesh.mass", "method.name"}))
    findings.report("mesh.mass",
                    "\"{}\" does not fit several bars in line; use \"fourth_order\", \"consistent\" or "
                    "\"lumped\"",
                    name(setup.mass));
  for (std::size_t k = 0; k + 1 < scene.chain.size(); ++k) {
    const Joint& joint = scene.chain[k].joint;
    if (joint.kind != JointKind::contact) continue;
    const MethodName method = run.method;
    const bool linear_only = method == MethodName::exponential || method == MethodName::characteristics;
    const bool taken = !joint.stop || (linear_only ? joint.stop->linear() : method_row(method).takes_laws);
    if (!taken && findings.sound({"method.name"}))
      findings.add({law_refusal(name(method), *joint.stop, fmt::format("joint.{}", k + 1))});
  }
  check_members(run, findings);
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
    else if (span && span->passed_by(u))
      findings.report("initial.displacement", "penetrates the obstacle of [span]: u_0({}) = {} {}", x, u,
                      bound_text(*span, u));
    if (!std::isfinite(v)) findings.report("initial.velocity", "is {} at x = {}", printable(v), x);
  }
}

void check_side(const Case& run, Findings& findings) {
  if (!run.scene.side || !findings.sound({"bar.length", "mesh.elements", "mesh.grading"})) return;
  const Mesh mesh = run.mesh();
  for (const auto& [key, of] :
       {std::pair{"side.stiffness", &run.scene.side->stiffness}, {"side.drag", &run.scene.side->drag}})
    for (std::size_t j = 0; *of && j < mesh.nodes(); ++j)
      if (const double x = mesh.node(j), value = (*of)(x); !(std::isfinite(value) && value >= 0.0))
        findings.report(key, "must be finite and not negative, is {} at x = {}", printable(value), x);
}

// The stepper, and the number of its steps, follow from the whole system.
void check_odeint(const Setup& setup, Findings& findings) {
  if (!findings.sound_tables({"bar", "left", "right", "span", "side", "initial", "time", "mesh", "contact"}) ||
      !findings.sound({"method.stepper"}))
    return;
  if (const auto why = plan(setup.system(), setup.run.end, std::get<Odeint>(setup.method)).refusal)
    findings.add({*why});
}

std::size_t fixed_ends(const Scene& scene) {
  return std::size_t{is_fixed(scene.left)} + std::size_t{is_fixed(scene.right)};
}

void check_exponential(const Case& run, Findings& findings) {
  if (const auto law = law_refusal("exponential", run.scene.left_input, run.scene.right_input, true))
    findings.add({*law});
  if (run.elements + 1 > Exponential::most_unknowns + fixed_ends(run.scene))
    findings.report("mesh.elements",
                    "exponential works with dense matrices and takes up to {} unknown "
                    "nodes; take fewer elements, or another method",
                    Exponential::most_unknowns);
}

void check_characteristics(const Case& run, Findings& findings) {
  if (!findings.sound({"bar.length", "bar.density", "bar.modulus", "bar.viscosity", "time.end"})) return;
  if (!run.scene.chain.empty() && !validate(run.scene).empty()) return;
  if (const auto why = refusal_by_characteristics(run)) findings.add({*why});
}

void check_rigid(const Case& run, Findings& findings) {
  if (run.scene.span)
    findings.report("method.name", "rigid stops one node at a time, and under a span obstacle several meet it at once");
  if (end_obstacles(run.scene) > 0 && run.elements < 1 + fixed_ends(run.scene))
    findings.report("mesh.elements", "rigid needs an unknown node beside that of a contact: one more element");
}

void check_finite_difference(const Case& run, Findings& findings) {
  if (run.mass == Mass::redistributed || run.mass == Mass::fourth_order)
    findings.report("mesh.mass",
                    "\"{}\" does not fit finite_difference, whose mass is diagonal; use \"lumped\" or "
                    "\"paper\", or fully_discrete",
                    name(*run.mass));
  if (const char* key = unlike_rows(run))
    findings.report(key,
                    "does not fit finite_difference, whose elements are all alike; leave it out, or use "
                    "fully_discrete with the mass \"lumped\"");
}

// All that a method alone cannot take.
void check_method(const Setup& setup, Findings& findings) {
  const Case& run = setup.run;
  const MethodRow& method = method_row(run.method);
  if (!method.takes_algebraic_rows && has_algebraic_rows(run) && findings.sound({"mesh.mass", "bar.viscosity"}))
    return findings.add({algebraic_rows(method.name)});
  const auto law = law_refusal(method.name, run.scene.left_input, run.scene.right_input);
  if (law && !method.takes_laws) return findings.add({*law});
  switch (run.method) {
    case MethodName::odeint: return check_odeint(setup, findings);
    case MethodName::rigid: return check_rigid(run, findings);
    case MethodName::exponential: return check_exponential(run, findings);
    case MethodName::characteristics: return check_characteristics(run, findings);
    case MethodName::finite_difference: return check_finite_difference(run, findings);
    default: return;
  }
}

}  // namespace

std::vector<Finding> faults(const Setup& setup, const std::vector<std::string>& faulty) {
  const Case& run = setup.run;
  Findings findings(faulty);
  findings.add(validate(run.scene));
  check_values(run, findings);

  const Scene& scene = run.scene;
  check_times(setup, findings);
  if (is_penalised(run.method) && has_end_penalty(scene) && scene.span && !run.epsilon &&
      findings.sound({"method.name"})) {
    const auto law = law_refusal("", scene.left_input, scene.right_input);
    findings.report(
        "contact.epsilon",
        "is missing: {}{} penalises the obstacles that have no law, and for ends and span together there is "
        "no natural one, for it is a penetration per stress at an end and per force on a volume under the "
        "span",
        name(run.method), run.automatic && law ? fmt::format(", chosen for {},", law->key) : "");
  }
  if (is_fixed(scene.left) && is_fixed(scene.right) && run.elements < 2)
    findings.report("mesh.elements", "both ends are fixed: 2 elements are needed for one unknown node");
  if (findings.sound({"mesh.mass", "method.name"})) {
    if (setup.mass == Mass::redistributed) check_massless(run, findings);
    if (setup.mass == Mass::fourth_order) check_end_rows(run, findings);
  }
  check_input("left", scene.left, scene.left_input, setup, findings);
  check_input("right", scene.right, scene.right_input, setup, findings);
  if (!scene.chain.empty()) check_chain(setup, findings);
  check_grading(setup, findings);
  check_section(run, findings);
  check_memory(run, findings);
  check_initial_nodes(run, findings);
  check_side(run, findings);
  if (!findings.sound({"method.name"})) return findings.take();
  check_method(setup, findings);
  return findings.take();
}

}  // namespace viscobar

#include "viscobar/scene/scene.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "scene/end_kinds.hpp"
#include "scene/message_text.hpp"

namespace viscobar {

namespace {

template <class... Args>
void require(std::vector<Finding>& findings, bool sound, const std::string& key, fmt::format_string<Args...> problem,
             Args&&... args) {
  if (!sound) findings.push_back({key, fmt::format(problem, std::forward<Args>(args)...)});
}

void check_input(std::vector<Finding>& findings, const std::string& table, const EndCondition& end,
                 const EndInput& input, double length) {
  // Keys are put together for what is wrong alone: an ensemble asks for each of its bars.
  const auto check_number = [&](const char* key, double value) {
    if (value == 0.0 || (!is_fixed(end) && value > 0.0 && std::isfinite(value))) return;
    require(findings, std::isfinite(value) && value >= 0.0, fmt::format("{}.{}", table, key),
            "must be finite and not negative, is {}", value);
    require(findings, !is_fixed(end) || value == 0.0, fmt::format("{}.{}", table, key),
            "belongs to a free end or an obstacle; a fixed end does not feel it");
  };
  check_number("stiffness", input.stiffness);
  check_number("dashpot", input.dashpot);
  check_number("mass", input.mass);
  if (input.stop) {
    require(findings, is_obstacle(end), table + ".contact.law", "belongs to an obstacle");
    require(findings, std::isfinite(input.stop->stiffness) && input.stop->stiffness > 0.0,
            input.stop->key(table, "stiffness"), "must be positive and finite, is {}", input.stop->stiffness);
    require(findings, std::isfinite(input.stop->damping) && input.stop->damping >= 0.0,
            input.stop->key(table, "damping"), "must be finite and not negative, is {}", input.stop->damping);
  }
  if (input.force) {
    require(findings, !is_fixed(end), table + ".force",
            "belongs to a free end or an obstacle; a fixed end does not feel it, and has a motion");
    require(findings, bool(input.force->value), table + ".force", "is no function");
  }
  if (!input.motion) return;
  const std::string key = table + (is_obstacle(end) ? ".gap" : ".motion");
  const EndMotion& motion = *input.motion;
  require(findings, !std::holds_alternative<Free>(end), key, "belongs to a fixed end; a free one is moved by a force");
  if (!motion.displacement || !motion.velocity || !motion.acceleration)
    return findings.push_back({key, "has to be given with its first and second derivative in time"});
  const double start = motion.displacement(0.0);
  if (is_obstacle(end) && !std::isfinite(start)) return;  // that gap is no number of the obstacle's
  require(findings, std::abs(start) <= 1e-12 * length, key,
          "must be 0 at t = 0, where the end is at its initial displacement, is {}", start);
}

void check_end(std::vector<Finding>& findings, const std::string& table, const Scene& scene, EndCondition end,
               const EndInput& input, double x) {
  check_input(findings, table, end, input, scene.bar.length);
  const std::size_t before = findings.size();
  for (const EndNumber& number : end_kind(end).numbers) {
    const double value = number.of(end);
    if (!(value >= number.low && value <= number.high))
      findings.push_back(
          {fmt::format("{}.{}", table, number.key), fmt::format("must be finite and {}, is {}", number.range, value)});
  }
  if (findings.size() != before) return;
  const double u = scene.displacement ? scene.displacement(x) : 0.0;
  const auto obstacle = end_node(end, u).obstacle;
  if (!obstacle) return;
  require(findings, obstacle->side != Side::both, table + ".side",
          "is \"both\", which only a span can be; an end has one obstacle, below or above");
  if (obstacle->passed_by(u))
    findings.push_back({"initial.displacement", fmt::format("penetrates the obstacle of [{}]: u_0({}) = {} {}", table,
                                                            x, u, bound_text(*obstacle, u))});
}

}  // namespace

std::string_view name(Side side) {
  constexpr std::string_view names[] = {"below", "above", "both"};
  return names[static_cast<std::size_t>(side)];
}

std::string_view name(JointKind kind) {
  constexpr std::string_view names[] = {"bonded", "contact", "spring"};
  return names[static_cast<std::size_t>(kind)];
}

std::string_view meaning(JointKind kind) {
  constexpr std::string_view meanings[] = {"as one bar", "they meet and part",
                                           "a spring and a dashpot, which pull as well"};
  return meanings[static_cast<std::size_t>(kind)];
}

Bar whole_of(const std::vector<Member>& chain) {
  double length = 0.0, time = 0.0, impedance = 0.0, relaxation = 0.0, dashpot = 0.0;
  const Bar* first = nullptr;
  bool of_density = true, of_modulus = true, of_viscosity = true;
  for (const Member& member : chain) {
    dashpot = std::max(dashpot, member.joint.kind == JointKind::spring ? member.joint.damping : 0.0);
    if (member.rigid()) continue;
    const Bar& bar = member.bar;
    if (!first) first = &bar;
    of_density &= bar.density == first->density;
    of_modulus &= bar.modulus == first->modulus;
    of_viscosity &= bar.viscosity == first->viscosity;
    const double transit = bar.transit();
    length += bar.length;
    time += transit;
    impedance += transit * bar.impedance();
    relaxation = std::max(relaxation, bar.viscosity / bar.modulus);
  }
  if (!first) return {0.0, 1.0, 1.0, 0.0};
  const double speed = length / time;
  Bar whole{length, impedance / time / speed, impedance / time * speed, 0.0};
  if (of_modulus) whole.modulus = first->modulus, whole.density = first->modulus / (speed * speed);
  if (of_density)
    whole.density = first->density, whole.modulus = of_modulus ? whole.modulus : speed * speed * first->density;
  whole.viscosity = of_modulus && of_viscosity ? first->viscosity : relaxation * whole.modulus;
  // A dashpot between elastic bars: any size will do that makes the chain a damped one.
  if (whole.viscosity == 0.0) whole.viscosity = dashpot * length;
  return whole;
}

bool meets_contact(const Scene& scene, std::size_t member, bool right) {
  const std::vector<Member>& chain = scene.chain;
  for (std::size_t m = member;; right ? ++m : --m) {
    if (m == (right ? chain.size() - 1 : 0)) return is_obstacle(right ? scene.right : scene.left);
    const Joint& joint = chain[right ? m : m - 1].joint;
    if (joint.kind != JointKind::bonded) return joint.kind == JointKind::contact;
    if (!chain[right ? m + 1 : m - 1].rigid()) return false;
  }
}

std::optional<Finding> law_refusal(std::string_view method, const EndInput& left, const EndInput& right,
                                   bool takes_linear) {
  for (const EndInput* end : {&left, &right})
    if (end->stop && !(takes_linear && end->stop->linear()))
      return law_refusal(method, *end->stop, end == &left ? "left" : "right");
  return std::nullopt;
}

Finding law_refusal(std::string_view method, const Stop& stop, const std::string& table) {
  return {stop.key(table, "law"),
          fmt::format("\"{}\" is no law for {}: it has no such stop; use arkode, cvode, ida{}, or leave the law out",
                      name(stop.law), method,
                      stop.linear() ? ", odeint, exponential or, without viscosity, characteristics" : " or odeint")};
}

std::vector<Finding> validate(const Scene& scene) {
  std::vector<Finding> findings;
  const Bar& bar = scene.bar;
  const auto check_bar = [&](const std::string& table, const Bar& one) {
    for (const auto& [key, value] :
         {std::pair{".length", one.length}, {".density", one.density}, {".modulus", one.modulus}})
      require(findings, std::isfinite(value) && value > 0.0, table + key, "must be positive and finite, is {}", value);
    require(findings, std::isfinite(one.viscosity) && one.viscosity >= 0.0, table + ".viscosity",
            "must be finite and not negative, is {}", one.viscosity);
  };
  if (scene.chain.empty()) check_bar("bar", bar);
  for (std::size_t m = 0; m < scene.chain.size(); ++m)
    if (!scene.chain[m].rigid()) check_bar(fmt::format("bar.{}", m + 1), scene.chain[m].bar);
  check_end(findings, "left", scene, scene.left, scene.left_input, 0.0);
  check_end(findings, "right", scene, scene.right, scene.right_input, bar.length);
  if (scene.span)
    require(findings, std::isfinite(scene.span->gap) && scene.span->gap >= 0.0, "span.gap",
            "must be finite and not negative, is {}", scene.span->gap);
  return findings;
}

}  // namespace viscobar

#include "report/scene_check.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "case/chatter.hpp"
#include "dynamics/natural_scales.hpp"
#include "input/described_scene.hpp"
#include "report/number_text.hpp"
#include "results/json.hpp"
#include "results/summary.hpp"
#include "studies/accuracy/quick_estimate.hpp"

namespace viscobar {

std::string_view name(ImpactPrediction::Layer layer) {
  switch (layer) {
    case ImpactPrediction::Layer::viscous: return "viscous layer";
    case ImpactPrediction::Layer::elastic: return "elastic wave";
    case ImpactPrediction::Layer::bar: return "the whole bar, the spring is softer than it";
    case ImpactPrediction::Layer::node: return "end node alone, the mesh is too coarse for the layer";
  }
  return {};
}

std::string_view load_kind(const Scene& scene) {
  if (!scene.load) return "none";
  if (std::holds_alternative<SteadyLoad>(*scene.load)) return "steady";
  return std::holds_alternative<SeparableLoad>(*scene.load) ? "profile times history" : "general";
}

// Beside what the whole section at that end has.
std::vector<std::string> inputs_text(const Scene& scene, const Bar& bar, const SceneEnd& end) {
  const EndInput& input = end.input;
  const std::string_view area = scene.section || !scene.chain.empty() ? "A " : "";
  const NumberText number = NumberText::terminal(scene);
  std::vector<std::string> text;
  if (input.force)
    text.push_back(input.force->steady ? "force " + number(input.force->value(0.0), Dimension::force, 6)
                                       : "force F(t), on the row of the end");
  if (input.stiffness > 0.0)
    text.push_back(fmt::format("spring k = {} = {:.3g} {}E/L, at rest at u = 0",
                               number.of_key("left.stiffness", input.stiffness, 6),
                               input.stiffness * bar.length / bar.modulus, area));
  if (input.dashpot > 0.0)
    text.push_back(fmt::format("dashpot c = {} = {:.3g} {}sqrt(E rho)", number.of_key("left.dashpot", input.dashpot, 6),
                               input.dashpot / bar.impedance(), area));
  if (input.mass > 0.0)
    text.push_back(fmt::format("mass m = {} = {:.3g} of the bar's", number.of_key("left.mass", input.mass, 6),
                               input.mass / (bar.density * bar.length)));
  if (input.motion)
    text.push_back(
        is_obstacle(end.condition)
            ? "the obstacle moves: where the bar may touch it, the frame of the computation begins to follow it"
            : "motion d(t): the bar is computed in a frame that moves with it");
  return text;
}

namespace {

// Least and largest of(f(x)) along the bar.
std::string range_along(const Scene& scene, const NumberText& number, const SpaceFunction& f, const UnitPowers& unit,
                        auto&& of) {
  constexpr int places = 200;
  double least = of(f(0.0)), most = least;
  for (int j = 1; j <= places; ++j) {
    const double value = of(f(scene.bar.length * j / places));
    least = std::min(least, value), most = std::max(most, value);
  }
  const std::string last = number(most, unit, 4);
  return least == most ? last : fmt::format("{} to {}", number(least, 4), last);
}

}  // namespace

std::vector<std::string> member_texts(const Scene& scene, NumberText::For reader) {
  const bool on_page = reader == NumberText::For::page;
  const NumberText number(reader, scene);
  const auto told = [&](double value, std::string_view unit) {
    return number(value, *unit_powers(unit), on_page ? 4 : 10);
  };
  const auto symbol = [&](const char* plain, const char* letter) {
    return on_page ? fmt::format("<i>{}</i>", letter) : std::string(plain);
  };
  std::vector<std::string> lines;
  for (const Member& member : scene.chain) {
    const Bar& bar = member.bar;
    std::string text = "rigid body of mass " + told(member.mass, "density x length x area");
    if (!member.rigid())
      text = fmt::format("bar of {} = {}, {} = {}, {} = {}, {} = {}{}", symbol("L", "L"), told(bar.length, "length"),
                         symbol("rho", "ρ"), told(bar.density, "density"), symbol("E", "E"),
                         told(bar.modulus, "stress"), symbol("eta", "η"), told(bar.viscosity, "stress x time"),
                         member.section ? ", of varying section" : "");
    const Joint& joint = member.joint;
    if (&member != &scene.chain.back()) text += fmt::format(", then {}", name(joint.kind));
    if (joint.kind == JointKind::contact) text += " over a gap of " + told(joint.gap, "length");
    if (joint.kind == JointKind::spring)
      text += fmt::format(" of {} = {}, {} = {}", symbol("k", "k"), told(joint.stiffness, "force / length"),
                          symbol("c", "c"), told(joint.damping, "force x time / length"));
    lines.push_back(std::move(text));
  }
  return lines;
}

std::string section_text(const Scene& scene, NumberText::For reader) {
  return "A = " +
         range_along(scene, {reader, scene}, scene.section, UnitPowers{2, 0, 0, 0}, [](double area) { return area; });
}

std::string side_text(const Scene& scene) {
  const auto range = [&](const SpaceFunction& f, std::string_view unit, auto&& of) {
    return range_along(scene, NumberText::terminal(scene), f, unit_powers(unit).value(), of);
  };
  if (!scene.side) return "none";
  const SpaceFunction &stiffness = scene.side->stiffness, &drag = scene.side->drag;
  const double rho = scene.bar.density;
  const auto value = [](double x) { return x; };
  std::string text;
  if (stiffness)
    text =
        fmt::format("springs k = {}, frequency sqrt(k/rho) = {}", range(stiffness, "stress / length / length", value),
                    range(stiffness, "1 / time", [rho](double k) { return std::sqrt(k / rho); }));
  if (drag)
    text += fmt::format("{}drag c = {}, decay c/(2 rho) = {}", text.empty() ? "" : "; ",
                        range(drag, "stress x time / length / length", value),
                        range(drag, "1 / time", [rho](double c) { return c / (2.0 * rho); }));
  return text;
}

std::string contact_kind(const Setup& setup) {
  const Case& run = setup.run;
  const NumberText number = NumberText::terminal(run.scene);
  const std::string epsilon = number(setup.epsilon, number.of_epsilon, 6);
  std::string stops;
  for (const SceneEnd& end : ends_of(run.scene))
    if (const auto& stop = end.input.stop) {
      // By Hertz' law a force is k d^(3/2), and lambda multiplies it.
      const bool linear = stop->linear();
      const UnitPowers stiffness{linear ? -1.0 : -1.5, 0, 1, 1};
      const UnitPowers damping = unit_powers(linear ? "force x time / length" : "time / length").value();
      stops += fmt::format("{}{} by {}, k = {}", stops.empty() ? "" : "; ", end.name, name(stop->law),
                           number(stop->stiffness, stiffness, 6));
      if (has_damper(stop->law))
        stops += fmt::format(", {} = {}", linear ? "c" : "lambda", number(stop->damping, damping, 6));
    }
  if (!stops.empty() && !has_penalty(run.scene)) return stops;
  if (!stops.empty()) return fmt::format("{}; elsewhere penalty, epsilon = {}", stops, epsilon);
  if (is_penalised(run.method))
    return fmt::format("penalty, epsilon = {} = {:.3g} {}{}", epsilon, setup.epsilon / natural_epsilon(run.scene),
                       natural_epsilon_words(run.scene), run.epsilon ? "" : ", chosen for the mesh");
  if (run.method == MethodName::characteristics) return "exact: an end answers what arrives";
  if (run.method == MethodName::rigid) return "rigid: closed nodes are held";
  return run.restitution.value_or(0.0) > 0.0 || run.impact == Impact::moreau
             ? "impacts between steps: a node is as deep as it moves within a step, at most"
             : "exact constraint in every step";
}

namespace {

/// Advice on a contact that bounces: its meaning for the limit epsilon -> 0, and the remedy.
std::string advice(const Setup& setup, const ContactRegime& regime, bool here) {
  const Case& run = setup.run;
  const bool span = regime.where == Where::span;
  const std::string bounce = fmt::format("{}: the {} (zeta = {:.3g} < 1)", name(regime.where),
                                         span ? "nodes rebound" : "end node rebounds", *regime.damping_ratio);
  if (run.restitution)
    return fmt::format(
        "{}, and so do those of the fully discrete scheme with the same contact.restitution = {}: the two share one "
        "limit as epsilon goes to 0, but the nodes {}; contact.restitution = 0 prevents the chatter",
        bounce, *run.restitution, here ? "chatter" : "will chatter");
  if (span)
    return bounce +
           ", and those of the fully discrete scheme do not: as epsilon goes to 0 the difference has a plateau; "
           "contact.restitution = 0 makes the two agree";
  return fmt::format(
      "{}{}; as epsilon goes to 0 {}the difference to the fully discrete scheme has a plateau; remedies: {}", bounce,
      here ? ": it may chatter, and every bounce costs steps" : "", here ? "" : "it will chatter, and ",
      chatter_remedies(setup, regime, regime.where));
}

double gap_of(const Scene& scene, Where where) {
  if (where == Where::span) return scene.span->gap;
  return std::get<Obstacle>(where == Where::left ? scene.left : scene.right).gap;
}

/// Obstacles that the bar does not come to, on the inner side of an end or on one side of a span: in most such scenes
/// one on the other side was meant.
std::vector<std::string> obstacles_that_stop_nothing(const Scene& scene, const std::vector<FirstImpact>& impacts) {
  std::vector<std::string> found;
  const auto tell = [&](Where where, const Obstacle& obstacle, const std::string& goes_on, std::string_view wanted) {
    if (std::ranges::count(impacts, where, &FirstImpact::where) > 0) return;
    const bool above = obstacle.side == Side::above;
    found.push_back(fmt::format(
        "the {} obstacle bounds u {} ({} {}), and the bar does not come to it{}; for {} write side = \"{}\" in [{}]",
        name(where), above ? "from above" : "from below", above ? "u <=" : "u >=",
        NumberText::terminal(scene)(above ? obstacle.gap : -obstacle.gap, Dimension::length, 6), goes_on, wanted,
        above ? "below" : "above", name(where)));
  };
  for (const SceneEnd& end : ends_of(scene)) {
    const auto* obstacle = std::get_if<Obstacle>(&end.condition);
    const bool right = end.x > 0.0;
    if (obstacle && (obstacle->side == Side::above) != right)
      tell(right ? Where::right : Where::left, *obstacle, fmt::format(": a bar that moves to the {} goes on", end.name),
           fmt::format("a wall on the {} of the bar", end.name));
  }
  if (scene.span && scene.span->side != Side::both) tell(Where::span, *scene.span, "", "one on its other side");
  return found;
}

std::vector<std::string> warnings_of(const Setup& setup, const BarSystem& system,
                                     const std::vector<ContactRegime>& regimes,
                                     const std::optional<Foresight>& foreseen) {
  const Case& run = setup.run;
  const NumberText number = NumberText::terminal(run.scene);
  std::vector<std::string> found;
  if (foreseen) found = obstacles_that_stop_nothing(run.scene, foreseen->impacts);
  if (!run.warning.empty()) found.push_back(run.warning);
  if (const auto strains = strain_remark(setup, system)) found.push_back(*strains);
  if (const auto jumps = jump_remark(setup, system)) found.push_back(*jumps);
  for (const SceneEnd& end : ends_of(run.scene)) {
    if (!is_fixed(end.condition)) continue;
    const auto& motion = end.input.motion;
    const double v = run.scene.velocity(end.x);
    if (!motion && v != 0.0)
      found.push_back(fmt::format("the {} end is fixed, but its initial velocity is {}: it is held still", end.name,
                                  number(v, Dimension::velocity, 6)));
    const double begins = motion ? motion->velocity(0.0) : 0.0;
    if (motion && std::abs(v - begins) > 1e-9 * std::max(std::abs(v), std::abs(begins)))
      found.push_back(
          fmt::format("the motion of the {} end begins with the velocity {}, but its initial velocity is "
                      "{}: the end goes with its motion at once, and sends a front",
                      end.name, number(begins, Dimension::velocity, 6), number(v, Dimension::velocity, 6)));
  }
  const auto met = [&](Where where) {
    return !foreseen || std::ranges::find(foreseen->impacts, where, &FirstImpact::where) != foreseen->impacts.end();
  };
  for (const ContactRegime& regime : regimes)
    if (regime.chatters && met(regime.where))
      found.push_back(advice(setup, regime, !foreseen || foreseen->chatters.value_or(true)));
  const double displacement = natural_scales(system, run.end).displacement;
  for (const ContactRegime& regime : regimes)
    if (const double gap = gap_of(run.scene, regime.where);
        regime.impact && is_no_obstacle(regime.impact->penetration, std::max(displacement, gap)))
      found.push_back(fmt::format(
          "{}: a penetration of {} is predicted, beside a gap of {} and displacements of {}: that is a spring rather "
          "than an obstacle; {}",
          name(regime.where), number(regime.impact->penetration, Dimension::length, 2),
          number(gap, Dimension::length, 2), number(displacement, Dimension::length, 2), stiffer_advice(setup)));
  return found;
}

/// The speed that a first impact will have tells more than the initial velocity, which may lead to none.
void predict(ContactRegime& regime, const std::optional<Foresight>& foreseen, double epsilon, const BarSystem& system) {
  if (!foreseen) return;
  const auto first = std::ranges::find(foreseen->impacts, regime.where, &FirstImpact::where);
  if (first == foreseen->impacts.end()) return regime.impact.reset(), regime.forecast.reset();
  if (regime.where == Where::span || first->speed == 0.0) return;
  const bool right = regime.where == Where::right;
  const auto [whole, h] = end_bar(system, right);
  if (regime.stop)
    regime.forecast =
        forecast({whole, h}, system.inputs()[right].mass, regime.effective_mass, *regime.stop, first->speed);
  else
    regime.impact = predict_impact(whole, h, regime.effective_mass, epsilon, first->speed);
}

Json to_json(const FirstImpact& impact) {
  return {{"where", name(ContactPlace{impact.where, impact.joint})},
          {"time", impact.time},
          {"speed", impact.speed},
          {"time_error", impact.time_error},
          {"speed_error", impact.speed_error}};
}

Json to_json(const ContactRegime& regime) {
  if (regime.stop) {
    const Stop& stop = *regime.stop;
    Json json = {{"where", name(regime.where)}, {"law", name(stop.law)}, {"stiffness", stop.stiffness}};
    if (has_damper(stop.law)) json["damping"] = stop.damping;
    const auto& found = regime.forecast;
    json["damping_ratio"] = found ? Json(found->damping_ratio) : Json(nullptr);
    json["restitution"] = found ? Json(found->restitution) : Json(nullptr);
    json["impact"] = found ? Json{{"speed", found->speed},
                                  {"predicted_penetration", found->penetration},
                                  {"predicted_peak", found->force}}
                           : Json(nullptr);
    return json;
  }
  Json json = {{"where", name(regime.where)},
               {"effective_mass", regime.effective_mass},
               {"damping_ratio", regime.damping_ratio},
               {"chatter_expected", regime.chatters},
               {"quiet_epsilon", regime.where == Where::span ? Json(nullptr) : Json(regime.quiet_epsilon)}};
  json["impact"] = regime.impact ? Json{{"speed", regime.impact->speed},
                                        {"predicted_penetration", regime.impact->penetration},
                                        {"by", name(regime.impact->layer)}}
                                 : Json(nullptr);
  return json;
}

}  // namespace

SceneCheck check_scene(const SceneFile& scene, const std::function<bool()>& stop) {
  constexpr double patience = 0.5;  // seconds
  Case settled = scene.run;
  accuracy::QuickEstimate forecast = scene.accuracy ? accuracy::forecast(settled, *scene.accuracy, patience, stop)
                                                    : accuracy::forecast(scene.run, patience, stop);
  const bool chosen = scene.accuracy && forecast.estimate;
  SceneFile as_run = chosen ? with_settings(scene, settled) : scene;
  const Setup setup = resolve(as_run.run);
  SceneCheck check{
      std::move(as_run), setup, setup.system(), foresee(setup, stop), {}, memory_need(setup.run), {}, 0, {}, {}};
  if (const auto words = too_small(check.system.initial_state(), check.system, setup.run.end))
    throw std::invalid_argument(*words);
  check.regimes = contact_regimes(setup, check.system);
  for (ContactRegime& regime : check.regimes) predict(regime, check.foreseen, setup.epsilon, check.system);
  check.error = std::move(forecast.estimate);
  check.error_elements = forecast.elements;
  check.no_error = std::move(forecast.why_not);
  check.warnings = warnings_of(setup, check.system, check.regimes, check.foreseen);
  if (check.error && !check.error->doubt.empty()) check.warnings.push_back("error: " + check.error->doubt);
  if (check.foreseen && check.foreseen->chatters == false)
    for (ContactRegime& regime : check.regimes) regime.chatters = false;
  return check;
}

std::string check_json(const SceneCheck& check) {
  const Case& run = check.setup.run;
  const BarSystem& system = check.system;
  Json json = Json::object();
  json["title"] = run.scene.title;
  json["method"] = name(run.method);
  json["method_requested"] = run.automatic ? automatic : name(run.method);
  if (run.method == MethodName::characteristics) json["passages"] = run.end / run.scene.bar.transit();
  if (run.method == MethodName::odeint)
    json["stepper"] = name(plan(system, run.end, std::get<Odeint>(check.setup.method)).stepper);
  json["nodes"] = system.mesh().nodes();
  json["unknown_nodes"] = system.size();
  json["spacing"] = system.mesh().spacing();
  if (!system.mesh().uniform()) json["smallest_element"] = system.mesh().smallest();
  json["mass"] = name(system.mass());
  json["why"] = {{"method", check.setup.why.method}, {"mass", check.setup.why.mass}};
  if (is_penalised(run.method) && has_penalty(run.scene)) json["why"]["epsilon"] = check.setup.why.epsilon;
  if (is_scheme(run.method)) json["why"]["step"] = check.setup.why.step;
  json["terms"] = {{"inertia", system.inertia().has_massless() ? "massless contact nodes" : "every node"},
                   {"elasticity", true},
                   {"damping", system.bar().damped()},
                   {"load", load_kind(run.scene)},
                   {"contact", system.contacts().empty() ? Json(nullptr) : Json(contact_kind(check.setup))}};
  if (!run.scene.chain.empty()) json["terms"]["members"] = member_texts(run.scene);
  if (run.scene.section) json["terms"]["section"] = section_text(run.scene);
  if (run.scene.side) json["terms"]["side"] = side_text(run.scene);
  for (const SceneEnd& end : ends_of(run.scene))
    if (const auto words = inputs_text(run.scene, end_bar(system, end.name == std::string_view("right")).bar, end);
        !words.empty())
      json["terms"][end.name] = words;
  json["contact_nodes"] = system.contacts().size();
  json["event_functions"] = is_scheme(run.method) ? 0 : system.contacts().size();
  json["memory"] = {{"vectors", std::llround(check.memory.vectors)}, {"bytes", std::llround(check.memory.bytes)}};
  json["contacts"] = Json::array();
  for (const ContactRegime& regime : check.regimes) json["contacts"].push_back(to_json(regime));
  json["first_impacts"] = check.foreseen ? Json::array() : Json(nullptr);
  if (check.foreseen)
    for (const FirstImpact& impact : check.foreseen->impacts) json["first_impacts"].push_back(to_json(impact));
  json["error"] = nullptr;
  if (const auto& error = check.error)
    json["error"] = {
        {"total", error->total}, {"space", error->space}, {"penalty", error->penalty}, {"time", error->time}};
  json["error_estimate"] = check.error ? to_json(*check.error) : Json(nullptr);
  if (check.error) json["error_estimate"]["elements"] = check.error_elements;
  json["warnings"] = check.warnings;
  tell(json, check.scene);
  return json_text(json);
}

}  // namespace viscobar

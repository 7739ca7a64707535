#include <fmt/format.h>

#include <cmath>
#include <stdexcept>

#include "case/scene_numbers.hpp"
#include "input/scene_chain.hpp"
#include "input/scene_entries.hpp"
#include "input/scene_stop.hpp"
#include "text/nearest_name.hpp"

namespace viscobar {

namespace {

// d/dp at a fixed part x / L of the bar: of a parameter the derivative, of the length L that by x, times x / L.
SpaceTimeFunction at_fixed_part(SpaceTimeFunction slope, const std::string& by, double length) {
  if (!slope || by != "x") return slope;
  return [slope, length](double x, double t) { return x / length * slope(x, t); };
}

SpaceTimeFunction rate(const Formula& formula, const std::string& by, double length) {
  return at_fixed_part(formula.derivative(by), by, length);
}

SpaceFunction rate_of_x(const Formula& formula, const std::string& by, double length) {
  const SpaceTimeFunction slope = at_fixed_part(formula.mean_derivative(by, length), by, length);
  if (!slope) return [](double) { return 0.0; };
  return [slope](double x) { return slope(x, 0.0); };
}

// Derivative of L f by p, divided by L; `stretched` is L' / L.
std::optional<Load> rate_of_load(const SceneEntries& entries, const std::string& by, double length, double stretched) {
  const auto with_mass = [stretched](const SpaceTimeFunction& f, const SpaceTimeFunction& slope) {
    return [=](double x, double t) { return (slope ? slope(x, t) : 0.0) + stretched * f(x, t); };
  };
  const auto [density, profile, history] = LoadFormulas(entries);
  if (density) {
    const SpaceTimeFunction slope = rate(*density, by, length);
    if (!slope && stretched == 0.0) return std::nullopt;
    const auto f = with_mass(density->of_x_t(), slope);
    if (!density->uses('t')) return SteadyLoad{[f](double x) { return f(x, 0.0); }, density->places(length)};
    return GeneralLoad{f, density->breaks_and_pulses(length), density->breaks_at(), density->breaks_in_x_at()};
  }
  if (!profile || !history) return std::nullopt;
  const SpaceTimeFunction of_profile = rate(*profile, by, length), of_history = rate(*history, by, length);
  if (!of_profile && !of_history && stretched == 0.0) return std::nullopt;
  const auto moved = with_mass(profile->of_x_t(), of_profile);
  const NextBreak breaks = history->breaks_and_pulses(0.0);
  const Places places = profile->places(length);
  const SeparableLoad by_profile{[moved](double x) { return moved(x, 0.0); }, history->of_t(), breaks, places};
  if (!of_history) return by_profile;
  SeparableLoad rate{profile->of_x(), [of_history](double t) { return of_history(0.0, t); }, breaks, places};
  if (of_profile || stretched != 0.0) rate.plus = std::make_shared<SeparableLoad>(by_profile);
  return rate;
}

// Adds the derivatives of the force and motion of an end, and of the gap of its obstacle at the start.
void add_rates_of_end(const SceneEntries& entries, const std::string& side, const EndInput& input,
                      const std::string& by, EndCondition& end, EndInput& rates) {
  const auto dependent = [&](const char* key) {
    auto formula = entries.formula(side + key);
    if (formula && !formula->derivative(by)) formula.reset();
    return formula;
  };
  if (const auto force = dependent(".force"))
    rates.force = EndForce{force->derivative_of_t(0, by), force->breaks_and_pulses(0.0), force->is_constant()};
  if (const auto moved = dependent(".motion"); moved && input.motion) rates.motion = motion_of(*moved, by, 1.0, 0.0);
  if (auto* obstacle = std::get_if<Obstacle>(&end))
    if (const auto gap = dependent(".gap")) {
      obstacle->gap = gap->derivative_of_t(0, by)(0.0);
      if (input.motion) rates.motion = motion_of_gap(*gap, by, *obstacle);
    }
}

}  // namespace

EndMotion motion_of(const Formula& f, const std::string& by, double scale, double offset) {
  if (f.series()) {
    const characteristics::FunctionOfTime of = function_of(f.series());
    const auto scaled = [scale](const TimeFunction& one, double plus) -> TimeFunction {
      return [=](double t) { return scale * one(t) + plus; };
    };
    return {scaled(of.motion.displacement, scale * of.start + offset), scaled(of.motion.velocity, 0.0),
            scaled(of.motion.acceleration, 0.0), of.motion.breaks};
  }
  const auto derivative = [&](int order, double plus) -> TimeFunction {
    return [of = f.derivative_of_t(order, by), scale, plus](double t) { return scale * of(t) + plus; };
  };
  return {derivative(0, offset), derivative(1, 0.0), derivative(2, 0.0), f.breaks_and_pulses(0.0)};
}

EndMotion motion_of_gap(const Formula& gap, const std::string& by, const Obstacle& obstacle) {
  const double sign = obstacle.side == Side::above ? -1.0 : 1.0;
  return motion_of(gap, by, -sign, sign * obstacle.gap);
}

Direction direction_of(const SceneEntries& entries, const Case& run, const std::string& key) {
  const bool parameter = is_parameter(key), length = key == "bar.length";
  const auto member = member_key("bar", key);
  const bool of_member = member && member->second == "length";
  const std::string by(length || of_member ? "x" : parameter ? parameter_name(key) : "");
  if (parameter && !entries.parameters().contains(by)) {
    std::vector<std::string> names;
    for (const auto& [name, value] : entries.parameters()) names.push_back(name);
    const auto nearest = nearest_name(by, names);
    throw std::invalid_argument(fmt::format("{}: [parameters] has no such name{}", key,
                                            nearest ? fmt::format("; nearest is \"{}\"", *nearest) : ""));
  }
  const bool section = key == "bar.section" || (member && member->second == "section");
  if (key.starts_with("side.") || section)
    if (const auto formula = entries.formula(key); formula && !formula->is_constant())
      throw std::invalid_argument(fmt::format(
          "{}: no sensitivity with respect to it: it varies along the bar; give a number in it a name below "
          "[parameters], and take parameters.NAME",
          key));
  if (const auto given = damping_by(entries, key)) {
    Direction along = direction(run, given->first);
    along.key = key;
    for (EndInput* end : {&along.data.left_input, &along.data.right_input})
      if (end->stop) end->stop->damping *= given->second;
    if (key == "contact.restitution" && has_penalty(run.scene)) along.restitution = 1.0;
    return along;
  }
  Direction along = direction(run, parameter || section ? "" : key);
  std::vector<std::string> sections = {"bar.section"};
  if (const std::size_t count = run.scene.chain.size(); count > 0) {
    sections.clear();
    for (std::size_t k = 1; k <= count; ++k) sections.push_back(fmt::format("bar.{}.section", k));
  }
  if (parameter || section) {
    if (section && !entries.formula(key))
      throw std::invalid_argument(fmt::format("{}: no sensitivity with respect to it: it is not given", key));
    std::vector<SpaceFunction> rates(sections.size());
    for (std::size_t k = 0; k < sections.size(); ++k)
      if (const auto formula = entries.formula(sections[k]); formula && key == sections[k])
        rates[k] = [](double) { return 1.0; };
      else if (const SpaceTimeFunction slope = formula && parameter ? formula->derivative(by) : nullptr)
        rates[k] = [slope](double x) { return slope(x, 0.0); };
    vary_sections(along, run, rates);
  }
  along.key = key;
  if (!parameter && !length && !of_member) return along;
  std::vector<std::string> formulas = of_member ? std::vector{sections.at(member->first - 1)} : sections;
  formulas.insert(formulas.end(), {"initial.displacement", "initial.velocity", "load.density", "load.profile",
                                   "load.history", "left.force", "right.force", "left.motion", "right.motion",
                                   "left.gap", "right.gap", "side.stiffness", "side.drag"});
  for (std::size_t k = 1; k <= run.scene.chain.size(); ++k)
    for (const char* leaf : {"displacement", "velocity"}) formulas.push_back(fmt::format("bar.{}.{}", k, leaf));
  for (const std::string& name : formulas)
    if (const auto formula = entries.formula(name); formula && formula->moves_jump(by))
      throw std::invalid_argument(
          fmt::format("{}: a condition in {} depends on {}, and a jump that moves has no derivative", key, name, by));
  const double size = run.scene.bar.length;
  const auto displacement = entries.formula("initial.displacement"), velocity = entries.formula("initial.velocity");
  if (displacement) along.data.displacement = rate_of_x(*displacement, by, size);
  if (velocity) along.data.velocity = rate_of_x(*velocity, by, size);
  if (!run.scene.chain.empty()) differentiate_chain(entries, by, of_member ? member->first : 0, along.data);
  if (!of_member) along.data.load = rate_of_load(entries, by, size, length ? 1.0 / size : 0.0);
  along.data.side.reset();
  // The length of one of several bars moves the others: its scenes beside have the side at their own x.
  const auto rate_of_side = [&](const char* name) -> SpaceFunction {
    const auto formula = entries.formula(name);
    return run.scene.side && !of_member && formula && formula->derivative(by) ? rate_of_x(*formula, by, size) : nullptr;
  };
  if (SideResistance rates{rate_of_side("side.stiffness"), rate_of_side("side.drag")}; rates.stiffness || rates.drag) {
    rates.stiffness_places = run.scene.side->stiffness_places, rates.drag_places = run.scene.side->drag_places;
    along.data.side = std::move(rates);
  }
  if (parameter) {
    add_rates_of_end(entries, "left", run.scene.left_input, by, along.data.left, along.data.left_input);
    add_rates_of_end(entries, "right", run.scene.right_input, by, along.data.right, along.data.right_input);
    if (const auto gap = entries.formula("span.gap"); gap && along.data.span && gap->derivative(by))
      along.data.span->gap = gap->derivative_of_t(0, by)(0.0);
  }
  const Mesh mesh = run.mesh();
  for (std::size_t j = 0; j < mesh.nodes(); ++j)
    if (!std::isfinite(along.data.displacement(mesh.node(j))) || !std::isfinite(along.data.velocity(mesh.node(j))))
      throw std::invalid_argument(fmt::format("{}: the initial data have no derivative at x = {}", key, mesh.node(j)));
  return along;
}

}  // namespace viscobar

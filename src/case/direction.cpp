#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <stdexcept>
#include <tuple>
#include <utility>
#include <vector>

#include "case/scene_numbers.hpp"
#include "text/number.hpp"

namespace viscobar {

namespace {

// Derivative of f by L at fixed x / L: x / L times the slope of f, by central differences.
SpaceFunction carried(const SpaceFunction& f, double length) {
  return [f, length](double x) {
    const double step = 1e-5 * length, low = x - step < 0.0 ? x : x - step, high = x + step > length ? x : x + step;
    if (low == x) return x / length * (-3.0 * f(x) + 4.0 * f(x + step) - f(x + 2.0 * step)) / (2.0 * step);
    if (high == x) return x / length * (3.0 * f(x) - 4.0 * f(x - step) + f(x - 2.0 * step)) / (2.0 * step);
    return x / length * (f(high) - f(low)) / (2.0 * step);
  };
}

Load carried_load(const Load& load, double length) {
  const auto with_mass = [length](const SpaceFunction& f) {
    return [slope = carried(f, length), f, length](double x) { return f(x) / length + slope(x); };
  };
  if (const auto* steady = std::get_if<SteadyLoad>(&load))
    return SteadyLoad{with_mass(steady->profile), steady->places};
  if (const auto* separable = std::get_if<SeparableLoad>(&load))
    return SeparableLoad{with_mass(separable->profile), separable->history, separable->breaks, separable->places};
  const auto& general = std::get<GeneralLoad>(load);
  const auto density = [f = general.density, length](double x, double t) {
    const SpaceFunction now = [&](double at) { return f(at, t); };
    return now(x) / length + carried(now, length)(x);
  };
  return GeneralLoad{density, general.breaks, general.breaks_at, general.breaks_in_x};
}

constexpr std::pair<std::string_view, double Bar::*> of_bar[] = {{"bar.length", &Bar::length},
                                                                 {"bar.density", &Bar::density},
                                                                 {"bar.modulus", &Bar::modulus},
                                                                 {"bar.viscosity", &Bar::viscosity}};
constexpr std::pair<std::string_view, double Joint::*> of_joint[] = {
    {"gap", &Joint::gap}, {"stiffness", &Joint::stiffness}, {"damping", &Joint::damping}};
constexpr std::pair<std::string_view, double EndInput::*> of_end[] = {
    {"stiffness", &EndInput::stiffness}, {"dashpot", &EndInput::dashpot}, {"mass", &EndInput::mass}};

double* found(auto& owner, const auto& numbers, std::string_view leaf) {
  for (const auto& [name, number] : numbers)
    if (leaf == name) return &(owner.*number);
  return nullptr;
}

}  // namespace

std::optional<std::pair<std::size_t, std::string_view>> member_key(std::string_view table, std::string_view key) {
  if (!key.starts_with(table) || key.size() <= table.size() || key[table.size()] != '.') return std::nullopt;
  const std::string_view rest = key.substr(table.size() + 1);
  const std::size_t dot = rest.find('.');
  const auto number = dot == rest.npos ? std::nullopt : number_in<std::size_t>(rest.substr(0, dot));
  if (!number || *number == 0) return std::nullopt;
  return std::pair(*number, rest.substr(dot + 1));
}

double* number_of(std::vector<Member>& chain, std::string_view key) {
  if (const auto of_bar_k = member_key("bar", key); of_bar_k && of_bar_k->first <= chain.size()) {
    Member& member = chain[of_bar_k->first - 1];
    if (of_bar_k->second == "mass") return member.rigid() ? &member.mass : nullptr;
    if (member.rigid()) return nullptr;
    for (const auto& [name, number] : of_bar)
      if (name.substr(4) == of_bar_k->second) return &(member.bar.*number);
  }
  const auto of = member_key("joint", key);
  if (!of || of->first >= chain.size()) return nullptr;
  Joint& joint = chain[of->first - 1].joint;
  const bool of_kind = joint.kind == (of->second == "gap" ? JointKind::contact : JointKind::spring);
  return of_kind ? found(joint, of_joint, of->second) : nullptr;
}

SpaceFunction along(std::vector<Member> chain, SpaceFunction Member::*own) {
  return [chain = std::move(chain), own](double x) {
    const Member* at = &chain.front();
    double begin = 0.0, begin_of = 0.0;
    for (const Member& member : chain) {
      if (!member.rigid() && (x > begin || at->rigid())) at = &member, begin_of = begin;
      begin += member.bar.length;
    }
    if (x <= 0.0) at = &chain.front();
    if (x >= begin && chain.back().rigid()) at = &chain.back(), begin_of = begin;
    return (at->*own)(x - begin_of);
  };
}

double* number_of(Bar& bar, Scene& scene, std::string_view key) {
  if (double* number = found(bar, of_bar, key)) return number;
  for (const bool right : {false, true}) {
    const std::string_view end = right ? "right." : "left.";
    if (!key.starts_with(end)) continue;
    const std::string_view leaf = key.substr(end.size());
    auto* obstacle = std::get_if<Obstacle>(right ? &scene.right : &scene.left);
    if (leaf == "gap" && obstacle) return &obstacle->gap;
    if (double* number = found(right ? scene.right_input : scene.left_input, of_end, leaf)) return number;
  }
  return nullptr;
}

double* number_of(Case& run, std::string_view key) {
  if (key != "contact.restitution") return number_of(run.scene.bar, run.scene, key);
  if (!run.restitution) run.restitution = 0.0;
  return &*run.restitution;
}

namespace {

// The scenes that change(scene, -apart) and change(scene, apart) make of that.
Direction::Beside beside(const Case& run, double apart, const std::function<void(Scene&, double)>& change) {
  std::array<Case, 2> both{run, run};
  for (const bool after : {false, true}) {
    both[after].scene.left_input.motion.reset(), both[after].scene.right_input.motion.reset();
    change(both[after].scene, after ? apart : -apart);
  }
  return {both[0].scene, both[1].scene, both[0].mesh(), both[1].mesh(), apart};
}

// Data by moments, or by values at nodes, are so in the scenes beside, too: none of their breaks beyond the end of a
// chain, at `whole`, comes inside one that is longer, and one at the end leaves none that is shorter.
void keep_within(double whole, Places& places) {
  if (!places.breaks) return;
  places.by_moments |= places.breaks(0.0, whole).has_value();
  places.breaks = [breaks = places.breaks, whole](double after, double until) {
    const auto next = breaks(after, until);
    return next && *next < whole ? next : std::nullopt;
  };
}

void keep_within(double whole, Scene& scene) {
  keep_within(whole, scene.velocity_places);
  if (scene.side) keep_within(whole, scene.side->stiffness_places), keep_within(whole, scene.side->drag_places);
  if (auto* steady = scene.load ? std::get_if<SteadyLoad>(&*scene.load) : nullptr) keep_within(whole, steady->places);
  if (auto* separable = scene.load ? std::get_if<SeparableLoad>(&*scene.load) : nullptr)
    keep_within(whole, separable->places);
}

// A bar that is `length` long, from `begin` on, is longer by that: what moves with the nodes has breaks there.
NextBreak moved(const NextBreak& breaks, double begin, double length, double by) {
  if (!breaks) return breaks;
  return [=](double after, double until) {
    const auto then = [&](double x) { return x - by * std::clamp((x - begin) / (length + by), 0.0, 1.0); };
    std::optional<double> next = breaks(then(after), then(until));
    if (next) *next += by * std::clamp((*next - begin) / length, 0.0, 1.0);
    return next;
  };
}

// True where bonded members have unlike velocities, which enter by their moments: so do derivatives, be they alike.
bool meet_unlike(const std::vector<Member>& chain) {
  for (std::size_t k = 0; k + 1 < chain.size(); ++k) {
    const Member &one = chain[k], &next = chain[k + 1];
    if (one.joint.kind == JointKind::bonded && one.velocity(one.rigid() ? 0.0 : one.bar.length) != next.velocity(0.0))
      return true;
  }
  return false;
}

// Its errors are some 1e-10 of a derivative, by its square and by rounding.
constexpr double share_of_difference = 1e-5;

}  // namespace

void vary_sections(Direction& along, const Case& run, const std::vector<SpaceFunction>& rates) {
  const auto section_of = [](auto& scene, std::size_t m) -> auto& {
    return scene.chain.empty() ? scene.section : scene.chain[m].section;
  };
  double fastest = 0.0;
  for (std::size_t m = 0; m < rates.size(); ++m) {
    const double length = run.scene.chain.empty() ? run.scene.bar.length : run.scene.chain[m].bar.length;
    for (int k = 0; k <= 200 && rates[m]; ++k)
      fastest =
          std::max(fastest, std::abs(rates[m](length * k / 200.0) / section_of(run.scene, m)(length * k / 200.0)));
  }
  if (fastest == 0.0) return;
  along.beside = beside(run, share_of_difference / fastest, [&](Scene& scene, double by) {
    for (std::size_t m = 0; m < rates.size(); ++m)
      if (SpaceFunction& section = section_of(scene, m); rates[m])
        section = [of = section, rate = rates[m], by](double x) { return of(x) + by * rate(x); };
  });
}

Direction direction(const Case& run, std::string_view key) {
  const Scene& scene = run.scene;
  Direction along;
  along.key = key;
  Scene& data = along.data;
  data.bar = scene.bar;
  data.section = scene.section, data.section_places = scene.section_places;
  data.displacement = data.velocity = [](double) { return 0.0; };
  data.left = scene.left, data.right = scene.right, data.span = scene.span;
  for (Obstacle* obstacle :
       {std::get_if<Obstacle>(&data.left), std::get_if<Obstacle>(&data.right), data.span ? &*data.span : nullptr})
    if (obstacle) obstacle->gap = 0.0;
  data.chain = along.members = scene.chain;
  if (!scene.chain.empty() || key == "bar.length" || key.empty())
    data.displacement_places = scene.displacement_places, data.velocity_places = scene.velocity_places;
  data.velocity_places.by_moments = meet_unlike(scene.chain);
  for (Member& member : data.chain) member.joint.gap = 0.0, member.displacement = member.velocity = data.displacement;
  double* place = scene.chain.empty() || !key.starts_with("bar.") ? number_of(along.bar, data, key) : nullptr;
  if (double* of_member = number_of(along.members, key))
    place = key.ends_with(".gap") ? number_of(data.chain, key) : of_member;
  for (Member& member : along.members) {
    member.bar = {0.0, 0.0, 0.0, 0.0}, member.mass = 0.0;
    member.joint.stiffness = member.joint.damping = 0.0;
    if (member.joint.stop) member.joint.stop->stiffness = member.joint.stop->damping = 0.0;
  }
  if (key == "span.gap" && data.span) place = &data.span->gap;
  if (key == "contact.epsilon") place = &along.epsilon;
  if (key == "contact.restitution") place = &along.restitution;
  // The numbers of stops: of an end's own, or of all that have those of [contact].
  std::vector<double*> of_stops;
  bool lets_go_from_here = false;
  for (const auto& [end, input, rates] :
       {std::tuple{"left", &scene.left_input, &data.left_input}, {"right", &scene.right_input, &data.right_input}}) {
    if (!input->stop) continue;
    rates->stop = *input->stop;
    rates->stop->stiffness = rates->stop->damping = 0.0;
    if (key == input->stop->key(end, "stiffness")) of_stops.push_back(&rates->stop->stiffness);
    if (key == input->stop->key(end, "damping") && has_damper(input->stop->law)) {
      of_stops.push_back(&rates->stop->damping);
      lets_go_from_here = input->stop->linear() && input->stop->damping == 0.0;
    }
  }
  for (std::size_t k = 0; k + 1 < scene.chain.size(); ++k) {
    const auto& stop = scene.chain[k].joint.stop;
    const std::string table = fmt::format("joint.{}", k + 1);
    if (!stop) continue;
    if (key == stop->key(table, "stiffness")) of_stops.push_back(&along.members[k].joint.stop->stiffness);
    if (key == stop->key(table, "damping") && has_damper(stop->law)) {
      of_stops.push_back(&along.members[k].joint.stop->damping);
      lets_go_from_here |= stop->linear() && stop->damping == 0.0;
    }
  }
  if (key.empty()) return along;
  const auto refuse = [&](const std::string& why) {
    throw std::invalid_argument(fmt::format("{}: no sensitivity with respect to it: {}", key, why));
  };
  if (key == "side.stiffness" || key == "side.drag") {
    SpaceFunction SideResistance::*part = key == "side.drag" ? &SideResistance::drag : &SideResistance::stiffness;
    if (!scene.side || !((*scene.side).*part)) refuse("nothing resists the bar along its length in that way");
    data.side.emplace().*part = [](double) { return 1.0; };
    return along;
  }
  if (lets_go_from_here) refuse("the time at which a stop opens has a kink at 0; give a positive damping");
  for (double* number : of_stops) *number = 1.0;
  if (!of_stops.empty()) return along;
  if (key.find("contact.") != key.npos && (key.ends_with(".stiffness") || key.ends_with(".damping")))
    refuse("no stop of the scene has this number");
  if (!place && (key == "left.gap" || key == "right.gap" || key == "span.gap"))
    refuse("the scene has no such obstacle");
  if (!place)
    refuse(
        "known are bar.length, bar.density, bar.modulus, bar.viscosity (of bars in line bar.1.length, bar.1.mass and so "
        "on, joint.1.gap, joint.1.stiffness, joint.1.damping), left.gap, right.gap, span.gap, left.stiffness, "
        "left.dashpot, left.mass, right.stiffness, right.dashpot, right.mass, contact.epsilon, contact.restitution, "
        "side.stiffness, side.drag, the numbers of contact laws, and parameters.NAME");
  if ((key.starts_with("left.") && is_fixed(scene.left)) || (key.starts_with("right.") && is_fixed(scene.right)))
    if (!key.ends_with(".gap")) refuse("a fixed end has no spring, no dashpot and no mass");
  if (key == "contact.epsilon" && !(is_penalised(run.method) && has_penalty(scene)))
    refuse("the run has no penalised contact");
  if (key == "contact.restitution") {
    if (!meets_obstacle(scene)) refuse("the scene has no obstacle");
    if (is_penalised(run.method) && run.restitution == 0.0)
      refuse("the dashpot of a penalised contact has none at 0; take rigid, or a positive restitution");
  }
  *place = 1.0;
  const auto of_chain = member_key("bar", key);
  if (of_chain && of_chain->second == "length") {
    const std::size_t m = of_chain->first - 1;
    const Member& member = scene.chain[m];
    const double length = member.bar.length;
    if (scene.load || scene.side) {
      *place = 0.0;
      double begin = 0.0;
      for (std::size_t k = 0; k < m; ++k) begin += scene.chain[k].bar.length;
      along.beside = beside(run, share_of_difference * length, [&](Scene& longer, double by) {
        Member& own = longer.chain[m];
        own.bar.length += by;
        for (SpaceFunction* f : {&own.displacement, &own.velocity})
          *f = [of = *f, share = length / own.bar.length](double x) { return of(x * share); };
        longer.bar = whole_of(longer.chain);
        keep_within(scene.bar.length, longer);
        longer.velocity_places.breaks = moved(longer.velocity_places.breaks, begin, length, by);
      });
    } else if (member.section) {
      std::vector<SpaceFunction> rates(scene.chain.size());
      rates[m] = carried(member.section, length);
      vary_sections(along, run, rates);
    }
    Member& rate = data.chain[of_chain->first - 1];
    rate.displacement = carried(member.displacement, member.bar.length);
    rate.velocity = carried(member.velocity, member.bar.length);
    data.displacement = viscobar::along(data.chain, &Member::displacement);
    data.velocity = viscobar::along(data.chain, &Member::velocity);
  }
  if (key == "bar.length") {
    if (scene.section) vary_sections(along, run, {carried(scene.section, scene.bar.length)});
    if (scene.side)
      along.data.side =
          SideResistance{scene.side->stiffness ? carried(scene.side->stiffness, scene.bar.length) : nullptr,
                         scene.side->drag ? carried(scene.side->drag, scene.bar.length) : nullptr,
                         scene.side->stiffness_places, scene.side->drag_places};
    data.displacement = carried(scene.displacement, scene.bar.length);
    data.velocity = carried(scene.velocity, scene.bar.length);
    if (scene.load) data.load = carried_load(*scene.load, scene.bar.length);
  }
  return along;
}

}  // namespace viscobar

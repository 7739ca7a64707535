#include <fmt/format.h>

#include <stdexcept>
#include <utility>

#include "viscobar/case/case.hpp"

namespace viscobar {

namespace {

// Of a function of x at x / L, as L grows: x / L times its slope, by central differences.
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
  if (const auto* steady = std::get_if<SteadyLoad>(&load)) return SteadyLoad{with_mass(steady->profile)};
  if (const auto* separable = std::get_if<SeparableLoad>(&load))
    return SeparableLoad{with_mass(separable->profile), separable->history, separable->breaks};
  const auto& general = std::get<GeneralLoad>(load);
  const auto density = [f = general.density, length](double x, double t) {
    const SpaceFunction now = [&](double at) { return f(at, t); };
    return now(x) / length + carried(now, length)(x);
  };
  return GeneralLoad{density, general.breaks, general.breaks_at};
}

}  // namespace

Direction direction(const Case& run, std::string_view key) {
  const Scene& scene = run.scene;
  Direction along;
  along.key = key;
  Scene& data = along.data;
  data.bar = scene.bar;
  data.displacement = data.velocity = [](double) { return 0.0; };
  data.left = scene.left, data.right = scene.right, data.span = scene.span;
  const auto obstacle = [&](EndCondition& end) { return std::get_if<Obstacle>(&end); };
  for (EndCondition* end : {&data.left, &data.right})
    if (Obstacle* bound = obstacle(*end)) bound->gap = 0.0;
  if (data.span) data.span->gap = 0.0;
  const auto refuse = [&](const char* why) {
    throw std::invalid_argument(fmt::format("{}: no sensitivity with respect to it: {}", key, why));
  };
  const auto gap = [&](Obstacle* of) {
    if (!of) refuse("the scene has no such obstacle");
    of->gap = 1.0;
  };
  const auto mount = [&](const EndCondition& end, double& of) {
    if (is_fixed(end)) refuse("a fixed end has no spring and no dashpot");
    of = 1.0;
  };
  const bool contact = is_obstacle(scene.left) || is_obstacle(scene.right) || scene.span;
  if (key == "bar.density") {
    along.bar.density = 1.0;
  } else if (key == "bar.modulus") {
    along.bar.modulus = 1.0;
  } else if (key == "bar.viscosity") {
    along.bar.viscosity = 1.0;
  } else if (key == "bar.length") {
    along.bar.length = 1.0;
    data.displacement = carried(scene.displacement, scene.bar.length);
    data.velocity = carried(scene.velocity, scene.bar.length);
    if (scene.load) data.load = carried_load(*scene.load, scene.bar.length);
  } else if (key == "left.gap") {
    gap(obstacle(data.left));
  } else if (key == "right.gap") {
    gap(obstacle(data.right));
  } else if (key == "span.gap") {
    gap(data.span ? &*data.span : nullptr);
  } else if (key == "left.stiffness") {
    mount(scene.left, data.left_input.stiffness);
  } else if (key == "left.dashpot") {
    mount(scene.left, data.left_input.dashpot);
  } else if (key == "right.stiffness") {
    mount(scene.right, data.right_input.stiffness);
  } else if (key == "right.dashpot") {
    mount(scene.right, data.right_input.dashpot);
  } else if (key == "contact.epsilon") {
    if (!is_penalised(run.method) || !contact) refuse("the run has no penalised contact");
    along.epsilon = 1.0;
  } else if (key == "contact.restitution") {
    if (!contact) refuse("the scene has no obstacle");
    if (is_penalised(run.method) && run.restitution == 0.0)
      refuse("the dashpot of a penalised contact has none at 0; take rigid, or a positive restitution");
    along.restitution = 1.0;
  } else {
    refuse(
        "known are bar.length, bar.density, bar.modulus, bar.viscosity, left.gap, right.gap, span.gap, "
        "left.stiffness, left.dashpot, right.stiffness, right.dashpot, contact.epsilon, contact.restitution and parameters.NAME");
  }
  return along;
}

}  // namespace viscobar

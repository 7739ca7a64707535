#include "case/regime.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <utility>

#include "case/massless.hpp"
#include "case/method_table.hpp"
#include "dynamics/jumps/jump_filter.hpp"
#include "dynamics/natural_scales.hpp"
#include "dynamics/penalised_system.hpp"
#include "dynamics/pieces.hpp"

namespace viscobar {

namespace {

// Peak of the node's own oscillator, in units of V / omega.
double node_peak(double zeta) {
  // Beyond critical damping the node creeps up to the force of its neighbour's dashpot.
  if (zeta >= 1.0) return 2.0 * zeta;
  const double angle = std::numbers::pi - std::acos(zeta);
  return 2.0 * zeta + std::exp(-zeta * angle / std::sqrt(1.0 - zeta * zeta));
}

double viscous_ratio(const Bar& bar, double spacing, double effective_mass, double stiffness) {
  return bar.viscosity / spacing / (2.0 * std::sqrt(stiffness * effective_mass));
}

}  // namespace

std::string stiffer_advice(const Setup& setup) {
  const Scene& scene = setup.run.scene;
  Case open = setup.run;
  open.epsilon.reset();
  return fmt::format(
      "contact.epsilon = {:.3g} is a stop of stiffness {:.3g}, {:.2g} of {}, at which it gives way as the bar does: "
      "right if such a stop is meant; for a rigid obstacle take {:.2g}, or leave it out (--set contact.epsilon=)",
      setup.epsilon, 1.0 / setup.epsilon, setup.epsilon / natural_epsilon(scene), natural_epsilon_words(scene),
      resolve(std::move(open)).epsilon);
}

ImpactPrediction predict_impact(const Bar& bar, double spacing, double effective_mass, double epsilon, double speed) {
  const double rho = bar.density, eta = bar.viscosity, h = spacing;
  const bool resolved = epsilon * eta * eta > rho * h * h * h || epsilon * bar.modulus > h;
  const double elastic = epsilon * std::sqrt(rho * bar.modulus);
  // cbrt(epsilon^2 rho eta); no root is taken of a number with a unit, whose digits would depend on that.
  const double viscous = 0.858 * elastic * std::cbrt(eta / (bar.modulus * elastic));
  using Layer = ImpactPrediction::Layer;
  const auto at_speed = [speed](double penetration, Layer layer) {
    return ImpactPrediction{speed, speed * penetration, layer};
  };
  // All the energy of the bar in the spring.
  const double whole = std::sqrt(rho * bar.length * epsilon);
  if (whole < std::max(viscous, elastic) && epsilon * bar.modulus > bar.length) return at_speed(whole, Layer::bar);
  if (resolved) return viscous > elastic ? at_speed(viscous, Layer::viscous) : at_speed(elastic, Layer::elastic);
  if (effective_mass == 0.0) {
    // Nothing stops alone: what resists is the dashpot or the wave behind, whichever is stiffer.
    const double dashpot = epsilon * eta / h;
    return dashpot > elastic ? at_speed(dashpot, Layer::node) : at_speed(elastic, Layer::elastic);
  }
  const double zeta = viscous_ratio(bar, h, effective_mass, 1.0 / epsilon);
  return {speed, speed * std::sqrt(effective_mass * epsilon) * node_peak(zeta), Layer::node};
}

namespace {

// N = k d^(3/2) (1 + lambda d'): with a = lambda V and G(v) = v / lambda - ln(1 + lambda v) / lambda^2
//
//     (2 k / (5 m)) d^(5/2) = G(V) - G(v),    a (1 + e) = ln((1 + a) / (1 - a e)).
StopForecast proportionally_damped_mass(double mass, const Stop& stop, double speed) {
  const double lambda = stop.damping, a = lambda * speed;
  StopForecast found{.speed = speed};
  const auto depth = [&](double v) {
    const double left = (speed - v) / lambda - (std::log1p(a) - std::log1p(lambda * v)) / (lambda * lambda);
    return std::pow(2.5 * mass / stop.stiffness * std::max(left, 0.0), 0.4);
  };
  double low = 0.0, high = std::min(1.0, 1.0 / a);
  for (int k = 0; k < 200; ++k) {
    const double e = 0.5 * (low + high);
    (a * (1.0 + e) > std::log1p(a) - std::log1p(-a * e) ? low : high) = e;
  }
  found.restitution = low;
  found.penetration = depth(0.0);
  for (int k = 0; k <= 1000; ++k) {
    const double v = speed * (1.0 - 0.001 * k);
    found.force = std::max(found.force, stop.force(depth(v), v));
  }
  return found;
}

// m x'' = -N(x, x'), by the classical formulas of order 4.
StopForecast integrated_mass(double mass, const Stop& stop, double speed) {
  StopForecast found{.speed = speed, .restitution = 1.0};
  double shallow = 0.0, deep = 1.0;  // without damping all its energy is in the spring
  const double energy = 0.5 * mass * speed * speed;
  while (stop.energy(deep) < energy) deep *= 2.0;
  while (deep - shallow > 1e-3 * deep)
    (stop.energy(0.5 * (shallow + deep)) < energy ? shallow : deep) = 0.5 * (shallow + deep);
  const double stiffest = std::max(stop.by_rate(deep, speed), stop.by_rate(deep, 0.0)) / mass;
  const double h = std::min(2e-3 * deep / speed, 0.2 / stiffest);
  double x = 0.0, v = speed;
  const auto slope = [&](double at, double rate) { return -std::max(0.0, stop.force(std::max(at, 0.0), rate)) / mass; };
  for (int step = 0; step < 1000000; ++step) {
    const double force = stop.force(x, v);
    if (step > 0 && (force <= 0.0 || x < 0.0)) break;
    found.force = std::max(found.force, force);
    const double a1 = slope(x, v), v2 = v + 0.5 * h * a1, a2 = slope(x + 0.5 * h * v, v2), v3 = v + 0.5 * h * a2,
                 a3 = slope(x + 0.5 * h * v2, v3), v4 = v + h * a3, a4 = slope(x + h * v3, v4);
    x += h / 6.0 * (v + 2.0 * v2 + 2.0 * v3 + v4);
    v += h / 6.0 * (a1 + 2.0 * a2 + 2.0 * a3 + a4);
    found.penetration = std::max(found.penetration, x);
  }
  found.restitution = -v / speed;
  return found;
}

// How a mass comes to rest in a stop, and how it leaves.
StopForecast lone_mass(double mass, const Stop& stop, double speed) {
  // Less damping than that takes the digits of the closed form.
  const bool proportional = stop.law == Law::hunt_crossley && stop.damping * speed > 1e-3;
  StopForecast found = (proportional ? proportionally_damped_mass : integrated_mass)(mass, stop, speed);
  found.damping_ratio =
      stop.by_rate(found.penetration, 0.0) / (2.0 * std::sqrt(mass * stop.by_depth(found.penetration, 0.0)));
  return found;
}

}  // namespace

StopForecast forecast(const EndBar& end, double end_mass, double node_mass, const Stop& stop, double speed) {
  StopForecast found = lone_mass(end_mass + end.bar.density * end.bar.length, stop, speed);
  double shallow = 0.0, deep = found.penetration;
  const auto as_penalty = [&](double depth) {
    return predict_impact(end.bar, end.element, node_mass, depth / stop.force(depth, 0.0), speed).penetration;
  };
  for (int k = 0; k < 30 && as_penalty(deep) < deep; ++k) {
    const double middle = 0.5 * (shallow + deep);
    (as_penalty(middle) > middle ? shallow : deep) = middle;
  }
  if (deep < found.penetration) {
    found.penetration = deep, found.force = 0.0;
    for (int k = 0; k <= 20; ++k) {  // of an oscillator that comes to rest there
      const double phase = 0.05 * k * 0.5 * std::numbers::pi;
      found.force = std::max(found.force, stop.force(deep * std::sin(phase), speed * std::cos(phase)));
    }
  }
  if (end_mass > 0.0) {
    const StopForecast alone = lone_mass(end_mass, stop, speed);
    found.penetration = std::max(found.penetration, alone.penetration);
    found.force = std::max(found.force, alone.force);
  }
  return found;
}

EndBar end_bar(const BarSystem& system, bool right) {
  const Piece& last = end_bar(system.elements().pieces(), right);
  const std::size_t e = last.end_element(right);
  EndBar end{whole_section(last.bar, last.area(e)), last.mesh.element(e)};
  end.bar.length = system.bar().length;  // all that is behind it presses on
  return end;
}

std::vector<ContactRegime> contact_regimes(const Setup& setup, const BarSystem& system) {
  const Case& run = setup.run;
  std::vector<ContactRegime> regimes;
  if (!is_penalised(run.method)) return regimes;
  const double epsilon = setup.epsilon;
  const std::vector<double> masses = system.inertia().effective_masses();
  const State start = system.initial_state();
  const Bar& bar = system.bar();
  const double own = run.restitution ? damping_ratio(*run.restitution) : 0.0;
  double falling = 0.0, deepest = 0.0;  // the velocity that leads deepest into the span obstacle, and how deep
  for (const Contact& contact : system.contacts()) {
    if (contact.joint > 0) continue;
    const double v = contact.sign * start.v[contact.unknown];
    if (contact.where == Where::span) {
      // Falling flat, every node is an oscillator of mass rho A w on the spring w / epsilon.
      const double x = setup.mesh.node(contact.unknown + system.unknowns().first_node()),
                   area = run.scene.section ? run.scene.section(x) : 1.0,
                   depth = -v * std::sqrt(bar.density * area * epsilon);
      if (depth > deepest) deepest = depth, falling = v;
      continue;
    }
    const bool right = contact.where == Where::right;
    const double m = masses[contact.unknown];
    const auto [whole, h] = end_bar(system, right);
    ContactRegime regime{.where = contact.where, .effective_mass = m};
    if (const auto& stop = system.stop(contact)) {
      regime.stop = stop;
      if (v < 0.0) regime.forecast = forecast({whole, h}, system.inputs()[right].mass, m, *stop, -v);
      regimes.push_back(regime);
      continue;
    }
    // Nothing brings back a node that is thrown before a wave has crossed its element.
    if (m > 0.0 && h * whole.slowness() < run.end) {
      regime.damping_ratio = own + viscous_ratio(whole, h, m, 1.0 / epsilon);
      regime.quiet_epsilon = h / whole.modulus;
      if (whole.viscosity > 0.0)
        regime.quiet_epsilon = std::min(regime.quiet_epsilon, 4.0 * m * h * h / (whole.viscosity * whole.viscosity));
      regime.chatters = *regime.damping_ratio < 1.0 && epsilon < regime.quiet_epsilon;
    }
    if (v < 0.0) regime.impact = predict_impact(whole, h, m, epsilon, -v);
    regimes.push_back(regime);
  }
  if (run.scene.span) {
    ContactRegime regime{.where = Where::span, .effective_mass = *std::ranges::max_element(masses)};
    regime.damping_ratio = own;
    regime.chatters = own < 1.0;
    if (falling < 0.0) regime.impact = {-falling, deepest, ImpactPrediction::Layer::node};
    regimes.push_back(regime);
  }
  return regimes;
}

std::string contact_law(const Setup& setup) {
  if (are_massless(setup.run.scene, setup.mass)) return "contact: nodes at an obstacle have no mass to be thrown back";
  const Case& run = setup.run;
  if (!run.restitution) return "contact: springs without dashpot throw nodes back, as restitution 1 does";
  return fmt::format("contact: nodes leave an obstacle with restitution {}", *run.restitution);
}

std::optional<std::string> peak_remark(const Setup& setup, const BarSystem& system) {
  const Case& run = setup.run;
  const Bar& bar = system.bar();
  const double epsilon = is_penalised(run.method) ? setup.epsilon : 0.0;
  double mass = 0.0;
  // A node that its spring stops before waves tell it of the bar, and an element that is softer than the spring.
  bool obstacle = false, strikes = false, overshoots = false, viscous = false;
  const std::vector<double> masses = system.inertia().effective_masses();
  for (const Contact& contact : system.contacts()) {
    if (system.stop(contact)) continue;
    obstacle = true;
    const double own = contact.joint > 0 ? system.inertia().contact_mass(contact) : masses[contact.unknown];
    mass = std::max(mass, own);
    const std::size_t node = contact.unknown + system.unknowns().first_node();
    const std::vector<Piece>& pieces = system.elements().pieces();
    const Bar behind = bar_at(pieces, node), before = contact.joint > 0 ? bar_at(pieces, node - 1) : Bar{0, 0, 0, 0};
    viscous |= behind.damped() || before.damped();
    // V times it is the force of the waves that an impact at speed V sends into both sides.
    const double z = behind.impedance(), other = before.impedance(),
                 impedance = z > 0.0 && other > 0.0 ? z * other / (z + other) : std::max(z, other);
    strikes |= own > epsilon * impedance * impedance;
    overshoots |= system.elements().stretch_beside(contact.unknown) > epsilon * bar.modulus;
  }
  if (!obstacle) return std::nullopt;
  if (is_scheme(run.method) && mass > 0.0)
    return "the peak of an impact has no limit: the scheme stops the mass of a node within a step, with a force that "
           "grows as 1 / method.step";
  if (is_penalised(run.method) && mass > 0.0) {
    if (run.restitution && *run.restitution < 1.0)
      return "the peak of an impact has no limit: the dashpot begins with a force that grows as contact.epsilon^(-1/2)";
    if (strikes)
      return "the peak of an impact has no limit: the spring stops the mass of a node, with a force that grows as "
             "contact.epsilon^(-1/2)";
  }
  if (viscous)
    return "the peak of an impact has no limit: a viscous bar answers with a force that falls as t^(-1/2) from the "
           "touch on, and a finer mesh or a stiffer spring shows more of it";
  if (run.method != MethodName::characteristics && overshoots)
    return "the peak of an impact is too high on every mesh: behind the front of an elastic wave the force overshoots, "
           "by a share that a finer mesh does not reduce" +
           std::string(refusal_by_characteristics(run) ? "" : "; method characteristics gives the exact peak");
  return std::nullopt;
}

std::optional<std::string> strain_remark(const Setup& setup, const BarSystem& system) {
  const Case& run = setup.run;
  if (run.scene.units.length.empty()) return std::nullopt;
  constexpr double small = 0.1;
  const Bar& bar = system.bar();
  const double way = std::min(bar.length, run.end * bar.wave_speed());
  const double strain = displacement_of_data(system, run.end) / way;
  if (strain <= small) return std::nullopt;
  return fmt::format(
      "strains: the data make strains of about {:.2g}, and the model holds for small ones; look at the units of "
      "velocities, loads and modulus",
      strain);
}

std::optional<std::string> jump_remark(const Setup& setup, const BarSystem& system) {
  const Case& run = setup.run;
  const auto spans = [](const Contact& contact) { return contact.where == Where::span; };
  if (system.mass() != Mass::fourth_order || JumpFilter(system).acts() || run.method == MethodName::characteristics ||
      has_stops(run.scene) || system.size() < 4 || std::ranges::any_of(system.contacts(), spans))
    return std::nullopt;
  // Chosen, not derived: a twentieth of the velocity that the scene has is seen in a picture.
  constexpr double noticed = 0.05;
  const double scale = natural_scales(system, run.end).velocity();
  PenalisedSystem free(system, Penalty{0.0, 0.0});
  const State start = system.initial_state();
  std::vector<double> force(system.size()), rate(system.size()), masses(system.size());
  const std::vector<double> ones(system.size(), 1.0);
  system.inertia().matrix().multiply(ones, masses);
  const auto rings = [&](bool right) {
    if (system.unknowns().wall(right)) return false;
    const std::size_t end = system.unknowns().end(right), next = right ? end - 1 : end + 1;
    const double impedance = std::sqrt(masses[next] * system.bar().modulus / system.elements().stretch_beside(end));
    const double viscous =
        system.bar().viscosity / (system.elements().rate_stretch(system.elements().beside(end)) * impedance);
    const bool is_heavy = masses[end] > 2.0 * masses[next];  // its velocity has no jump
    if (is_heavy || 2.0 * viscous * viscous >= 1.0 || system.inputs()[right].dashpot >= 0.5 * impedance) return false;
    return std::abs(force[end] - masses[end] / masses[next] * force[next]) > noticed * scale * impedance;
  };
  double t = 0.0, until = free.load().begin_leg(t, run.end);
  free.force(t, start.u, start.v, force);
  for (int legs = 0; legs < 1000; ++legs) {  // of a load with more breaks the first ones tell
    for (const bool right : {false, true})
      if (rings(right))
        return fmt::format(
            "jumps: the force on the {} end jumps at t = {:.6g}, which sets going the shortest waves of the mesh: "
            "velocities there are off by the order of the jump; what helps: {} or more equal elements of one bar "
            "without section, no longer than 0.3 sqrt(E / k) of springs k along it, viscosity, or a smoother "
            "rise",
            right ? "right" : "left", t, JumpFilter::fewest_elements);
    if (until >= run.end) break;
    t = until, until = free.load().begin_leg(t, run.end);
    for (std::vector<double>* one : {&force, &rate}) std::ranges::fill(*one, 0.0);
    free.load().jump(t, run.end, force, rate);
  }
  return std::nullopt;
}

}  // namespace viscobar

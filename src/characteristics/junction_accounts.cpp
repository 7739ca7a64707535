// Displacements, forces and energies of a junction within a window.
#include <cmath>
#include <tuple>

#include "characteristics/junction.hpp"
#include "discretisation/gauss.hpp"

namespace viscobar::characteristics {

namespace {

double value_at(const Piecewise& f, double s) { return f.empty() ? 0.0 : Cursor(f).value(s); }
double integral_to(const Piecewise& f, double s) { return f.empty() ? 0.0 : Cursor(f).integral(s); }

}  // namespace

// A change tells the side before it, but at the beginning there is none.
bool Junction::closed_at(std::size_t link, double s) const {
  bool closed = begin_.links[link].closed;
  for (const Turn& turn : turns_)
    if (turn.link == link && (s <= 0.0 ? turn.s <= 0.0 : turn.s < s)) closed = turn.change == Change::closing;
  return closed;
}

std::optional<std::size_t> Junction::holder(std::size_t body, double s) const {
  for (std::size_t l = 0; l < links_.size(); ++l) {
    const auto& [kind, a, b] = std::tie(links_[l].kind, links_[l].a, links_[l].b);
    if (((a == body && bodies_[b].held) || (b == body && bodies_[a].held)) &&
        (kind == Kind::fixed || (kind == Kind::contact && closed_at(l, s))))
      return l;
  }
  return std::nullopt;
}

double Junction::displacement_at(std::size_t body, double s, double t) const {
  const auto held = holder(body, s);
  if (!held) return begin_.bodies[body].place + window_ * integral_to(bodies_[body].moved, s);
  const Link& link = links_[*held];
  const std::size_t ground = link.a == body ? link.b : link.a;
  const double moved = bodies_[ground].input ? bodies_[ground].input->motion->displacement(t) : 0.0;
  return grounds_[ground] + moved + (link.a == body ? link.gap : -link.gap);
}

double Junction::velocity_at(std::size_t body, double s, double t) const {
  const auto held = holder(body, s);
  if (!held) return value_at(bodies_[body].moved, s);
  const Body& ground = bodies_[links_[*held].a == body ? links_[*held].b : links_[*held].a];
  return ground.input ? ground.input->motion->velocity(t) : 0.0;
}

double Junction::force_at(std::size_t link, double s) const {
  const double force = value_at(links_[link].force, s);
  return links_[link].touches() ? std::max(0.0, force) : force;
}

double Junction::depth_at(std::size_t l, double s) const {
  const Link& link = links_[l];
  return -begin_.links[l].clearance -
         window_ * (integral_to(bodies_[link.b].moved, s) - integral_to(bodies_[link.a].moved, s));
}

EnergyState Junction::energy_at(double s) const {
  EnergyState energy;
  for (std::size_t i = 0; i < bodies_.size(); ++i) {
    const Body& body = bodies_[i];
    if (body.mass == 0.0) continue;
    const double v = body.moved.empty() ? now_.bodies[i].velocity : value_at(body.moved, s);
    energy.kinetic += 0.5 * body.mass * v * v;
  }
  for (std::size_t l = 0; l < links_.size(); ++l) {
    const Link& link = links_[l];
    const bool stop = link.kind == Kind::stop;
    if (link.stiffness == 0.0 || (stop && !closed_at(l, s))) continue;
    (stop ? energy.contact : energy.elastic) += 0.5 * link.stiffness * std::pow(depth_at(l, s), 2);
  }
  const auto [work, dissipated] = flow(s);
  energy.work = begin_.work + work;
  energy.dissipated = begin_.dissipated + dissipated;
  for (const Turn& turn : turns_)
    if (turn.s <= s) energy.dissipated += turn.lost, energy.work += turn.work;
  return energy;
}

std::pair<double, double> Junction::flow(double until) const {
  double work = 0.0, dissipated = 0.0;
  if (!flows_) return {work, dissipated};
  std::vector<Cursor> velocities, forces, inputs;
  for (const Body& body : bodies_) velocities.emplace_back(body.moved);
  for (const Link& link : links_) forces.emplace_back(link.force);
  for (const Input& input : inputs_) inputs.emplace_back(input.values);
  const auto velocity = [&](std::size_t body, double s) {
    return bodies_[body].moved.empty() ? 0.0 : velocities[body].value(s);
  };
  const Piecewise& parts = bodies_[faces.front().body].moved;
  for (std::size_t p = 0; p < parts.size() && parts[p].begin < until; ++p) {
    const double end = std::min(until, parts[p].end);
    const double middle = 0.5 * (parts[p].begin + end), half = 0.5 * (end - parts[p].begin);
    for (const auto [node, weight] : gauss(Chebyshev::most_terms)) {
      const double s = middle + half * node, share = half * weight * window_;
      for (std::size_t i = 0; i < inputs_.size(); ++i) {
        if (inputs_[i].rate) continue;
        const std::size_t body = inputs_[i].body;
        const double value = inputs[i].value(s);
        if (!bodies_[body].held) work += share * value * velocity(body, s);
        for (std::size_t l = 0; l < links_.size() && bodies_[body].held; ++l)
          if (links_[l].a == body || links_[l].b == body)
            work += (links_[l].a == body ? share : -share) * value * forces[l].value(s);
      }
      for (std::size_t i = 0; i < bodies_.size(); ++i)
        if (bodies_[i].dashpot > 0.0) dissipated += share * bodies_[i].dashpot * std::pow(velocity(i, s), 2);
      for (std::size_t l = 0; l < links_.size(); ++l)
        if (const Link& link = links_[l]; link.damping > 0.0 && (link.kind == Kind::spring || closed_at(l, middle)))
          dissipated += share * link.damping * std::pow(velocity(link.b, s) - velocity(link.a, s), 2);
    }
  }
  return {work, dissipated};
}

}  // namespace viscobar::characteristics

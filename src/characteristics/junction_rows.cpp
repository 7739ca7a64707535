// How a junction moves while none of its links changes: rows of coefficients of waves, forces, motions and states.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <variant>

#include "characteristics/junction.hpp"
#include "run/archive.hpp"

namespace viscobar::characteristics {

std::size_t Junction::add_body(const Data& data) {
  bodies_.emplace_back();
  now_.bodies.push_back({data.displacement, data.velocity});
  return bodies_.size() - 1;
}

void Junction::add_mass(std::size_t body, double mass, double velocity, std::string key) {
  Body& to = bodies_[body];
  to.mass += mass;
  to.momentum += mass * velocity;
  to.key = std::move(key);
}

void Junction::add_face(std::size_t body, double impedance) {
  bodies_[body].impedance += impedance;
  faces.push_back({body, impedance});
}

void Junction::add_end(std::size_t body, const EndCondition& condition, const EndInput& input, bool right) {
  const std::string table = right ? "right" : "left";
  const auto ground = [&](double place, bool moves) {
    const std::size_t added = add_body({place, 0.0});
    bodies_[added].held = true;
    if (moves && input.motion) bodies_[added].input = &input;
    return added;
  };
  bodies_[body].end = true;
  if (input.force) bodies_[body].input = &input;
  bodies_[body].dashpot += input.dashpot;
  bodies_[body].impedance += input.dashpot;
  if (input.mass > 0.0) bodies_[body].carried = input.mass, bodies_[body].key = table + ".mass";
  if (is_fixed(condition))
    links_.push_back({Kind::fixed, ground(now_.bodies[body].place, true), body});
  else if (const auto* obstacle = std::get_if<Obstacle>(&condition)) {
    const std::size_t wall = ground(0.0, true);
    const bool above = obstacle->side == Side::above;
    Link link{input.stop ? Kind::stop : Kind::contact, above ? body : wall, above ? wall : body, obstacle->gap};
    if (input.stop)
      link.stiffness = input.stop->stiffness, link.damping = input.stop->damping,
      link.key = input.stop->key(table, "stiffness");
    links_.push_back(std::move(link));
  }
  if (input.stiffness > 0.0)
    links_.push_back({Kind::spring, ground(0.0, false), body, 0.0, input.stiffness, 0.0, 0, table + ".stiffness"});
}

void Junction::add_joint(std::size_t a, std::size_t b, const Joint& joint, std::size_t number) {
  const std::string table = fmt::format("joint.{}", number);
  Link link{Kind::spring, a, b, 0.0, joint.stiffness, joint.damping, number, table + ".stiffness"};
  if (joint.kind == JointKind::contact) {
    link = {joint.stop ? Kind::stop : Kind::contact, a, b, joint.gap, 0.0, 0.0, number};
    if (joint.stop)
      link.stiffness = joint.stop->stiffness, link.damping = joint.stop->damping,
      link.key = joint.stop->key(table, "stiffness");
  }
  links_.push_back(std::move(link));
}

void Junction::finish() {
  now_.links.resize(links_.size());
  clearances_.resize(links_.size());
  places_.resize(bodies_.size());
  for (std::size_t i = 0; i < bodies_.size(); ++i) {
    Body& body = bodies_[i];
    if (body.mass > 0.0) now_.bodies[i].velocity = body.momentum / body.mass;
    body.mass += body.carried;
    heaviest_ = std::max(heaviest_, body.mass);
    if (body.input) inputs_.push_back({i});
    flows_ |= body.input || body.dashpot > 0.0;
    places_[i] = {now_.bodies[i].place, 0.0};
    grounds_.push_back(now_.bodies[i].place);
  }
  for (std::size_t i = 0; i < bodies_.size() && heaviest_ > 0.0; ++i)
    if (bodies_[i].held && bodies_[i].input) inputs_.push_back({i, true});
  for (std::size_t l = 0; l < links_.size(); ++l) {
    const Link& link = links_[l];
    if (const auto held = link.kind == Kind::fixed ? held_by(l) : std::nullopt) {
      const EndInput* input = bodies_[held->first == link.b ? link.a : link.b].input;
      now_.bodies[held->first].velocity = input ? input->motion->velocity(start_) : 0.0;  // whatever its data are
    }
    const double a = now_.bodies[link.a].place, b = now_.bodies[link.b].place, clearance = b - a + link.gap;
    // Data that touch up to their rounding touch.
    const double touch = 4.0 * rounding * (std::abs(a) + std::abs(b) + link.gap);
    now_.links[l].clearance = link.touches() && clearance <= touch ? 0.0 : clearance;
    clearances_[l] = {now_.links[l].clearance, 0.0};
    flows_ |= link.damping > 0.0;
  }
  reference_ = std::numeric_limits<double>::infinity();
  for (const Face& face : faces) reference_ = std::min(reference_, bodies_[face.body].impedance);
  begin_ = now_;
  arrange();
}

void Junction::restore() {
  if (begin_.bodies.size() != bodies_.size() || begin_.links.size() != links_.size())
    throw ArchiveError("has another length");
  now_ = begin_;
  for (std::size_t i = 0; i < bodies_.size(); ++i) places_[i] = {now_.bodies[i].place, 0.0};
  for (std::size_t l = 0; l < links_.size(); ++l) clearances_[l] = {now_.links[l].clearance, 0.0};
  for (Body& body : bodies_) body.moved.clear();
  arrange();
}

// Dashpots and faces slow masses down, springs swing them and move faces that have none.
std::pair<double, std::string> Junction::fastest() const {
  double resistance = 0.0, yielding = 0.0;
  for (const Body& body : bodies_) resistance += body.impedance;
  for (const Link& link : links_) resistance += link.damping;
  for (const Face& face : faces) yielding += 1.0 / face.impedance;
  std::pair<double, std::string> most{0.0, {}};
  const auto raise = [&](double rate, const std::string& key) {
    if (window_ * rate > most.first) most = {window_ * rate, key};
  };
  for (const Body& body : bodies_)
    if (body.mass > 0.0) raise(resistance / body.mass, body.key);
  for (const Link& link : links_) {
    if (link.stiffness == 0.0) continue;
    raise(link.stiffness * yielding, link.key);
    for (const std::size_t side : {link.a, link.b})
      if (const double mass = bodies_[side].mass; mass > 0.0) raise(2.0 * std::sqrt(link.stiffness / mass), link.key);
  }
  return most;
}

void Junction::arrange() {
  const std::size_t n = bodies_.size();
  group_.resize(n);
  for (std::size_t i = 0; i < n; ++i) group_[i] = i;
  for (std::size_t l = 0; l < links_.size(); ++l) {
    if (!tied(l)) continue;
    const auto [low, high] = std::minmax({group_[links_[l].a], group_[links_[l].b]});
    std::ranges::replace(group_, std::size_t{high}, std::size_t{low});
  }
  states_.clear();
  for (std::size_t i = 0; i < n; ++i)
    if (group_[i] == i && mass_of(i) > 0.0 && !ground_of(i)) states_.push_back({false, i});
  for (std::size_t l = 0; l < links_.size(); ++l)
    if (const LinkMemory& memory = now_.links[l]; links_[l].stiffness > 0.0 && (pulls(l) || memory.released))
      states_.push_back({true, l});
  find_velocities();
  find_forces();
  start_states();
}

double Junction::mass_of(std::size_t group) const {
  double mass = 0.0;
  for (std::size_t i = 0; i < bodies_.size(); ++i) mass += group_[i] == group ? bodies_[i].mass : 0.0;
  return mass;
}

std::optional<std::size_t> Junction::ground_of(std::size_t group) const {
  for (std::size_t i = 0; i < bodies_.size(); ++i)
    if (group_[i] == group && bodies_[i].held) return i;
  return std::nullopt;
}

std::optional<std::size_t> Junction::state_of(bool link, std::size_t number) const {
  for (std::size_t j = 0; j < states_.size(); ++j)
    if (states_[j].link == link && states_[j].number == number) return faces.size() + inputs_.size() + j;
  return std::nullopt;
}

std::optional<std::size_t> Junction::input_of(std::size_t body, bool rate) const {
  for (std::size_t i = 0; i < inputs_.size(); ++i)
    if (inputs_[i].body == body && inputs_[i].rate == rate) return faces.size() + i;
  return std::nullopt;
}

// (sum Z + c) v is left out; factor times the rest.
void Junction::add_push(std::size_t body, double factor, double* row) const {
  for (std::size_t i = 0; i < faces.size(); ++i)
    if (faces[i].body == body) row[i] += factor * faces[i].impedance;
  for (std::size_t i = 0; i < inputs_.size(); ++i)
    if (inputs_[i].body == body && !bodies_[body].held) row[faces.size() + i] += factor;
}

// A group without mass has (sum Z + c + sum of c of links) v - sum of c v_other = sum Z w + F +- sum of k d.
void Junction::find_velocities() {
  const std::size_t n = bodies_.size(), columns = faces.size() + inputs_.size() + states_.size();
  velocities_.resize(n, columns);
  massless_.clear();
  for (std::size_t g = 0; g < n; ++g) {
    if (group_[g] != g) continue;
    if (const auto ground = ground_of(g)) {
      if (const auto input = input_of(*ground, false)) velocities_[g][*input] = 1.0;
    } else if (const auto state = state_of(false, g)) {
      velocities_[g][*state] = 1.0;
    } else {
      massless_.push_back(g);
    }
  }
  const std::size_t unknowns = massless_.size();
  const auto place_of = [&](std::size_t g) {
    return static_cast<std::size_t>(std::ranges::find(massless_, g) - massless_.begin());
  };
  square_.resize(unknowns, unknowns + columns);
  for (std::size_t m = 0; m < unknowns; ++m) {
    double* row = square_[m];
    for (std::size_t i = 0; i < n; ++i) {
      if (group_[i] != massless_[m]) continue;
      row[m] += bodies_[i].impedance;
      add_push(i, 1.0, row + unknowns);
    }
    for (std::size_t l = 0; l < links_.size(); ++l) {
      const Link& link = links_[l];
      const std::size_t a = group_[link.a], b = group_[link.b];
      if (!pulls(l) || a == b || (a != massless_[m] && b != massless_[m])) continue;
      const bool at_b = b == massless_[m];
      row[m] += link.damping;
      if (const std::size_t other = place_of(at_b ? a : b); other < unknowns)
        row[other] -= link.damping;
      else
        for (std::size_t j = 0; j < columns; ++j) row[unknowns + j] += link.damping * velocities_[at_b ? a : b][j];
      if (const auto state = state_of(true, l)) row[unknowns + *state] += at_b ? link.stiffness : -link.stiffness;
    }
  }
  // Symmetric and dominated by its diagonal: no pivoting.
  for (std::size_t k = 0; k < unknowns; ++k)
    for (std::size_t i = 0; i < unknowns; ++i) {
      if (i == k || square_[i][k] == 0.0) continue;
      const double factor = square_[i][k] / square_[k][k];
      for (std::size_t j = k; j < unknowns + columns; ++j) square_[i][j] -= factor * square_[k][j];
    }
  for (std::size_t m = 0; m < unknowns; ++m)
    for (std::size_t j = 0; j < columns; ++j) velocities_[massless_[m]][j] = square_[m][unknowns + j] / square_[m][m];
  for (std::size_t i = 0; i < n; ++i)
    if (group_[i] != i) std::copy_n(velocities_[group_[i]], columns, velocities_[i]);
}

void Junction::find_forces() {
  const std::size_t columns = faces.size() + inputs_.size() + states_.size();
  forces_.resize(links_.size(), columns);
  watched_.resize(links_.size(), columns);
  rates_.resize(states_.size(), columns);
  for (std::size_t l = 0; l < links_.size(); ++l) {
    const Link& link = links_[l];
    if (!pulls(l) && !now_.links[l].released) continue;
    double* row = now_.links[l].released ? watched_[l] : forces_[l];
    for (std::size_t j = 0; j < columns; ++j) row[j] = link.damping * (velocities_[link.a][j] - velocities_[link.b][j]);
    if (const auto state = state_of(true, l)) row[*state] += link.stiffness;
  }
  // factor times the resultant on the body, ties apart
  const auto add_resultant = [&](std::size_t i, double factor, double* row) {
    add_push(i, factor, row);
    for (std::size_t j = 0; j < columns; ++j) row[j] -= factor * bodies_[i].impedance * velocities_[i][j];
    for (std::size_t l = 0; l < links_.size(); ++l)
      if (pulls(l) && (links_[l].a == i || links_[l].b == i))
        for (std::size_t j = 0; j < columns; ++j) row[j] += (links_[l].b == i ? factor : -factor) * forces_[l][j];
  };
  for (std::size_t k = 0; k < states_.size(); ++k) {
    const auto [is_link, number] = states_[k];
    if (is_link)
      for (std::size_t j = 0; j < columns; ++j)
        rates_[k][j] = window_ * (velocities_[links_[number].a][j] - velocities_[links_[number].b][j]);
    else
      for (std::size_t i = 0; i < bodies_.size(); ++i)
        if (group_[i] == number) add_resultant(i, window_ / mass_of(number), rates_[k]);
  }
  // N = m v' less the resultant, over all bodies on one side of it.
  for (std::size_t l = 0; l < links_.size(); ++l) {
    if (!tied(l)) continue;
    const double sign = side_of(l);
    const auto state = state_of(false, group_[links_[l].a]);
    const auto ground = ground_of(group_[links_[l].a]);
    const auto ground_rate = ground ? input_of(*ground, true) : std::nullopt;
    for (std::size_t i = 0; i < bodies_.size(); ++i) {
      if (!side_[i]) continue;
      add_resultant(i, -sign, forces_[l]);
      if (ground_rate) forces_[l][*ground_rate] += sign * bodies_[i].mass;
      for (std::size_t j = 0; state && j < columns; ++j)
        forces_[l][j] += sign * bodies_[i].mass / window_ * rates_[*state - faces.size() - inputs_.size()][j];
    }
  }
  // In the measure of energy: v / sqrt(m) and d sqrt(k).
  const auto unit = [&](const StateOf& one) {
    return one.link ? 1.0 / std::sqrt(links_[one.number].stiffness) : 1.0 / std::sqrt(mass_of(one.number));
  };
  rate_ = 0.0;
  for (std::size_t k = 0; k < states_.size(); ++k) {
    double sum = 0.0;
    for (std::size_t j = 0; j < states_.size(); ++j)
      sum += std::abs(rates_[k][faces.size() + inputs_.size() + j]) * unit(states_[j]) / unit(states_[k]);
    rate_ = std::max(rate_, sum);
  }
}

double Junction::side_of(std::size_t link) {
  const std::size_t n = bodies_.size(), group = group_[links_[link].b];
  side_.assign(n, 0);
  side_[links_[link].b] = 1;
  for (bool grown = true; grown;) {
    grown = false;
    for (std::size_t l = 0; l < links_.size(); ++l)
      if (l != link && tied(l) && side_[links_[l].a] != side_[links_[l].b])
        side_[links_[l].a] = side_[links_[l].b] = 1, grown = true;
  }
  double of_side = 0.0, of_rest = 0.0;
  bool held = false, rest_held = false;
  for (std::size_t i = 0; i < n; ++i) {
    if (group_[i] != group) continue;
    (side_[i] ? of_side : of_rest) += bodies_[i].impedance;
    (side_[i] ? held : rest_held) |= bodies_[i].held;
  }
  // The side that resists less has the smaller terms.
  if (!held && (rest_held || of_side <= of_rest)) return 1.0;
  for (std::size_t i = 0; i < n; ++i) side_[i] = group_[i] == group && !side_[i];
  return -1.0;
}

}  // namespace viscobar::characteristics

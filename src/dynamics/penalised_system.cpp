#include "dynamics/penalised_system.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <stdexcept>

namespace viscobar {

namespace {

constexpr double stiff = 1e4;  // kappa = k h / E
// Part of an impact: less of it is what the mass of a mesh passes on to the far end of a bar.
constexpr double least_pull = 0.01;
constexpr double infinite = std::numeric_limits<double>::infinity();

}  // namespace

PenalisedSystem::PenalisedSystem(const BarSystem& bar, const Penalty& penalty)
    : bar_(bar),
      closed_(bar.contacts().size(), 0),
      measured_(closed_),
      restitution_(penalty.restitution),
      rigid_(penalty.epsilon == 0.0) {
  for (const Contact& contact : bar.contacts()) {
    if (rigid_ && contact.where == Where::span)
      throw std::invalid_argument("a rigid obstacle under the whole span stops several nodes at once: not for rigid");
    const std::size_t i = by_law_.size(), node = contact.unknown;
    const bool met = is_met_elsewhere(i, node);
    by_law_.push_back(contact.joint == 0 ? met : !is_of_bar(i) && (!rigid_ || (met && is_met_elsewhere(i, node - 1))));
    if (rigid_ && by_law_.back())
      throw std::invalid_argument("a rigid contact of a body alone beside another one has no row that tells its force");
    if (rigid_ && size() < 2)
      throw std::invalid_argument("a rigid obstacle needs an unknown node beside that of the contact");
    if (const auto& stop = bar.stop(contact)) {
      if (rigid_ || massless(contact.unknown))
        throw std::invalid_argument("a stop with a law of its own wants a node with mass, and is not rigid");
      stops_.push_back({laws_.size(), *stop});
      if (!stop->linear()) bent_.push_back(stops_.back());
      stops_take_ |= stop->damping > 0.0;
      laws_.push_back(stop->linear() ? PenaltyLaw{stop->stiffness, stop->damping} : PenaltyLaw{});
      continue;
    }
    const bool dashpot = !rigid_ && penalty.restitution < 1.0;
    laws_.push_back(rigid_ ? PenaltyLaw{infinite, 0.0}
                           : penalty_law(penalty, contact.weight, dashpot ? bar.contact_mass(contact) : 0.0));
  }
  for (std::size_t i = 0; i < laws_.size(); ++i) {
    const std::size_t node = contact(i).unknown;
    collides_ |= collides(i);
    double inverse_mass = massless(node) || rigid_ ? 0.0 : 1.0 / bar.inertia().diagonal_entry(node);
    if (contact(i).joint > 0 && !rigid_) inverse_mass += 1.0 / bar.inertia().diagonal_entry(node - 1);
    rates_.push_back(massless(node) || rigid_ ? 0.0
                     : contact(i).joint > 0   ? std::sqrt(laws_[i].stiffness * inverse_mass)
                                              : std::sqrt(laws_[i].stiffness / bar.inertia().diagonal_entry(node)));
  }
  if (collides_ || bar.has_end_rows()) acceleration_.resize(size());
  for (std::size_t i = 0; i < laws_.size(); ++i) holds_.push_back(rigid_ || gives_way_by_rounding(i));
  dashpots_ = std::any_of(laws_.begin(), laws_.end(), [](const PenaltyLaw& law) { return law.damping > 0.0; });
  if (bar.loaded()) load_.emplace(bar);
  find_offsets();
}

void PenalisedSystem::measure_from_obstacle(std::size_t closing, std::span<double> u) {
  if (measured_[closing] || contact(closing).joint > 0) return;
  std::vector<bool> node_is_measured(size());  // from its other obstacle
  for (std::size_t i = 0; i < laws_.size(); ++i)
    if (measured_[i]) node_is_measured[contact(i).unknown] = true;
  bool any = false;
  for (std::size_t i = 0; i < laws_.size(); ++i) {
    const std::size_t node = contact(i).unknown;
    if (contact(i).where != contact(closing).where || contact(i).sign != contact(closing).sign ||
        node_is_measured[node])
      continue;
    any = true;
    measured_[i] = 1;
    origin_.resize(size());
    origin_[node] = -contact(i).sign * contact(i).gap;
    if (!u.empty()) u[node] -= origin_[node];
  }
  if (any) find_offsets();
}

void PenalisedSystem::find_offsets() {
  offsets_.resize(laws_.size());
  for (std::size_t i = 0; i < laws_.size(); ++i)
    offsets_[i] = contact(i).joint > 0
                      ? contact(i).gap + origin_at(contact(i).unknown) - origin_at(contact(i).unknown - 1)
                      : contact(i).clearance(origin_at(contact(i).unknown));
  if (origin_.empty()) return;
  const std::vector<double> nothing(size(), 0.0);
  std::vector<double> without(size());
  origin_force_.resize(size());
  bar_.internal_force(origin_, nothing, origin_force_);
  bar_.internal_force(nothing, nothing, without);
  for (std::size_t i = 0; i < size(); ++i) origin_force_[i] -= without[i];
}

double PenalisedSystem::largest_displacement(std::span<const double> u) const {
  const Eigen::Map<const Eigen::ArrayXd> relative(u.data(), static_cast<Eigen::Index>(u.size()));
  if (origin_.empty()) return relative.abs().maxCoeff();
  return (relative + Eigen::Map<const Eigen::ArrayXd>(origin_.data(), relative.size())).abs().maxCoeff();
}

void PenalisedSystem::set_closed(std::size_t i, bool closed) {
  closed_[i] = closed ? 1 : 0;
  ++revision_;
}

double PenalisedSystem::clearance_rounding(std::size_t i, double largest) const {
  return 32.0 * std::numeric_limits<double>::epsilon() * (contact(i).gap + largest);
}

double PenalisedSystem::indicator_rounding(std::size_t i, double largest) const {
  const double rounding = clearance_rounding(i, largest);
  return closed(i) && measured_[i] && !follows(i) && !holds(i) ? rounding / (1.0 + relative_stiffness(i)) : rounding;
}

bool PenalisedSystem::gives_way_by_rounding(std::size_t i) const {
  const std::size_t node = contact(i).unknown;
  if (!massless(node)) return false;
  const Bar& bar = bar_.bar();
  const double viscous = bar.viscosity / (bar_.stretch_at(node) * std::sqrt(bar.modulus * bar.density));
  return relative_stiffness(i) * std::numeric_limits<double>::epsilon() > 1.0 + viscous;
}

// By a closed contact.
bool PenalisedSystem::held(std::size_t unknown) const {
  for (std::size_t i = 0; i < laws_.size(); ++i)
    if (closed_at(i, unknown) && holds(i)) return true;
  return false;
}

std::vector<std::size_t> PenalisedSystem::indicator_entries(std::size_t i) const {
  const std::size_t node = contact(i).unknown;
  if (contact(i).joint > 0) {
    std::vector<std::size_t> entries = {node, node, node - 1};
    if (push_weights(i)) entries.insert(entries.end(), {size() + node, size() + node - 1});
    if (!collides(i)) return entries;
    const JointRow row = joint_row(i);
    entries.insert(entries.end(), {row.next, size() + row.node, size() + row.next, size() + row.beyond});
    if (bar_.side()) entries.push_back(row.beyond);
    return entries;
  }
  if (follows(i)) return {neighbour(node)};
  if (push_weights(i)) return {node, node, size() + node};
  if (!holds(i)) return {node};
  std::vector<std::size_t> entries = {node, neighbour(node), size() + neighbour(node)};
  const std::size_t beyond = node == 0 ? 2 : node - 2;
  if (collides(i) && has_one_sided()) entries.push_back(size() + beyond);
  if (collides(i) && has_one_sided() && bar_.side()) entries.push_back(beyond);
  return entries;
}

PenalisedSystem::IndicatorWeights PenalisedSystem::indicator_weights(std::size_t i) {
  const double sign = contact(i).sign;
  IndicatorWeights weights{.values = {sign}};
  const bool held = holds(i) && closed(i);
  if (!load_ || !(held || follows(i))) weights.offset = indicator_offset(i, 0.0);
  if (contact(i).joint > 0) {
    weights.alone = false;
    if (held)
      add_joint_weights(i, weights);
    else
      weights.values = {0.0, 1.0, -1.0};
    return weights;
  }
  if (!held || follows(i)) return weights;
  const Bar& bar = bar_.bar();
  weights.values = {0.0, sign,
                    bar_.is_chain() ? sign * bar.viscosity / bar_.rate_stretch_at(contact(i).unknown) *
                                          bar_.stretch_at(contact(i).unknown) / bar.modulus
                                    : sign * bar.viscosity / bar.modulus};
  weights.alone = false;
  if (!collides(i)) return weights;
  const std::size_t node = contact(i).unknown;
  const std::array<double, 2> inertia = inertia_beside(node);
  for (std::size_t k = 0; k < inertia.size(); ++k)
    weights.rates[k] = -sign * bar_.stretch_at(node) / bar.modulus * inertia[k];
  const SideRows* side = bar_.side();
  if (!side) return weights;
  // The row of the side, but for the node itself.
  weights.sided = true;
  const bool right = bar_.is_right(node);
  const std::array<double, 3> row = side->end_row(right);
  const auto share = [&](std::size_t k, bool drag) {
    const std::size_t j = right ? bar_.mesh().elements - k : k;
    return -sign * bar_.stretch_at(node) / bar.modulus * row[k] * (drag ? side->drag(j) : side->stiffness(j));
  };
  weights.values[1] += share(1, false), weights.values[2] += share(1, true);
  if (has_one_sided()) weights.values[3] = share(2, true), weights.values[4] = share(2, false);
  return weights;
}

double PenalisedSystem::lightest_body(std::size_t i) const {
  if (contact(i).joint == 0) return 0.0;
  const std::size_t b = contact(i).unknown, right = b + bar_.first_node();
  double least = 0.0;
  for (const auto& [unknown, element] : {std::pair{b, right}, {b - 1, right - 2}})
    if (const double mass = bar_.inertia().diagonal[unknown]; !bar_.is_element_of_bar(element))
      least = least > 0.0 ? std::min(least, mass) : mass;
  return least;
}

bool PenalisedSystem::is_of_bar(std::size_t i) const {
  const std::size_t right = contact(i).unknown + bar_.first_node();
  return bar_.is_element_of_bar(right) || (right > 1 && bar_.is_element_of_bar(right - 2));
}

// True if a contact other than i, of the joint or end on the other side, has that node.
bool PenalisedSystem::is_met_elsewhere(std::size_t i, std::size_t unknown) const {
  const std::vector<Contact>& all = bar_.contacts();
  for (std::size_t k = 0; k < all.size(); ++k) {
    const bool of_joint = all[k].joint > 0;
    if (k == i || (!of_joint && all[i].joint == 0)) continue;
    if (all[k].unknown == unknown || (of_joint && all[k].unknown == unknown + 1)) return true;
  }
  return false;
}

PenalisedSystem::JointRow PenalisedSystem::joint_row(std::size_t i) const {
  const std::size_t b = contact(i).unknown, first = bar_.first_node(), right = b + first;
  if (by_law(i)) return {.node = b, .next = b - 1, .beyond = b, .sign = 1.0, .scale = 1.0};
  const bool of_bar = is_of_bar(i), to_right = of_bar ? bar_.is_element_of_bar(right) : !is_met_elsewhere(i, b);
  const std::size_t node = to_right ? b : b - 1;
  JointRow row{.node = node, .next = node, .beyond = node, .sign = to_right ? 1.0 : -1.0, .scale = 0.0};
  const BandedMatrix& inertia = bar_.inertia();
  row.inertia[0] = inertia.diagonal[node];
  if (to_right ? right < bar_.mesh().elements : right > 1) {
    const std::size_t element = to_right ? right : right - 2;
    const double stiffness = bar_.bar().modulus / bar_.stretch(element),
                 viscosity = bar_.bar().viscosity / bar_.rate_stretch(element);
    if (to_right ? b + 1 < size() : b > 1) {
      row.stiffness = stiffness, row.viscosity = viscosity;
      row.next = to_right ? b + 1 : b - 2;
      row.beyond = to_right ? std::min(b + 2, size() - 1) : b < 3 ? 0 : b - 3;
    } else {
      row.ground_stiffness = stiffness, row.ground_viscosity = viscosity;
      row.ground_force = stiffness * bar_.wall(to_right).value_or(0.0);
    }
  }
  row.scale = of_bar && row.stiffness > 0.0 ? row.stiffness : bar_.bar().modulus / bar_.stretch_at(b);
  for (const Support& support : bar_.supports())
    if (support.unknown == node) row.ground_stiffness += support.stiffness, row.ground_viscosity += support.dashpot;
  if (!of_bar) return row;
  const std::array<double, 3> one_sided = inertia.one_sided_entries(node, !to_right);
  for (std::size_t k = 0; k < 3; ++k) row.inertia[k] += one_sided[k];
  const bool beside = row.next != node;
  if (!inertia.is_diagonal() && beside) row.inertia[1] += to_right ? inertia.above(node) : inertia.below(row.next);
  const SideRows* side = bar_.side();
  if (!side) return row;
  const std::array<double, 3> weights = side->end_row(node + first, !to_right);
  const std::array<std::size_t, 3> unknowns = {node, row.next, row.beyond};
  for (std::size_t k = 0; k < 3 && (beside || k == 0); ++k) {
    row.side_stiffness[k] = weights[k] * side->stiffness(unknowns[k] + first);
    row.side_drag[k] = weights[k] * side->drag(unknowns[k] + first);
  }
  if (!beside)  // it is held
    row.ground_force -= weights[1] * side->stiffness(to_right ? right + 1 : right - 2) * *bar_.wall(to_right);
  return row;
}

// The weights of -N over the scale of the row.
void PenalisedSystem::add_joint_weights(std::size_t i, IndicatorWeights& weights) const {
  const JointRow row = joint_row(i);
  const double unit = -row.sign / row.scale, of_next = row.sign * (row.stiffness / row.scale);
  weights.sided = true;
  weights.values = {0.0, 0.0, 0.0, of_next, unit * (row.viscosity + row.ground_viscosity), -unit * row.viscosity};
  double& of_node = weights.values[row.sign > 0.0 ? 1 : 2];
  of_node = unit * row.ground_stiffness - of_next;
  for (std::size_t k = 0; k < 3; ++k) {
    weights.rates[2 + k] = unit * row.inertia[k];
    weights.values[4 + k] += unit * row.side_drag[k];
  }
  of_node += unit * row.side_stiffness[0];
  weights.values[3] += unit * row.side_stiffness[1];
  weights.values[7] = unit * row.side_stiffness[2];
}

// Off the diagonal of rho M in the row of an end: at its neighbour, and at the next one.
std::array<double, 2> PenalisedSystem::inertia_beside(std::size_t end) const {
  const BandedMatrix& inertia = bar_.inertia();
  if (inertia.off_diagonal.empty()) return {0.0, 0.0};
  const double beside = inertia.off_diagonal[std::min(end, neighbour(end))];
  if (inertia.one_sided.empty()) return {beside, 0.0};
  const std::array<double, 3> row = inertia.one_sided_entries(end, end > 0);
  return {beside + row[1], row[2]};
}

double PenalisedSystem::indicator_offset(std::size_t i, double t) {
  const std::size_t node = contact(i).unknown;
  if (!follows(i) && !(holds(i) && closed(i))) return offsets_[i];
  if (contact(i).joint > 0) {
    const JointRow row = joint_row(i);
    const std::array<double, 3> origins = {origin_at(row.node), origin_at(row.next), origin_at(row.beyond)};
    double force = row.ground_stiffness * origins[0] - row.ground_force - (load_ ? load_->at(t)[row.node] : 0.0);
    for (std::size_t k = 0; k < 3; ++k) force += row.side_stiffness[k] * origins[k];
    return row.sign * (row.stiffness / row.scale * (origins[1] - origins[0]) - force / row.scale);
  }
  double neighbours = contact(i).clearance(origin_at(neighbour(node)));
  for (const Support& support : bar_.supports())
    if (support.unknown == node)
      neighbours += support.stiffness * contact(i).gap * bar_.stretch_at(node) / bar_.bar().modulus;
  if (const SideRows* side = bar_.side(); side && collides(i)) {
    const auto resting = [&](std::size_t j) {
      const std::size_t unknown = j - bar_.first_node();
      if (unknown == node) return -contact(i).sign * contact(i).gap * side->stiffness(j);
      const bool fixed = j < bar_.first_node() || unknown >= size();
      return side->stiffness(j) * (fixed ? bar_.wall(j > 0).value() : origin_at(unknown));
    };
    neighbours -=
        contact(i).sign * bar_.stretch_at(node) / bar_.bar().modulus * side->at_end(bar_.is_right(node), resting);
  }
  if (!load_) return neighbours;
  return neighbours + contact(i).sign * load_->at(t)[node] * bar_.stretch_at(node) / bar_.bar().modulus;
}

bool PenalisedSystem::relaxes(std::size_t i) const {
  return closed(i) && massless(contact(i).unknown) && !follows(i) && !holds(i) && relative_stiffness(i) > stiff;
}

bool PenalisedSystem::has_come_to_rest(std::size_t i, double time) const {
  const PenaltyLaw& law = laws_[i];
  return !by_law(i) && relative_stiffness(i) > stiff &&
         rates_[i] * rates_[i] * law.damping * time > 80.0 * law.stiffness;
}

double PenalisedSystem::penetration_share(std::size_t i) const {
  if (rigid_) return 0.0;
  return follows(i) || holds(i) ? 1.0 / (1.0 + relative_stiffness(i)) : 1.0;
}

double PenalisedSystem::relative_stiffness(std::size_t i) const {
  return laws_[i].stiffness * bar_.stretch_at(contact(i).unknown) / bar_.bar().modulus;
}

void PenalisedSystem::force(double t, std::span<const double> u, std::span<const double> w, std::span<double> out) {
  bar_.internal_force(u, w, out);
  for (std::size_t i = 0; i < origin_force_.size(); ++i) out[i] += origin_force_[i];
  if (load_) {
    const std::span<const double> load = load_->at(t);
    for (std::size_t i = 0; i < out.size(); ++i) out[i] += load[i];
  }
  for (std::size_t i = 0; i < added_.size(); ++i) out[i] += added_[i];
  for (std::size_t i = 0; i < laws_.size(); ++i) {
    if (!closed(i) || holds(i)) continue;
    const std::size_t node = contact(i).unknown;
    const double force = contact_force(i, clearance(i, u), contact(i).of(w));
    out[node] += force;
    if (contact(i).joint > 0) out[node - 1] -= force;
  }
}

void PenalisedSystem::dynamic_stiffness(double m, double c, double k, BandedMatrix& out) const {
  bar_.dynamic_stiffness(m, c, k, out);
  for (std::size_t i = 0; i < laws_.size(); ++i) {
    if (!closed(i)) continue;
    const std::size_t node = contact(i).unknown;
    const double spring = holds(i) ? infinite : k * laws_[i].stiffness + c * laws_[i].damping;
    if (contact(i).joint == 0)
      out.diagonal[node] += spring;
    else if (holds(i))
      out.tie(node - 1);
    else
      out.diagonal[node] += spring, out.diagonal[node - 1] += spring, out.off_diagonal[node - 1] -= spring;
  }
}

void PenalisedSystem::accelerate(std::span<double> force) {
  bool holds_mass = false;
  for (std::size_t i = 0; collides_ && i < laws_.size(); ++i) holds_mass |= indicator_needs_rates(i);
  if (!holds_mass) return bar_.accelerate(force);
  if (held_from_ != revision_) {
    BandedMatrix inertia = bar_.inertia();
    for (std::size_t i = 0; i < laws_.size(); ++i)
      if (indicator_needs_rates(i) && contact(i).joint > 0)
        inertia.tie(contact(i).unknown - 1);
      else if (indicator_needs_rates(i))
        inertia.diagonal[contact(i).unknown] = infinite;
    held_factor_.factorise(inertia);
    held_from_ = revision_;
  }
  held_factor_.solve(force);
}

void PenalisedSystem::expand_acceleration(double t, std::span<const double> u, std::span<const double> w,
                                          std::span<double> nodal) {
  nodal.front() = nodal.back() = 0.0;
  const std::span<double> unknowns = nodal.subspan(bar_.first_node(), size());
  force(t, u, w, unknowns);
  accelerate(unknowns);
  if (bar_.moving()) bar_.add_lift(lift(t, 2), nodal);
}

// The impulse on the bar of closed contact i, which collides(), for a change of the velocities.
double PenalisedSystem::held_impulse(std::size_t i, std::span<const double> change) const {
  if (contact(i).joint > 0) {
    const JointRow row = joint_row(i);
    return row.sign * row.inertia_times(change);
  }
  return contact(i).sign * held_inertia_times(contact(i).unknown, change);
}

// The row of rho M of a held end, which does not move itself, times v.
double PenalisedSystem::held_inertia_times(std::size_t end, std::span<const double> v) const {
  const auto inertia = inertia_beside(end);
  double sum = inertia[0] * v[neighbour(end)];
  if (inertia[1] != 0.0) sum += inertia[1] * v[end == 0 ? 2 : end - 2];
  return sum;
}

// (rho M)^{-1} d_i, closed contacts elsewhere holding their nodes. Those that it would pull by more than a negligible
// part of it are opened, and added.
std::vector<double> PenalisedSystem::answer_of(std::size_t i, double negligible, std::vector<std::size_t>& released) {
  const std::size_t node = contact(i).unknown;
  std::vector<double> answer(size());
  for (;;) {
    std::ranges::fill(answer, 0.0);
    answer[node] = contact(i).sign;
    if (contact(i).joint > 0) answer[node - 1] = -1.0;
    accelerate(answer);
    double most = negligible;
    std::optional<std::size_t> pulled;
    for (std::size_t k = 0; k < laws_.size(); ++k) {
      if (k == i || !closed(k) || !collides(k)) continue;
      if (const double pull = -held_impulse(k, answer); pull > most) most = pull, pulled = k;
    }
    if (!pulled) return answer;
    set_closed(*pulled, false);
    released.push_back(*pulled);
  }
}

PenalisedSystem::Collision PenalisedSystem::collide(std::size_t i, double t, std::span<const double> u,
                                                    std::span<double> w, const Negligible& negligible) {
  const std::size_t node = contact(i).unknown;
  std::vector<std::size_t> released;
  const bool of_joint = contact(i).joint > 0;
  const double sign = contact(i).sign, came = contact(i).of(w);
  const std::vector<double> answer =
      answer_of(i, came == 0.0 ? 1.0 : std::max(least_pull, negligible.velocity / std::abs(came)), released);
  std::vector<double> acceleration(size());
  const double mass = sign / contact(i).of(answer), speed = -sign * came,
               kinetic = 0.5 * bar_.inertia().quadratic_form(w);
  const auto leave_with = [&](double velocity) {
    const double impulse = mass * (velocity - contact(i).of(w));
    for (std::size_t j = 0; j < size(); ++j) w[j] += sign * impulse * answer[j];
    w[node] = of_joint ? w[node - 1] + velocity : velocity;
  };
  leave_with(0.0);
  force(t, u, w, acceleration);
  accelerate(acceleration);
  const double pressed = -sign * contact(i).of(acceleration);
  // A closing is found late, at a depth; what the node has gained by falling there is not thrown back.
  const double gained = 2.0 * std::max(pressed, 0.0) * std::max(-clearance(i, u), 0.0);
  const double rebound = restitution_ * std::sqrt(std::max(speed * speed - gained, 0.0));
  const double height = pressed > 0.0 ? rebound * rebound / (2.0 * pressed) : 0.0;
  bool rests = true;
  if (rebound == 0.0) {
    rests = mass * pressed * bar_.stretch_at(node) / bar_.bar().modulus > -negligible.reaction;
  } else {
    rests = pressed > 0.0 && height <= negligible.displacement;
    if (!rests) leave_with(sign * rebound);
  }
  const double left = contact(i).of(w), dissipated = 0.5 * mass * (speed - left) * (speed + left);
  return {rests,
          dissipated,
          kinetic - 0.5 * bar_.inertia().quadratic_form(w) - dissipated,
          mass * (left + sign * speed),
          height,
          std::move(released)};
}

void PenalisedSystem::tie_joints(std::span<double> w) const {
  BandedMatrix inertia = bar_.inertia();
  for (std::size_t i = 0; i < laws_.size(); ++i)
    if (contact(i).joint > 0 && closed(i) && collides(i)) inertia.tie(contact(i).unknown - 1);
  if (inertia.ties.empty()) return;
  std::vector<double> momentum(size());
  bar_.inertia().multiply(w, momentum);
  TridiagonalFactor factor;
  factor.factorise(inertia);
  factor.solve(momentum);
  std::ranges::copy(momentum, w.begin());
}

void PenalisedSystem::settle(double t, std::span<double> u, std::span<double> w) {
  for (std::size_t i = 0; i < laws_.size(); ++i) set_closed(i, false);
  complete_displacement(t, u);
  complete_velocity(t, u, w);
  if (laws_.empty()) return;
  const double largest = largest_displacement(u);
  std::vector<double> acceleration;
  std::vector<unsigned char> press(laws_.size(), 0);
  for (std::size_t i = 0; i < laws_.size(); ++i) {
    const double sign = contact(i).sign, clear = clearance(i, u), rounding = clearance_rounding(i, largest);
    if (moves(i) || clear > rounding) continue;
    if (clear < -rounding || sign * contact(i).of(w) < 0.0) {
      press[i] = 1;
    } else if (contact(i).of(w) == 0.0) {
      if (acceleration.empty()) {
        acceleration.resize(size());
        force(t, u, w, acceleration);
        accelerate(acceleration);
      }
      press[i] = sign * contact(i).of(acceleration) < 0.0 ? 1 : 0;
    }
  }
  for (std::size_t i = 0; i < laws_.size(); ++i)
    if (press[i]) set_closed(i, true);
  complete_displacement(t, u);
  complete_velocity(t, u, w);
}

std::array<double, 3> PenalisedSystem::reactions(double t, std::span<const double> u, std::span<const double> w) {
  std::array<double, 3> sum{};
  bool accelerated = false;
  for (std::size_t i = 0; i < laws_.size(); ++i) {
    const std::size_t node = contact(i).unknown;
    const bool left = node == 0 && !bar_.left_fixed(), right = node + 1 == size() && !bar_.right_fixed();
    const bool span = contact(i).where == Where::span;
    if (!closed(i) || contact(i).joint > 0 || !(left || right || span)) continue;
    const double sign = contact(i).sign;
    if (collides(i) && !std::exchange(accelerated, true)) accelerate_held(t, u, w);
    const double clear = clearance(i, u);
    const double reaction = holds(i)  ? std::max(0.0, sign * (collides(i) ? held_force(i) : holding_force(i, t, u, w)))
                            : stop(i) ? std::max(0.0, clear < 0.0 ? sign * contact_force(i, clear, w[node]) : 0.0)
                                      : laws_[i].reaction(-clear, -sign * w[node]);
    if (left) sum[0] += sign * reaction;
    if (right) sum[1] += sign * reaction;
    if (span) sum[2] += sign * reaction;
  }
  return sum;
}

std::vector<double> PenalisedSystem::joint_forces(double t, std::span<const double> u, std::span<const double> w) {
  std::vector<double> forces, acceleration, force_of_rows;
  for (std::size_t i = 0; i < laws_.size(); ++i) {
    if (contact(i).joint == 0) continue;
    double& force_here = forces.emplace_back(0.0);
    if (!closed(i)) continue;
    if (!holds(i)) {
      force_here = contact_force(i, clearance(i, u), contact(i).of(w));
      if (stop(i)) force_here = std::max(force_here, 0.0);
      continue;
    }
    if (acceleration.empty()) {
      acceleration.resize(size());
      force(t, u, w, acceleration);
      force_of_rows = acceleration;
      accelerate(acceleration);
    }
    force_here = std::max(0.0, joint_force(i, force_of_rows, acceleration));
  }
  return forces;
}

double PenalisedSystem::joint_force(std::size_t i, std::span<const double> force, std::span<const double> a) const {
  const JointRow row = joint_row(i);
  return row.sign * (row.inertia_times(a) - force[row.node]);
}

double PenalisedSystem::holding_force(std::size_t i, double t, std::span<const double> u, std::span<const double> w) {
  if (contact(i).joint > 0) {
    std::vector<double> of_rows(size());
    force(t, u, w, of_rows);
    std::vector<double> acceleration = of_rows;
    accelerate(acceleration);
    return joint_force(i, of_rows, acceleration);
  }
  if (collides(i)) {
    accelerate_held(t, u, w);
    return held_force(i);
  }
  return contact(i).sign * row_reaction(i, t, u, w) * (1.0 - penetration_share(i));
}

double PenalisedSystem::row_reaction(std::size_t i, double t, std::span<const double> u, std::span<const double> w) {
  const std::size_t node = contact(i).unknown, next = neighbour(node);
  const double sign = contact(i).sign;
  const double stress = bar_.bar().modulus * (sign * u[next] + contact(i).clearance(origin_at(next))) +
                        bar_.bar().viscosity * sign * w[next];
  return -stress / bar_.stretch_at(node) - sign * load(node, t);
}

// One solve serves all contacts that hold nodes with mass.
void PenalisedSystem::accelerate_held(double t, std::span<const double> u, std::span<const double> w) {
  acceleration_.resize(size());
  force(t, u, w, acceleration_);
  accelerate_held();
}

// Under the force in acceleration_, which becomes that.
void PenalisedSystem::accelerate_held() {
  lacking_ = {-acceleration_.front(), -acceleration_.back()};
  accelerate(acceleration_);
}

// The row of a held end, after accelerate_held().
double PenalisedSystem::held_force(std::size_t i) const {
  const std::size_t node = contact(i).unknown;
  return lacking_[node == 0 ? 0 : 1] + held_inertia_times(node, acceleration_);
}

std::vector<double> PenalisedSystem::displacement(std::span<const double> u) const {
  std::vector<double> displacement(u.begin(), u.end());
  for (std::size_t i = 0; i < origin_.size(); ++i) displacement[i] += origin_[i];
  return displacement;
}

double PenalisedSystem::energy(std::span<const double> u, std::span<const double> w) const {
  return bar_.energy(displacement(u), w) + contact_energy(u);
}

double PenalisedSystem::contact_energy(std::span<const double> u) const {
  double sum = 0.0;
  for (std::size_t i = 0; i < laws_.size(); ++i)
    if (!holds(i) && !moves(i) && !stop(i)) sum += laws_[i].energy(-clearance(i, u));
  for (const auto& [i, law] : stops_)
    if (closed(i)) sum += law.energy(-clearance(i, u));
  return sum;
}

double PenalisedSystem::frame_energy(double t, std::span<const double> u, std::span<const double> w) const {
  return frame_energy(bar_, bar_.moving() ? load_->inside(t) : t, u, w);
}

double PenalisedSystem::frame_energy(const BarSystem& bar, double t, std::span<const double> u,
                                     std::span<const double> w) const {
  if (!bar.moving()) return 0.0;
  const std::vector<double> in_frame = displacement(u);
  return bar.lifted_energy(bar.lift(t, 0), bar.lift(t, 1), in_frame, w).total() - bar.energy(in_frame, w);
}

double PenalisedSystem::change_frame(const BarSystem& to, double t, std::span<double> u, std::span<double> w) const {
  const double before = frame_energy(t, u, w);
  bar_.change_frame(to, t, u, w);
  return frame_energy(to, t, u, w) - before;
}

PenalisedSystem::EndPower PenalisedSystem::end_power(double t, std::span<const double> u, std::span<const double> w,
                                                     std::span<const double> a) const {
  double of_frame =
      bar_.moving() ? bar_.lift_end_power(lift(t, 1), lift(t, 2), bar_.at_nodes(w), bar_.at_nodes(RowValues{a, size()}))
                    : 0.0;
  double own = bar_.end_power(w, a);
  if (const SideRows* side = bar_.side(); side && side->has_row_power()) {
    const auto placed = [this, of = bar_.displacement_at_nodes(u), first = bar_.first_node()](std::size_t j) {
      const bool unknown = !origin_.empty() && j >= first && j - first < origin_.size();
      return unknown ? of(j) + origin_[j - first] : of(j);
    };
    own += side->row_power(bar_.at_nodes(w), placed);
    if (bar_.moving()) of_frame += bar_.side_lift_power(lift(t, 0), lift(t, 1), bar_.at_nodes(w), placed);
  }
  return {own + of_frame, of_frame};
}

double PenalisedSystem::load_power(double t, std::span<const double> w) {
  const std::span<const double> load = load_->at(t);
  return std::inner_product(load.begin(), load.end(), w.begin(), 0.0);
}

}  // namespace viscobar

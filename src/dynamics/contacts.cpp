#include "dynamics/contacts.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <utility>

namespace viscobar {

namespace {

constexpr double infinite = std::numeric_limits<double>::infinity();

// How many of the two nodes of a joint are ends of bars.
int bars_at(const BarSystem& bar, const Contact& contact) {
  const std::size_t right = contact.unknown + bar.unknowns().first_node();
  return (bar.elements().is_of_bar(right) ? 1 : 0) + (right > 1 && bar.elements().is_of_bar(right - 2) ? 1 : 0);
}

ContactLaw law_of(const BarSystem& bar, const Contact& contact, const Penalty& penalty) {
  const bool rigid = penalty.epsilon == 0.0;
  if (const auto& stop = bar.stop(contact)) {
    if (rigid || bar.inertia().massless(contact.unknown))
      throw std::invalid_argument("a stop with a law of its own wants a node with mass, and is not rigid");
    return {contact.sign, *stop};
  }
  if (rigid) return {contact.sign, PenaltyLaw{infinite, 0.0}};
  return {contact.sign,
          penalty_law(penalty, contact.weight, penalty.restitution < 1.0 ? bar.inertia().contact_mass(contact) : 0.0)};
}

}  // namespace

Contacts::Contacts(const BarSystem& bar, const Penalty& penalty)
    : bar_(bar), closed_(bar.contacts().size(), 0), measured_(closed_) {
  for (const Contact& contact : bar.contacts()) add(contact, penalty);
  find_offsets();
}

void Contacts::add(const Contact& contact, const Penalty& penalty) {
  const bool rigid = penalty.epsilon == 0.0, of_bar = bars_at(bar_, contact) > 0;
  if (rigid && contact.where == Where::span)
    throw std::invalid_argument("a rigid obstacle under the whole span stops several nodes at once: not for rigid");
  const std::size_t i = nodes_.size(), node = contact.unknown;
  const bool met = is_met_elsewhere(i, node);
  const bool by_law = contact.joint == 0 ? met : !of_bar && (!rigid || (met && is_met_elsewhere(i, node - 1)));
  if (rigid && bar_.size() < 2)
    throw std::invalid_argument("a rigid obstacle needs an unknown node beside that of the contact");
  const bool massless = bar_.inertia().massless(node);
  ContactNode one{contact, law_of(bar_, contact, penalty)};
  const PenaltyLaw& law = one.law.linear();
  const Bar& bar = bar_.bar();
  one.restitution = penalty.restitution;
  one.relative_stiffness = law.stiffness * bar_.elements().stretch_beside(node) / bar.modulus;
  one.has_body = contact.joint > 0 && bars_at(bar_, contact) < 2;
  one.moves = bar_.frame().moves(contact);
  one.rigid = rigid, one.massless = massless, one.of_bar = of_bar, one.met = met, one.by_law = by_law;
  one.follows = massless && !bar_.bar().damped(), one.changes_by_row = massless && bar_.bar().damped();
  one.collides = rigid && !massless;
  one.rate = massless || rigid ? 0.0 : rate_of(one);
  const double viscous = bar.viscosity / (bar_.elements().stretch_beside(node) * bar.impedance());
  one.holds = rigid || (massless && one.relative_stiffness * std::numeric_limits<double>::epsilon() > 1.0 + viscous);
  collides_ |= one.collides;
  dashpots_ |= law.damping > 0.0;
  bend_ |= one.law.bent() != nullptr;
  if (const Stop* stop = one.law.stop()) stops_ = true, stops_take_ |= stop->damping > 0.0;
  nodes_.push_back(one);
}

double Contacts::rate_of(const ContactNode& node) const {
  const BandedMatrix& inertia = bar_.inertia().matrix();
  const double stiffness = node.law.linear().stiffness, mass = inertia.diagonal_entry(node.unknown);
  if (node.joint == 0) return std::sqrt(stiffness / mass);
  return std::sqrt(stiffness * (1.0 / mass + 1.0 / inertia.diagonal_entry(node.unknown - 1)));
}

// True if a contact other than i, of the joint or end on the other side, has that node.
bool Contacts::is_met_elsewhere(std::size_t i, std::size_t unknown) const {
  const std::vector<Contact>& all = bar_.contacts();
  for (std::size_t k = 0; k < all.size(); ++k) {
    const bool of_joint = all[k].joint > 0;
    if (k == i || (!of_joint && all[i].joint == 0)) continue;
    if (all[k].unknown == unknown || (of_joint && all[k].unknown == unknown + 1)) return true;
  }
  return false;
}

bool Contacts::held(std::size_t unknown) const {
  for (std::size_t i = 0; i < size(); ++i)
    if (closed_at(i, unknown) && nodes_[i].holds) return true;
  return false;
}

void Contacts::tie_joints(BandedMatrix& matrix) const {
  for (std::size_t i = 0; i < size(); ++i)
    if (nodes_[i].joint > 0 && holds_mass(i)) matrix.tie(nodes_[i].unknown - 1);
}

void Contacts::measure(std::size_t closing, std::span<double> u) {
  if (measured_[closing] || nodes_[closing].joint > 0) return;
  std::vector<bool> node_is_measured(bar_.size());  // from its other obstacle
  for (std::size_t i = 0; i < size(); ++i)
    if (measured_[i]) node_is_measured[nodes_[i].unknown] = true;
  std::vector<double> origin(origin_.values().begin(), origin_.values().end());
  bool any = false;
  for (std::size_t i = 0; i < size(); ++i) {
    const std::size_t node = nodes_[i].unknown;
    if (nodes_[i].where != nodes_[closing].where || nodes_[i].sign != nodes_[closing].sign || node_is_measured[node])
      continue;
    any = true;
    measured_[i] = 1;
    origin.resize(bar_.size());
    origin[node] = -nodes_[i].sign * nodes_[i].gap;
    if (!u.empty()) u[node] -= origin[node];
  }
  if (!any) return;
  origin_.move(bar_, std::move(origin));
  find_offsets();
}

void Contacts::find_offsets() {
  offsets_.clear();
  for (const ContactNode& node : nodes_)
    offsets_.push_back(node.joint > 0 ? node.gap + origin_.at(node.unknown) - origin_.at(node.unknown - 1)
                                      : node.clearance(origin_.at(node.unknown)));
}

}  // namespace viscobar

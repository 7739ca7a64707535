#include "dynamics/contacts.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <optional>
#include <stdexcept>
#include <utility>

namespace viscobar {

namespace {

constexpr double infinite = std::numeric_limits<double>::infinity();

// True if the node of a contact to one side of it is the end of a bar, or bonded to one.
bool is_bar(const BarSystem& bar, const Contact& contact, bool to_right) {
  const std::size_t right = contact.unknown + bar.unknowns().first_node(), left = contact.joint > 0 ? 2 : 1;
  return to_right ? bar.elements().is_of_bar(right) : right >= left && bar.elements().is_of_bar(right - left);
}

// How many of the two nodes of a joint are such.
int bars_at(const BarSystem& bar, const Contact& contact) {
  return (is_bar(bar, contact, true) ? 1 : 0) + (is_bar(bar, contact, false) ? 1 : 0);
}

// The contact that meets a rigid body from its other side.
std::optional<std::size_t> contact_beyond(const BarSystem& bar, const Contact& contact, bool to_right) {
  const std::vector<Contact>& all = bar.contacts();
  if (is_bar(bar, contact, to_right)) return std::nullopt;
  const std::size_t node = to_right || contact.joint == 0 ? contact.unknown : contact.unknown - 1;
  for (std::size_t k = 0; k < all.size(); ++k) {
    const bool of_end = all[k].joint == 0 && contact.joint > 0 && all[k].unknown == node;
    if (of_end || (all[k].joint > 0 && all[k].unknown == (to_right ? node + 1 : node))) return k;
  }
  return std::nullopt;
}

// True if rows to that side tell the force of a contact: bodies end at a bar, or where nothing else pushes them.
bool has_rows(const BarSystem& bar, const Contact& contact, bool to_right) {
  for (auto k = contact_beyond(bar, contact, to_right); k; k = contact_beyond(bar, bar.contacts()[*k], to_right))
    if (bar.contacts()[*k].joint == 0) return false;
  return true;
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
  const std::size_t node = contact.unknown;
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
  one.rigid = rigid, one.massless = massless, one.of_bar = of_bar;
  find_row(one);
  one.follows = massless && !bar_.bar().damped(), one.changes_by_row = massless && bar_.bar().damped();
  one.collides = rigid && !massless;
  one.rate = massless || rigid ? 0.0 : rate_of(one);
  const double viscous = bar.viscosity / (bar_.mesh().element(bar_.elements().beside(node)) * bar.impedance());
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

// The row of a bar's end is the best, then that of a body that no other contact meets. A contact beyond a body goes on
// to the same side.
void Contacts::find_row(ContactNode& node) const {
  const auto is_end_of_bar = [&](bool to_right) { return is_bar(bar_, node, to_right); };
  const auto is_alone = [&](bool to_right) { return !contact_beyond(bar_, node, to_right); };
  const auto has_any = [&](bool to_right) { return has_rows(bar_, node, to_right); };
  if (node.joint == 0)
    node.to_right = node.unknown == 0;
  else
    node.to_right =
        is_end_of_bar(true) || (!is_end_of_bar(false) && (is_alone(true) || (!is_alone(false) && has_any(true))));
  node.beyond = contact_beyond(bar_, node, node.to_right);
  assert(has_any(node.to_right));  // a chain has a bar
  node.by_law = !node.rigid && (node.joint > 0 ? !node.of_bar : node.beyond.has_value());
}

bool Contacts::held(std::size_t unknown) const {
  const auto holds = [this](std::size_t i) { return closed(i) && nodes_[i].holds; };
  for (std::size_t i = 0; i < size(); ++i) {
    if (nodes_[i].joint > 0 || !holds(i)) continue;
    const auto [low, high] = std::minmax(nodes_[i].unknown, unknown);
    std::size_t ties = 0;
    for (std::size_t k = 0; k < size() && low < high; ++k)
      ties += nodes_[k].joint > 0 && low < nodes_[k].unknown && nodes_[k].unknown <= high && holds(k) ? 1 : 0;
    if (ties == high - low) return true;
  }
  return false;
}

void Contacts::tie_joints(BandedMatrix& matrix) const {
  const auto ties = [this](std::size_t i) { return nodes_[i].joint > 0 && holds_mass(i); };
  const auto is_held = [&](std::size_t i) { return std::isinf(matrix.diagonal[nodes_[i].unknown]); };
  const auto hold = [&](std::size_t i) {
    double &left = matrix.diagonal[nodes_[i].unknown - 1], &right = matrix.diagonal[nodes_[i].unknown];
    if (std::isinf(left) || std::isinf(right)) left = right = infinite;
  };
  for (std::size_t i = 0; i < size(); ++i)
    if (ties(i)) hold(i);
  for (std::size_t i = size(); i-- > 0;)
    if (ties(i)) hold(i);
  for (std::size_t i = 0; i < size(); ++i)
    if (ties(i) && !is_held(i)) matrix.tie(nodes_[i].unknown - 1);
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

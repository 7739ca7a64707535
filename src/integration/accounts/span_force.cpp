#include "integration/accounts/span_force.hpp"

#include <algorithm>

#include "integration/accounts/peak.hpp"
#include "integration/bernstein.hpp"

namespace viscobar {

SpanForce::SpanForce(const Contacts& contacts, SpanAccount& account) : contacts_(contacts), account_(account) {
  for (std::size_t i = 0; i < contacts.size(); ++i)
    if (contacts[i].where == Where::span) nodes_.push_back({i, 0, 0, contacts[i].law.linear().damping > 0.0});
}

void SpanForce::ask_for(std::vector<std::size_t>& entries) {
  for (Node& node : nodes_) {
    const std::size_t unknown = contacts_[node.contact].unknown;
    node.displacement = node.velocity = entries.size();
    entries.push_back(unknown);
    if (!node.damped) continue;
    node.velocity = entries.size();
    entries.push_back(contacts_.bar().size() + unknown);
  }
}

void SpanForce::select(std::vector<std::size_t>& positions) const {
  for (const Node& node : nodes_) {
    if (!contacts_.closed(node.contact)) continue;
    positions.push_back(node.displacement);
    if (node.damped) positions.push_back(node.velocity);
  }
}

bool SpanForce::closed() const {
  return std::ranges::any_of(nodes_, [this](const Node& node) { return contacts_.closed(node.contact); });
}

void SpanForce::add(double to, double length, std::size_t order) {
  if (!closed()) return;
  const std::span<const double> force = std::span(force_).first(order + 1);
  account_.impulse += length * Bernstein::mean(force);
  raise_peak(account_, force, to, length);
}

void SpanForce::look_at(std::size_t order, std::span<const PointValues> y) {
  if (nodes_.empty()) return;
  force_ = {};
  for (const Node& node : nodes_) {
    if (!contacts_.closed(node.contact)) continue;
    const Contact& contact = contacts_[node.contact];
    const double origin = origin_.empty() ? 0.0 : origin_[contact.unknown];
    const auto& law = contacts_[node.contact].law.linear();
    for (std::size_t j = 0; j <= order; ++j) {
      force_[j] -= contact.sign * law.stiffness * (contact.sign * y[node.displacement][j] + contact.clearance(origin));
      if (node.damped) force_[j] -= law.damping * y[node.velocity][j];
    }
  }
}

}  // namespace viscobar

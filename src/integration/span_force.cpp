#include "integration/span_force.hpp"

#include <algorithm>

namespace viscobar {

SpanForce::SpanForce(const PenalisedSystem& system, SpanAccount& account) : system_(system), account_(account) {
  for (std::size_t i = 0; i < system.contact_count(); ++i)
    if (system.contact(i).where == Where::span) nodes_.push_back({i, 0, 0, system.law(i).damping > 0.0});
}

void SpanForce::ask_for(std::vector<std::size_t>& entries) {
  for (Node& node : nodes_) {
    const std::size_t unknown = system_.contact(node.contact).unknown;
    node.displacement = node.velocity = entries.size();
    entries.push_back(unknown);
    if (!node.damped) continue;
    node.velocity = entries.size();
    entries.push_back(system_.size() + unknown);
  }
}

void SpanForce::select(std::vector<std::size_t>& positions) const {
  for (const Node& node : nodes_) {
    if (!system_.closed(node.contact)) continue;
    positions.push_back(node.displacement);
    if (node.damped) positions.push_back(node.velocity);
  }
}

bool SpanForce::closed() const {
  return std::ranges::any_of(nodes_, [this](const Node& node) { return system_.closed(node.contact); });
}

void SpanForce::add(double length, std::size_t order) {
  if (!closed()) return;
  const std::span<const double> force = std::span(force_).first(order + 1);
  account_.impulse += length * Bernstein::mean(force);
  const auto [least, most] = std::ranges::minmax(force);
  const double beyond = std::max(most, -least) + Bernstein::excess(order) * (most - least);
  if (beyond <= account_.peak_reaction) return;
  const Bernstein polynomial = Bernstein::through(force);
  account_.peak_reaction =
      std::max(polynomial.largest(account_.peak_reaction), -polynomial.smallest(-account_.peak_reaction));
}

double SpanForce::force(std::span<const double> y) const {
  double sum = 0.0;
  for (const Node& node : nodes_) {
    if (!system_.closed(node.contact)) continue;
    const Contact& contact = system_.contact(node.contact);
    const double origin = origin_.empty() ? 0.0 : origin_[contact.unknown];
    const auto& law = system_.law(node.contact);
    sum -= contact.sign * law.stiffness * (contact.sign * y[node.displacement] + contact.clearance(origin));
    if (node.damped) sum -= law.damping * y[node.velocity];
  }
  return sum;
}

}  // namespace viscobar

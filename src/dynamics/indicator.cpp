#include "dynamics/indicator.hpp"

#include <algorithm>

#include "dynamics/contact_rows.hpp"

namespace viscobar {

namespace {

// The weights of -N over the scale of the row.
void add_joint_weights(const JointRow& row, IndicatorWeights& weights) {
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

}  // namespace

std::vector<std::size_t> Indicators::entries(std::size_t i) const {
  const Contacts& contacts = contacts_;
  const BarSystem& bar = contacts.bar();
  const std::size_t node = contacts[i].unknown;
  if (contacts[i].has_joint_row()) {
    std::vector<std::size_t> entries = {node, node, contacts[i].joint > 0 ? node - 1 : node};
    if (push_weights(contacts, i)) entries.insert(entries.end(), {bar.size() + node, bar.size() + node - 1});
    if (!contacts[i].collides) return entries;
    const JointRow row = joint_row(contacts, i);
    entries.insert(entries.end(), {row.next, bar.size() + row.node, bar.size() + row.next, bar.size() + row.beyond});
    if (bar.side()) entries.push_back(row.beyond);
    return entries;
  }
  if (contacts[i].follows) return {neighbour(node)};
  if (push_weights(contacts, i)) return {node, node, bar.size() + node};
  if (!contacts[i].holds) return {node};
  std::vector<std::size_t> entries = {node, neighbour(node), bar.size() + neighbour(node)};
  const std::size_t beyond = node == 0 ? 2 : node - 2;
  if (contacts[i].collides && !bar.inertia().matrix().one_sided.empty()) entries.push_back(bar.size() + beyond);
  if (contacts[i].collides && !bar.inertia().matrix().one_sided.empty() && bar.side()) entries.push_back(beyond);
  return entries;
}

IndicatorWeights Indicators::weights(std::size_t i) const {
  const Contacts& contacts = contacts_;
  const BarSystem& bar = contacts.bar();
  const double sign = contacts[i].sign;
  IndicatorWeights weights{.values = {sign}};
  const bool held = contacts[i].holds && contacts.closed(i);
  weights.varying = offset(i);
  if (weights.varying.load == 0.0) weights.offset = weights.varying.rest;
  if (held && contacts[i].has_joint_row()) {
    weights.alone = false;
    add_joint_weights(holding_row(contacts, i), weights);
    return weights;
  }
  if (contacts[i].joint > 0) {
    weights.alone = false;
    weights.values = {0.0, 1.0, -1.0};
    return weights;
  }
  if (!held || contacts[i].follows) return weights;
  const Bar& material = bar.bar();
  weights.values = {0.0, sign,
                    bar.elements().is_chain()
                        ? sign * material.viscosity /
                              bar.elements().rate_stretch(bar.elements().beside(contacts[i].unknown)) *
                              bar.elements().stretch_beside(contacts[i].unknown) / material.modulus
                        : sign * material.viscosity / material.modulus};
  weights.alone = false;
  if (!contacts[i].collides) return weights;
  const std::size_t node = contacts[i].unknown;
  const std::array<double, 2> inertia = inertia_beside(bar.inertia().matrix(), node);
  for (std::size_t k = 0; k < inertia.size(); ++k)
    weights.rates[k] = -sign * bar.elements().stretch_beside(node) / material.modulus * inertia[k];
  const SideRows* side = bar.side();
  if (!side) return weights;
  // The row of the side, but for the node itself.
  weights.sided = true;
  const bool right = bar.unknowns().is_right(node);
  const std::array<double, 3> row = side->end_row(right);
  const auto share = [&](std::size_t k, bool drag) {
    const std::size_t j = right ? bar.mesh().elements - k : k;
    return -sign * bar.elements().stretch_beside(node) / material.modulus * row[k] *
           (drag ? side->drag(j) : side->stiffness(j));
  };
  weights.values[1] += share(1, false), weights.values[2] += share(1, true);
  if (!bar.inertia().matrix().one_sided.empty())
    weights.values[3] = share(2, true), weights.values[4] = share(2, false);
  return weights;
}

IndicatorOffset Indicators::offset(std::size_t i) const {
  const Contacts& contacts = contacts_;
  const BarSystem& bar = contacts.bar();
  const std::size_t node = contacts[i].unknown;
  if (!contacts[i].follows && !(contacts[i].holds && contacts.closed(i))) return {contacts.offset(i)};
  if (contacts[i].has_joint_row()) {
    const JointRow row = holding_row(contacts, i);
    const std::array<double, 3> origins = {contacts.origin().at(row.node), contacts.origin().at(row.next),
                                           contacts.origin().at(row.beyond)};
    double force = row.ground_stiffness * origins[0] - row.ground_force;
    for (std::size_t k = 0; k < 3; ++k) force += row.side_stiffness[k] * origins[k];
    return {row.sign * (row.stiffness / row.scale * (origins[1] - origins[0]) - force / row.scale),
            load_.acts() ? row.sign / row.scale : 0.0, std::min(row.node, row.last), std::max(row.node, row.last)};
  }
  double neighbours = contacts[i].clearance(contacts.origin().at(neighbour(node)));
  for (const Support& support : bar.supports())
    if (support.unknown == node)
      neighbours += support.stiffness * contacts[i].gap * bar.elements().stretch_beside(node) / bar.bar().modulus;
  if (const SideRows* side = bar.side(); side && contacts[i].collides) {
    const auto resting = [&](std::size_t j) {
      const std::size_t unknown = j - bar.unknowns().first_node();
      if (unknown == node) return -contacts[i].sign * contacts[i].gap * side->stiffness(j);
      const bool fixed = j < bar.unknowns().first_node() || unknown >= bar.size();
      return side->stiffness(j) * (fixed ? bar.unknowns().wall(j > 0).value() : contacts.origin().at(unknown));
    };
    neighbours -= contacts[i].sign * bar.elements().stretch_beside(node) / bar.bar().modulus *
                  side->at_end(bar.unknowns().is_right(node), resting);
  }
  const double share = contacts[i].sign * bar.elements().stretch_beside(node) / bar.bar().modulus;
  return {neighbours, load_.acts() ? share : 0.0, node, node};
}

double Indicators::rounding(std::size_t i, double largest) const {
  const ContactNode& node = contacts_[i];
  const double rounding = node.clearance_rounding(largest);
  const bool answers = contacts_.closed(i) && contacts_.measured(i) && !node.follows && !node.holds;
  return answers ? rounding / (1.0 + node.relative_stiffness) : rounding;
}

std::optional<IndicatorWeights> push_weights(const Contacts& contacts, std::size_t i) {
  const Stop* law = contacts[i].law.stop();
  const auto push = law ? law->push(contacts.bar().bar().transit()) : std::nullopt;
  if (!push) return std::nullopt;
  const double sign = contacts[i].sign, offset = push->a * contacts.offset(i) - push->e;
  if (contacts[i].joint > 0)
    return IndicatorWeights{
        .values = {0.0, push->a, -push->a, push->b, -push->b}, .sided = true, .alone = false, .offset = offset};
  return IndicatorWeights{.values = {0.0, sign * push->a, sign * push->b}, .alone = false, .offset = offset};
}

double push_rate(const Contacts& contacts, std::size_t i, double clearance, double w, double w_bar, const Stop& rates) {
  const double time = contacts.bar().bar().transit();
  const Stop& stop = *contacts[i].law.stop();
  const Stop::Push push = *stop.push(time), rate = stop.push_rate(time, rates);
  return push.a * clearance + contacts[i].sign * (push.b * w + rate.b * w_bar) - rate.e;
}

}  // namespace viscobar

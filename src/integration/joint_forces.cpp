#include "integration/joint_forces.hpp"

#include <algorithm>
#include <tuple>

#include "integration/bernstein.hpp"
#include "integration/peak.hpp"

namespace viscobar {

JointForces::JointForces(const Contacts& contacts, const ActingLoad& load, RunAccount& account)
    : contacts_(contacts), load_(load) {
  std::size_t last = account.joints.size();
  for (std::size_t i = 0; i < contacts.size(); ++i) last = std::max(last, contacts[i].joint);
  account.joints.resize(last);
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    if (!contacts[i].has_joint_row()) continue;
    const JointRow row = joint_row(contacts, i);
    if (const std::size_t number = contacts[i].joint; number > 0)
      joints_.push_back({i, &account.joints[number - 1], row, row.sign});
    else
      joints_.push_back({i, contacts[i].unknown > 0 ? &account.right : &account.left, row, 1.0});
  }
}

void JointForces::begin() {
  for (Joint& joint : joints_) joint.row = joint_row(contacts_, joint.contact);
}

void JointForces::ask_for(std::vector<std::size_t>& entries) {
  const std::size_t n = contacts_.bar().size();
  for (Joint& joint : joints_) {
    const auto& row = joint.row;
    std::size_t k = 0;
    for (const std::size_t entry : {row.node, row.next, n + row.node, n + row.next, n + row.beyond, row.beyond})
      if (k < used()) joint.positions[k++] = position_of(entry, entries);
  }
}

void JointForces::select(std::vector<std::size_t>& positions) const {
  for (const Joint& joint : joints_)
    if (contacts_.closed(joint.contact))
      positions.insert(positions.end(), joint.positions.begin(),
                       joint.positions.begin() + static_cast<std::ptrdiff_t>(used()));
}

bool JointForces::closed() const {
  return std::ranges::any_of(joints_, [this](const Joint& joint) { return contacts_.closed(joint.contact); });
}

void JointForces::look_at(double from, double to, std::size_t order, std::span<const PointValues> y) {
  // Time by time, since a load is evaluated once for all that ask for it at one time.
  for (std::size_t j = 0; load_.acts() && j <= order; ++j) {
    const double t = point_of(from, to, order, j);
    for (Joint& joint : joints_)
      if (contacts_.closed(joint.contact))
        joint.load[j] = joint.row.sum_over_rows([&](std::size_t node) { return load_.alone(node, t); });
  }
  for (Joint& joint : joints_)
    if (contacts_.closed(joint.contact)) look_at(joint, order, y);
}

// At all points at once, those behind the order as well.
void JointForces::look_at(Joint& joint, std::size_t order, std::span<const PointValues> y) const {
  const auto& [row, at] = std::tie(joint.row, joint.positions);
  const auto origin = [this](std::size_t unknown) { return origin_.empty() ? 0.0 : origin_[unknown]; };
  const PointValues &u = y[at[0]], &u_next = y[at[1]], &w = y[at[2]], &w_next = y[at[3]], &w_beyond = y[at[4]];
  const double of_node = origin(row.node), apart = origin(row.node) - origin(row.next);
  const ContactNode& contact = contacts_[joint.contact];
  for (std::size_t j = 0; contact.by_law && j <= order; ++j)
    joint.rate[j] = contact.law.force(u[j] - u_next[j] + apart + contact.gap, w[j] - w_next[j]);
  if (contact.by_law) return;
  for (std::size_t j = 0; j < u.size(); ++j) {
    const double stretch = u[j] - u_next[j] + apart, displacement = u[j] + of_node;
    joint.momentum[j] = row.inertia[0] * w[j] + row.inertia[1] * w_next[j] + row.inertia[2] * w_beyond[j] +
                        row.viscosity * stretch + row.ground_viscosity * displacement;
    joint.rate[j] = row.stiffness * stretch + (row.ground_stiffness * displacement - row.ground_force) - joint.load[j];
  }
  if (!contacts_.bar().side()) return;
  const std::array<std::size_t, 3> unknowns = {row.node, row.next, row.beyond}, positions = {at[0], at[1], at[5]};
  for (std::size_t k = 0; k < 3; ++k)
    for (std::size_t j = 0; j < u.size(); ++j)
      joint.rate[j] +=
          row.side_stiffness[k] * (y[positions[k]][j] + origin(unknowns[k])) + row.side_drag[k] * y[at[2 + k]][j];
}

void JointForces::strike(std::size_t contact, double impulse, std::span<const double> change) {
  for (Joint& joint : joints_) {
    double& sum = joint.account->impulse;
    if (joint.contact == contact)
      sum += impulse;
    else if (contacts_.holds_mass(joint.contact))
      sum += joint.direction * held_inertia_times(contacts_, joint.contact, change, contact);
  }
}

void JointForces::add(double to, double length, std::size_t order, bool peaks) {
  for (Joint& joint : joints_) {
    if (!contacts_.closed(joint.contact)) continue;
    const auto used = [order](auto& values) { return std::span(values).first(order + 1); };
    joint.account->impulse +=
        joint.direction * (joint.momentum[order] - joint.momentum[0] + length * Bernstein::mean(used(joint.rate)));
    if (!peaks) continue;
    const auto inertia = Bernstein::slopes(used(joint.momentum));
    for (std::size_t j = 0; j <= order; ++j) joint.rate[j] = joint.direction * (joint.rate[j] + inertia[j] / length);
    const bool pulls = contacts_[joint.contact].joint == 0;
    raise_peak(*joint.account, used(joint.rate), to, length, pulls);
  }
}

}  // namespace viscobar

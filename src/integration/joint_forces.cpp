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
    for (const std::size_t entry : {row.node, row.next, n + row.node, n + row.next, n + row.beyond, row.beyond}) {
      if (k == used()) break;
      joint.positions[k++] = entries.size();
      entries.push_back(entry);
    }
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
  for (Joint& joint : joints_)
    for (std::size_t j = 0; contacts_.closed(joint.contact) && j <= order; ++j) look_at(joint, j, from, to, order, y);
}

void JointForces::look_at(Joint& joint, std::size_t j, double from, double to, std::size_t order,
                          std::span<const PointValues> y) const {
  const auto& [row, at] = std::tie(joint.row, joint.positions);
  const auto value = [&](std::size_t k) { return y[at[k]][j]; };
  double stretch = value(0) - value(1);
  if (!origin_.empty()) stretch += origin_[row.node] - origin_[row.next];
  if (contacts_[joint.contact].by_law) {
    joint.rate[j] = contacts_[joint.contact].law.force(stretch + contacts_[joint.contact].gap, value(2) - value(3));
    return;
  }
  const auto displacement = [&](std::size_t k) {
    const std::array<std::size_t, 3> unknowns = {row.node, row.next, row.beyond}, u = {0, 1, 5};
    return value(u[k]) + (origin_.empty() ? 0.0 : origin_[unknowns[k]]);
  };
  joint.momentum[j] = row.inertia[0] * value(2) + row.inertia[1] * value(3) + row.inertia[2] * value(4) +
                      row.viscosity * stretch + row.ground_viscosity * displacement(0);
  const double t = point_of(from, to, order, j);
  joint.rate[j] = row.stiffness * stretch + (row.ground_stiffness * displacement(0) - row.ground_force) -
                  row.sum_over_rows([&](std::size_t node) { return load_.alone(node, t); });
  for (std::size_t k = 0; k < 3 && contacts_.bar().side(); ++k)
    joint.rate[j] += row.side_stiffness[k] * displacement(k) + row.side_drag[k] * value(2 + k);
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

void JointForces::add(double to, double length, std::size_t order, bool extremes) {
  for (Joint& joint : joints_) {
    if (!contacts_.closed(joint.contact)) continue;
    const auto used = [order](auto& values) { return std::span(values).first(order + 1); };
    joint.account->impulse +=
        joint.direction * (joint.momentum[order] - joint.momentum[0] + length * Bernstein::mean(used(joint.rate)));
    if (!extremes) continue;
    const Bernstein inertia = Bernstein::through(used(joint.momentum)).derivative();
    for (std::size_t j = 0; j <= order; ++j)
      joint.rate[j] =
          joint.direction * (joint.rate[j] + inertia(static_cast<double>(j) / static_cast<double>(order)) / length);
    const bool pulls = contacts_[joint.contact].joint == 0;
    raise_peak(*joint.account, used(joint.rate), to, length, pulls);
  }
}

}  // namespace viscobar

#include "integration/accounts/joint_forces.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>

#include "integration/accounts/peak.hpp"
#include "integration/bernstein.hpp"

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

void JointForces::begin(std::span<const double> u, std::span<const double> w) {
  for (Joint& joint : joints_) {
    const JointRow& row = joint.row = joint_row(contacts_, joint.contact);
    joint.momentum = std::abs(row.inertia[0] * w[row.node]) + std::abs(row.inertia[1] * w[row.next]) +
                     std::abs(row.inertia[2] * w[row.beyond]) +
                     row.viscosity * (std::abs(u[row.node]) + std::abs(u[row.next])) +
                     row.ground_viscosity * std::abs(u[row.node]);
    joint.load_factor = 0.0;
    joint.row.sum_over_rows([&](std::size_t node) {
      const auto factor = load_.factor(node);
      joint.load_factor = joint.load_factor && factor ? std::optional(*joint.load_factor + *factor) : std::nullopt;
      return 0.0;
    });
  }
}

void JointForces::take_first_forces(double t, std::span<const double> u, std::span<const double> w) {
  for (Joint& joint : joints_) {
    ContactAccount& account = *joint.account;
    if (!contacts_.closed(joint.contact) || !has_dashpot(joint) || account.latest.reaction != 0.0) continue;
    const ContactNode& contact = contacts_[joint.contact];
    const double force = joint.direction * contact.law.force(contacts_.clearance(joint.contact, u), contact.of(w));
    if (contact.joint == 0 || force > 0.0)
      account.peak_reaction = std::max(account.peak_reaction, account.latest.raise(force, t));
  }
}

void JointForces::ask_for(std::vector<std::size_t>& entries) {
  const std::size_t n = contacts_.bar().size();
  for (const Joint& joint : joints_) {
    const auto& [node, next, beyond] = std::tie(joint.row.node, joint.row.next, joint.row.beyond);
    for (const std::size_t entry : {node, next, beyond, n + node, n + next, n + beyond}) position_of(entry, entries);
  }
}

void JointForces::ask_for(std::vector<LinearForm>& forms) {
  const std::size_t n = contacts_.bar().size();
  for (Joint& joint : joints_) {
    if (!contacts_.closed(joint.contact)) continue;
    const JointRow& row = joint.row;
    const std::array<std::size_t, 3> unknowns = {row.node, row.next, row.beyond};
    std::array<double, 3> origins{};
    for (std::size_t k = 0; k < 3 && !origin_.empty(); ++k) origins[k] = origin_[unknowns[k]];
    const double apart = origins[0] - origins[1];
    joint.forms = forms.size();
    if (contacts_[joint.contact].by_law) {  // the clearance, and its rate
      joint.rest = apart + contacts_[joint.contact].gap;
      forms.push_back({{row.node, row.next}, {1.0, -1.0}, 2});
      forms.push_back({{n + row.node, n + row.next}, {1.0, -1.0}, 2});
      continue;
    }
    joint.rest = row.stiffness * apart + row.ground_stiffness * origins[0] - row.ground_force;
    LinearForm momentum, rate;
    momentum.add(row.node, row.viscosity + row.ground_viscosity);
    momentum.add(row.next, -row.viscosity);
    rate.add(row.node, row.stiffness + row.ground_stiffness + row.side_stiffness[0]);
    rate.add(row.next, row.side_stiffness[1] - row.stiffness);
    rate.add(row.beyond, row.side_stiffness[2]);
    for (std::size_t k = 0; k < 3; ++k) {
      momentum.add(n + unknowns[k], row.inertia[k]);
      rate.add(n + unknowns[k], row.side_drag[k]);
      joint.rest += row.side_stiffness[k] * origins[k];
    }
    forms.push_back(momentum);
    forms.push_back(rate);
  }
}

bool JointForces::closed() const {
  return std::ranges::any_of(joints_, [this](const Joint& joint) { return contacts_.closed(joint.contact); });
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

void JointForces::add(double from, double to, std::size_t order, std::span<const PointValues> forms, bool peaks) {
  if (!(to > from) || !closed()) return;
  const bool by_history =
      std::ranges::any_of(joints_, [](const Joint& joint) { return joint.load_factor.has_value(); });
  // Time by time, since a load is evaluated once for all that ask for it at one time.
  for (std::size_t j = 0; load_.acts() && j <= order; ++j) {
    const double t = point_of(from, to, order, j);
    if (by_history) history_[j] = load_.history(t);
    for (Joint& joint : joints_)
      if (contacts_.closed(joint.contact) && !joint.load_factor)
        joint.load[j] = joint.row.sum_over_rows([&](std::size_t node) { return load_.alone(node, t); });
  }
  for (Joint& joint : joints_)
    if (contacts_.closed(joint.contact))
      add(joint, to, to - from, order, forms[joint.forms], forms[joint.forms + 1], peaks);
}

// At all points at once, those behind the order as well.
void JointForces::add(Joint& joint, double to, double length, std::size_t order, const PointValues& momentum,
                      const PointValues& rate, bool peaks) {
  const ContactNode& contact = contacts_[joint.contact];
  const auto used = [order](auto& values) { return std::span(values).first(order + 1); };
  const auto all = [](auto& values) { return Points<16>::Map(values.data()); };
  PointValues force;
  if (contact.by_law)
    for (std::size_t j = 0; j <= order; ++j) force[j] = contact.law.force(momentum[j] + joint.rest, rate[j]);
  else
    all(force) =
        all(rate) + joint.rest - joint.load_factor.value_or(1.0) * all(joint.load_factor ? history_ : joint.load);
  const double gained = contact.by_law ? 0.0 : momentum[order] - momentum[0];
  joint.account->impulse += joint.direction * (gained + length * Bernstein::mean(used(force)));
  if (!peaks) return;
  double rounding = 0.0;
  if (!contact.by_law) {
    // The first steps behind a change are so short that roundings show in the rate of the momentum: some of the
    // momentum, since a method adds its correction to what it predicts, and those of the times of its values.
    const PointValues inertia = Bernstein::slopes(used(momentum));
    const double late = std::numeric_limits<double>::epsilon() * std::abs(to) / length;
    rounding = Bernstein::steepest(order) / length *
               (8.0 * std::numeric_limits<double>::epsilon() * joint.momentum + late * all(inertia).abs().maxCoeff());
    all(force) += all(inertia) / length;
  }
  all(force) *= joint.direction;
  raise_peak(*joint.account, used(force), to, length, contact.joint == 0, rounding);
}

}  // namespace viscobar

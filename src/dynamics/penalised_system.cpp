#include "dynamics/penalised_system.hpp"

#include <limits>

#include "dynamics/contact_rows.hpp"

namespace viscobar {

namespace {

constexpr double infinite = std::numeric_limits<double>::infinity();

}  // namespace

void PenalisedSystem::force(double t, std::span<const double> u, std::span<const double> w, std::span<double> out) {
  bar_.internal_force(u, w, out);
  const std::span<const double> origin = contacts_.origin().force();
  for (std::size_t i = 0; i < origin.size(); ++i) out[i] += origin[i];
  load_.add_to(t, out);
  for (std::size_t i = 0; i < contacts_.size(); ++i) {
    if (!contacts_.closed(i) || contacts_[i].holds) continue;
    const std::size_t node = contacts_[i].unknown;
    const double force = contacts_[i].law.force(contacts_.clearance(i, u), contacts_[i].of(w));
    out[node] += force;
    if (contacts_[i].joint > 0) out[node - 1] -= force;
  }
}

void PenalisedSystem::dynamic_stiffness(double m, double c, double k, BandedMatrix& out) const {
  bar_.dynamic_stiffness(m, c, k, out);
  for (std::size_t i = 0; i < contacts_.size(); ++i) {
    if (!contacts_.closed(i)) continue;
    const std::size_t node = contacts_[i].unknown;
    const double spring =
        contacts_[i].holds ? infinite : k * contacts_[i].law.linear().stiffness + c * contacts_[i].law.linear().damping;
    if (contacts_[i].joint == 0)
      out.diagonal[node] += spring;
    else if (!contacts_[i].holds)
      out.diagonal[node] += spring, out.diagonal[node - 1] += spring, out.off_diagonal[node - 1] -= spring;
  }
  contacts_.tie_joints(out);
}

void PenalisedSystem::accelerate(std::span<double> force) {
  bool holds_mass = false;
  for (std::size_t i = 0; contacts_.collides() && i < contacts_.size(); ++i) holds_mass |= contacts_.holds_mass(i);
  if (!holds_mass) return bar_.inertia().accelerate(force);
  if (held_from_ != contacts_.revision()) {
    BandedMatrix inertia = bar_.inertia().matrix();
    for (std::size_t i = 0; i < bar_.inertia().massive_begin(); ++i) inertia.diagonal[i] = infinite;
    for (std::size_t i = bar_.inertia().massive_end(); i < size(); ++i) inertia.diagonal[i] = infinite;
    for (std::size_t i = 0; i < contacts_.size(); ++i)
      if (contacts_.holds_mass(i) && contacts_[i].joint == 0) inertia.diagonal[contacts_[i].unknown] = infinite;
    contacts_.tie_joints(inertia);
    held_factor_.factorise(inertia);
    held_from_ = contacts_.revision();
  }
  held_factor_.solve(force);
}

void PenalisedSystem::expand_acceleration(double t, std::span<const double> u, std::span<const double> w,
                                          std::span<double> nodal) {
  nodal.front() = nodal.back() = 0.0;
  acceleration(t, u, w, bar_.unknowns().part(nodal));
  if (bar_.frame().moving()) bar_.frame().add_lift(load_.lift(t, 2), nodal);
}

// Rounding error that those of the stretch and its rate make of the elements beside.
double PenalisedSystem::acceleration_rounding(const ContactNode& contact, double stretch, double rate) const {
  double sum = 0.0;
  for (std::size_t node = contact.unknown - (contact.joint > 0 ? 1 : 0); node <= contact.unknown; ++node)
    sum += (bar_.bar().modulus * stretch + bar_.bar().viscosity * rate) /
           (bar_.elements().stretch_beside(node) * bar_.bar().density * bar_.inertia().matrix().diagonal[node]);
  return sum;
}

void PenalisedSystem::settle(double t, std::span<double> u, std::span<double> w) {
  for (std::size_t i = 0; i < contacts_.size(); ++i) contacts_.set_closed(i, false);
  complete_displacement(t, u);
  complete_velocity(t, u, w);
  if (contacts_.size() == 0) return;
  const double largest = contacts_.origin().largest_displacement(u), slow = velocity_rounding(w);
  std::vector<double> accelerations;
  std::vector<unsigned char> press(contacts_.size(), 0);
  for (std::size_t i = 0; i < contacts_.size(); ++i) {
    const double sign = contacts_[i].sign, clear = contacts_.clearance(i, u),
                 rounding = contacts_[i].clearance_rounding(largest);
    if (contacts_[i].moves || clear > rounding) continue;
    const double velocity = sign * contacts_[i].of(w);
    if (clear < -rounding || velocity < -slow) {
      press[i] = 1;
    } else if (velocity <= slow) {  // they move as one
      const std::size_t node = contacts_[i].unknown;
      w[node] = contacts_[i].joint > 0 ? w[node - 1] : 0.0;
      if (accelerations.empty()) {
        accelerations.resize(size());
        acceleration(t, u, w, accelerations);
      }
      press[i] = sign * contacts_[i].of(accelerations) < -acceleration_rounding(contacts_[i], rounding, slow) ? 1 : 0;
    }
  }
  for (std::size_t i = 0; i < contacts_.size(); ++i)
    if (press[i]) contacts_.set_closed(i, true);
  complete_displacement(t, u);
  complete_velocity(t, u, w);
}

void PenalisedSystem::complete_velocity_of(std::size_t end, double t, std::span<const double> u, std::span<double> w) {
  if (contacts_.held(end)) {
    w[end] = 0.0;
    return;
  }
  const double h = bar_.elements().stretch_beside(end);
  const double modulus = bar_.bar().modulus / h, damping = bar_.bar().viscosity / h;
  const std::size_t next = neighbour(end);
  if (bar_.bar().damped()) {
    double force = modulus * (u[next] - u[end] + (contacts_.origin().at(next) - contacts_.origin().at(end))) +
                   damping * w[next] + load_.at(end, t);
    for (std::size_t i = 0; i < contacts_.size(); ++i)
      if (contacts_.closed_at(i, end))
        force -= contacts_[i].sign * contacts_[i].law.linear().stiffness * contacts_.clearance(i, u);
    w[end] = force / damping;
    return;
  }
  double rate = modulus * w[next];
  if (load_.varies()) {
    const auto [before, after] = load_.beside(t);
    const double early = load_.at(end, before), late = load_.at(end, after);
    if (before < after) rate += (late - early) / (after - before);
  }
  rate += load_.added_rate(end > 0);
  double springs = 0.0;
  for (std::size_t i = 0; i < contacts_.size(); ++i)
    if (contacts_.closed_at(i, end)) springs += contacts_[i].law.linear().stiffness;
  w[end] = rate / (modulus + springs);
}

void PenalisedSystem::complete_velocity(double t, std::span<const double> u, std::span<double> w) {
  if (bar_.inertia().massive_begin() == 1) complete_velocity_of(0, t, u, w);
  if (bar_.inertia().massive_end() + 1 == size()) complete_velocity_of(size() - 1, t, u, w);
}

void PenalisedSystem::complete_displacement_of(std::size_t end, double t, std::span<double> u) {
  if (contacts_.held(end)) {
    for (std::size_t i = 0; i < contacts_.size(); ++i)
      if (contacts_[i].unknown == end) contacts_.place(i, u);
    return;
  }
  if (bar_.bar().damped()) return;
  const double modulus = bar_.bar().modulus / bar_.elements().stretch_beside(end);
  const std::size_t next = neighbour(end);
  double force = modulus * (u[next] + (contacts_.origin().at(next) - contacts_.origin().at(end))) + load_.at(end, t),
         stiffness = modulus;
  for (std::size_t i = 0; i < contacts_.size(); ++i) {
    if (!contacts_.closed_at(i, end)) continue;
    force -= contacts_[i].sign * contacts_[i].law.linear().stiffness * contacts_.offset(i);
    stiffness += contacts_[i].law.linear().stiffness;
  }
  u[end] = force / stiffness;
}

void PenalisedSystem::complete_displacement(double t, std::span<double> u) {
  if (bar_.inertia().massive_begin() == 1) complete_displacement_of(0, t, u);
  if (bar_.inertia().massive_end() + 1 == size()) complete_displacement_of(size() - 1, t, u);
}

}  // namespace viscobar

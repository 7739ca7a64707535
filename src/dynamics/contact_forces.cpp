#include "dynamics/contact_forces.hpp"

#include <algorithm>
#include <optional>

#include "dynamics/contact_rows.hpp"

namespace viscobar {

namespace {

// The forces by which contacts hold nodes with mass, as their rows lack them: one solve serves all.
class RowForces {
 public:
  RowForces(PenalisedSystem& system, double t, std::span<const double> u, std::span<const double> w)
      : contacts_(system.contacts()), force_(system.size()) {
    system.force(t, u, w, force_);
    acceleration_ = force_;
    system.accelerate(acceleration_);
  }
  double of(std::size_t i) const {
    if (!contacts_[i].has_joint_row())
      return -force_[contacts_[i].unknown] + held_inertia_times(contacts_, i, acceleration_);
    const JointRow row = holding_row(contacts_, i);
    const double force =
        row.inertia_times(acceleration_) - row.sum_over_rows([this](std::size_t j) { return force_[j]; });
    return contacts_[i].joint > 0 ? row.sign * force : force;
  }

 private:
  const Contacts& contacts_;
  std::vector<double> force_, acceleration_;
};

}  // namespace

std::array<double, 3> reactions(PenalisedSystem& system, double t, std::span<const double> u,
                                std::span<const double> w) {
  const Contacts& contacts = system.contacts();
  const BarSystem& bar = contacts.bar();
  std::array<double, 3> sum{};
  std::optional<RowForces> rows;
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    const std::size_t node = contacts[i].unknown;
    const bool left = node == 0 && !bar.unknowns().left_fixed(),
               right = node + 1 == bar.size() && !bar.unknowns().right_fixed();
    const bool span = contacts[i].where == Where::span;
    if (!contacts.closed(i) || contacts[i].joint > 0 || !(left || right || span)) continue;
    const double sign = contacts[i].sign;
    if (contacts[i].collides && !rows) rows.emplace(system, t, u, w);
    const double clear = contacts.clearance(i, u);
    const double reaction =
        contacts[i].holds
            ? std::max(0.0, sign * (contacts[i].collides ? rows->of(i) : holding_force(system, i, t, u, w)))
        : contacts[i].law.stop() ? std::max(0.0, clear < 0.0 ? sign * contacts[i].law.force(clear, w[node]) : 0.0)
                                 : contacts[i].law.linear().reaction(-clear, -sign * w[node]);
    if (left) sum[0] += sign * reaction;
    if (right) sum[1] += sign * reaction;
    if (span) sum[2] += sign * reaction;
  }
  return sum;
}

std::vector<double> joint_forces(PenalisedSystem& system, double t, std::span<const double> u,
                                 std::span<const double> w) {
  const Contacts& contacts = system.contacts();
  std::vector<double> forces;
  std::optional<RowForces> rows;
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    if (contacts[i].joint == 0) continue;
    double& force_here = forces.emplace_back(0.0);
    if (!contacts.closed(i)) continue;
    if (!contacts[i].holds) {
      force_here = contacts[i].law.force(contacts.clearance(i, u), contacts[i].of(w));
      if (contacts[i].law.stop()) force_here = std::max(force_here, 0.0);
      continue;
    }
    if (!rows) rows.emplace(system, t, u, w);
    force_here = std::max(0.0, rows->of(i));
  }
  return forces;
}

double holding_force(PenalisedSystem& system, std::size_t i, double t, std::span<const double> u,
                     std::span<const double> w) {
  const ContactNode& contact = system.contacts()[i];
  if (contact.joint > 0 || contact.collides) return RowForces(system, t, u, w).of(i);
  return contact.sign * row_reaction(system, i, t, u, w) * (1.0 - contact.penetration_share());
}

double row_reaction(PenalisedSystem& system, std::size_t i, double t, std::span<const double> u,
                    std::span<const double> w) {
  const Contacts& contacts = system.contacts();
  const BarSystem& bar = contacts.bar();
  const std::size_t node = contacts[i].unknown, next = neighbour(node);
  const double sign = contacts[i].sign;
  const double stress = bar.bar().modulus * (sign * u[next] + contacts[i].clearance(contacts.origin().at(next))) +
                        bar.bar().viscosity * sign * w[next];
  return -stress / bar.elements().stretch_beside(node) - sign * system.load().at(node, t);
}

double resting_force(PenalisedSystem& system, std::size_t i, double t, std::span<const double> u, std::span<double> w,
                     std::span<double> force) {
  const ContactNode& contact = system.contacts()[i];
  system.complete_velocity(t, u, w);
  system.acceleration(t, u, w, force);
  return -contact.sign * contact.of(force) * contact.law.linear().stiffness / (contact.rate * contact.rate);
}

}  // namespace viscobar

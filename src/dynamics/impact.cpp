#include "dynamics/impact.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "dynamics/contact_rows.hpp"

namespace viscobar {

namespace {

// Part of an impact, of its impulse or its velocity: less of it is what the mass of a mesh passes on to the far end of
// a bar. The rounding is that of a solve.
constexpr double least_pull = 0.01, rounding = 1e-9;

// The impulse on the bar of closed contact i, which holds mass, for a change of the velocities by one of another.
double held_impulse(const Contacts& contacts, std::size_t i, std::span<const double> change, std::size_t struck) {
  return joint_row(contacts, i).sign * held_inertia_times(contacts, i, change, struck);
}

// (rho M)^{-1} d_i, closed contacts elsewhere holding their nodes.
std::vector<double> response(PenalisedSystem& system, std::size_t i) {
  const ContactNode& contact = system.contacts()[i];
  std::vector<double> answer(system.size());
  answer[contact.unknown] = contact.sign;
  if (contact.joint > 0) answer[contact.unknown - 1] = -1.0;
  system.accelerate(answer);
  return answer;
}

double velocity_of(const ContactNode& contact, std::span<const double> answer) {
  return contact.sign * contact.of(answer);
}

// The same, where those that it would pull by more than a negligible part of it are opened, and added. So are those
// that would part by such a part of its velocity: a light node is held by little.
std::vector<double> answer_of(PenalisedSystem& system, std::size_t i, double negligible,
                              std::vector<std::size_t>& released) {
  Contacts& contacts = system.contacts();
  for (;;) {
    std::vector<double> answer = response(system, i);
    double most = negligible;
    std::optional<std::size_t> pulled;
    for (std::size_t k = 0; k < contacts.size(); ++k) {
      if (k == i || !contacts.holds_mass(k)) continue;
      double pull = -held_impulse(contacts, k, answer, i);
      if (pull <= rounding) continue;
      contacts.set_closed(k, false);
      pull *= std::max(1.0, velocity_of(contacts[k], response(system, k)) / velocity_of(contacts[i], answer));
      contacts.set_closed(k, true);
      if (pull > most) most = pull, pulled = k;
    }
    if (!pulled) return answer;
    contacts.set_closed(*pulled, false);
    released.push_back(*pulled);
  }
}

}  // namespace

Collision collide(PenalisedSystem& system, std::size_t i, double t, std::span<const double> u, std::span<double> w,
                  const NegligibleSizes& negligible) {
  const Contacts& contacts = system.contacts();
  const BarSystem& bar = system.bar();
  const std::size_t node = contacts[i].unknown;
  std::vector<std::size_t> released;
  const bool of_joint = contacts[i].joint > 0;
  const double sign = contacts[i].sign, came = contacts[i].of(w);
  const std::vector<double> answer =
      answer_of(system, i, came == 0.0 ? 1.0 : std::max(least_pull, negligible.velocity / std::abs(came)), released);
  std::vector<double> acceleration(bar.size());
  const double mass = sign / contacts[i].of(answer), speed = -sign * came;
  const auto leave_with = [&](double velocity) {
    const double impulse = mass * (velocity - contacts[i].of(w));
    for (std::size_t j = 0; j < bar.size(); ++j) w[j] += sign * impulse * answer[j];
    w[node] = of_joint ? w[node - 1] + velocity : velocity;
  };
  leave_with(0.0);
  system.acceleration(t, u, w, acceleration);
  const double pressed = -sign * contacts[i].of(acceleration);
  // A closing is found late, at a depth; what the node has gained by falling there is not thrown back.
  const double gained = 2.0 * std::max(pressed, 0.0) * std::max(-contacts.clearance(i, u), 0.0);
  const double rebound = contacts[i].restitution * std::sqrt(std::max(speed * speed - gained, 0.0));
  const double height = pressed > 0.0 ? rebound * rebound / (2.0 * pressed) : 0.0;
  bool rests = true;
  if (rebound == 0.0) {
    rests = mass * pressed * bar.elements().stretch_beside(node) / bar.bar().modulus > -negligible.reaction;
  } else {
    rests = pressed > 0.0 && height <= negligible.displacement;
    if (!rests) leave_with(sign * rebound);
  }
  const double left = contacts[i].of(w), dissipated = 0.5 * mass * (speed - left) * (speed + left);
  return {rests, dissipated, mass * (left + sign * speed), height, std::move(released)};
}

void tie_joints(const Contacts& contacts, std::span<double> w) {
  BandedMatrix inertia = contacts.bar().inertia().matrix();
  contacts.tie_joints(inertia);
  if (inertia.ties.empty()) return;
  std::vector<double> momentum(w.size());
  contacts.bar().inertia().matrix().multiply(w, momentum);
  TridiagonalFactor(inertia).solve(momentum);
  std::ranges::copy(momentum, w.begin());
}

}  // namespace viscobar

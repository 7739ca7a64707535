#pragma once

#include <algorithm>
#include <cmath>
#include <span>
#include <vector>

#include "dynamics/contact_forces.hpp"
#include "integration/stepper.hpp"

namespace viscobar {

/// A contact opens at t, in the step from `begin` to `end`; `last_change` was the last change before, `load_break` the
/// last time at which the load may have jumped.
struct Opening {
  double t, begin, end, last_change, load_break;
};

/// Who makes the step.
struct OpeningMotion {
  PenalisedSystem& system;
  const Layout& layout;
  LegStepper& stepper;
};

/// Weighs the pull at the opening of contact i (see LateOpening): by the row of the node at rest, rho M a = F with what
/// holds it taken away gives it the acceleration pull / m. It opens a delay after its row asks for it, of 2 zeta /
/// omega <= 2 / omega. `state` is scratch, of the layout's size.
inline void weigh_opening(const OpeningMotion& motion, std::size_t i, const Opening& opening, std::span<double> state,
                          LateOpening& latest) {
  const auto& [system, layout, stepper] = motion;
  const auto [t, begin, end, last_change, load_break] = opening;
  const ContactNode& contact = system.contacts()[i];
  const double omega = contact.rate;
  // A jump of the load asks for the opening at once, which comes within the same delay.
  if (omega * (t - load_break) < 10.0) return;
  // At a joint that of both nodes against each other.
  const double mass = contact.law.linear().stiffness / (omega * omega);
  std::vector<double> force(layout.nodes);
  const auto pull = [&](double at) {
    stepper.interpolate(at, state);
    return -resting_force(system, i, at, layout.u(state), layout.w(state), force);
  };
  const double apart = 0.125 * (end - begin), other = t - apart >= begin ? t - apart : t + apart;
  const double now = pull(t), change = std::abs(now - pull(other)) / apart;
  const Bar& bar = system.bar().bar();
  const ErrorWeights& weights = stepper.weights();
  const double tolerated =
      (bar.modulus * weights.promised_displacement() + bar.viscosity * weights.promised_velocity()) /
      system.bar().elements().stretch_beside(contact.unknown);
  // Late by as long as the pull has grown, or by the step over the spring, it changes the node's velocity by pull *
  // lateness / m.
  const double lateness =
      std::clamp(std::abs(now) / change, std::max(end - begin, 10.0 / omega), std::max(end - begin, t - last_change));
  const double brief = mass * weights.promised_velocity() / lateness;
  const double ratio = now / (5.0 / omega * change + tolerated + brief);
  if (ratio > latest.ratio) latest = {ratio, t};
}

}  // namespace viscobar

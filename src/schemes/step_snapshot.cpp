#include "schemes/step_snapshot.hpp"

#include <algorithm>

namespace viscobar {

StepSnapshot::StepSnapshot(const BarSystem& system, TimeStep& step, const StepReactions& reactions, double dt)
    : system_(system),
      step_(step),
      reactions_(reactions),
      dt_(dt),
      u_(system.size()),
      v_(u_),
      u_nodal_(system.mesh().nodes()),
      v_nodal_(u_nodal_) {
  if (system.unknowns().left_fixed() || system.unknowns().right_fixed()) a_nodal_.resize(u_nodal_.size());
}

Snapshot StepSnapshot::between(double t, double theta, bool first) {
  const auto p = step_.p(), a = step_.acceleration(), a_before = step_.acceleration_before(), u = step_.u();
  const LaneOrder& order = step_.order();
  order.to_nodes([&](std::size_t i) { return u[i] - (1.0 - theta) * dt_ * p[i]; }, u_);
  order.to_nodes([&](std::size_t i) { return p[i] + dt_ / 2 * (theta * a[i] - (1.0 - theta) * a_before[i]); }, v_);
  return built(t, theta, first);
}

Snapshot StepSnapshot::at_start(double t, const State& start) {
  std::ranges::copy(start.u, u_.begin());
  std::ranges::copy(start.v, v_.begin());
  for (const std::size_t i : {std::size_t{0}, u_.size() - 1})
    if (system_.inertia().massless(i)) u_[i] = step_.u()[i] - dt_ * step_.p()[i], v_[i] = step_.p()[i];
  return built(t, 0.0, true);
}

Snapshot StepSnapshot::built(double t, double theta, bool first) {
  system_.unknowns().expand_displacement(u_, u_nodal_);
  system_.unknowns().expand_velocity(v_, v_nodal_);
  if (!a_nodal_.empty()) {
    // A start of first order has none of its own.
    const auto a = step_.acceleration(), before = first ? a : step_.acceleration_before();
    a_nodal_.front() = a_nodal_.back() = 0.0;
    step_.order().to_nodes([&](std::size_t i) { return theta * a[i] + (1.0 - theta) * before[i]; },
                           std::span(a_nodal_).subspan(system_.unknowns().first_node(), system_.size()));
  }
  if (system_.frame().moving()) {
    system_.frame().add_lift(system_.frame().lift(t, 0), u_nodal_);
    system_.frame().add_lift(system_.frame().lift(t, 1), v_nodal_);
    if (!a_nodal_.empty()) system_.frame().add_lift(system_.frame().lift(t, 2), a_nodal_);
  }
  Snapshot snapshot{t, u_nodal_, v_nodal_, reaction(false, t, theta), reaction(true, t, theta)};
  snapshot.reaction_span = reactions_.of_span(theta);
  joint_forces_.clear();
  for (const JointNodes& joint : system_.elements().joints()) {
    double force = joint.stiffness * (u_nodal_[joint.node - 1] - u_nodal_[joint.node]) +
                   joint.damping * (v_nodal_[joint.node - 1] - v_nodal_[joint.node]);
    for (std::size_t k = 0; k < step_.contacts().size(); ++k)
      if (step_.contacts()[k].joint == joint.number) force += reactions_.of_contact(k, theta);
    joint_forces_.push_back(force);
  }
  snapshot.joint_forces = joint_forces_;
  return snapshot;
}

// In the direction of u.
double StepSnapshot::reaction(bool right, double t, double theta) const {
  if (system_.unknowns().wall(right))
    return system_.holding_force(right, u_nodal_, v_nodal_, a_nodal_, step_.load_held(t, right));
  return reactions_.of_end(right, theta);
}

}  // namespace viscobar

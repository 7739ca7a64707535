#pragma once

#include <array>
#include <span>
#include <vector>

#include "dynamics/contact_forces.hpp"
#include "dynamics/energy_terms.hpp"
#include "dynamics/frame_energy.hpp"
#include "dynamics/penalised_system.hpp"
#include "viscobar/run/run.hpp"

namespace viscobar {

/// Turns the unknowns of a penalised run into snapshots over all mesh nodes.
class SnapshotBuilder {
 public:
  /// Without `interior`, and without reactions, snapshots have the ends alone.
  SnapshotBuilder(PenalisedSystem& system, bool reactions, bool interior = true)
      : system_(system), reactions_(reactions), interior_(interior), u_(system.bar().mesh().nodes()), v_(u_.size()) {
    if (system.bar().unknowns().left_fixed() || system.bar().unknowns().right_fixed()) a_.resize(u_.size());
  }

  /// The snapshot points to u and w, or to numbers that the next call replaces.
  Snapshot operator()(double t, std::span<const double> u, std::span<const double> w) {
    const BarSystem& bar = system_.bar();
    const std::span<const double> origin = system_.contacts().origin().values();
    if (!interior_ && !bar.frame().moving()) return ends(t, u, w);
    std::span<const double> nodal_u = u, nodal_v = w;
    if (u.size() != u_.size() || !origin.empty() || bar.frame().moving()) {
      bar.unknowns().expand_displacement(u, u_);
      for (std::size_t i = 0; i < origin.size(); ++i) u_[bar.unknowns().first_node() + i] += origin[i];
      bar.unknowns().expand_velocity(w, v_);
      if (bar.frame().moving()) {
        bar.frame().add_lift(system_.load().lift(t, 0), u_);
        bar.frame().add_lift(system_.load().lift(t, 1), v_);
      }
      nodal_u = u_, nodal_v = v_;
    }
    Snapshot snapshot{t, nodal_u, nodal_v};
    if (!reactions_) return snapshot;
    const std::array<double, 3> reactions = viscobar::reactions(system_, t, u, w);
    if (!a_.empty()) system_.expand_acceleration(t, u, w, a_);
    const auto reaction = [&](bool right) {
      if (!bar.unknowns().wall(right)) return reactions[right];
      return bar.holding_force(right, nodal_u, nodal_v, a_, system_.load().held(right, t));
    };
    snapshot.reaction_left = reaction(false);
    snapshot.reaction_right = reaction(true);
    snapshot.reaction_span = reactions[2];
    if (bar.elements().joints().empty()) return snapshot;
    joint_forces_.clear();
    const std::vector<double> of_contacts = joint_forces(system_, t, u, w);
    auto contact = of_contacts.begin();
    for (const JointNodes& joint : bar.elements().joints())
      joint_forces_.push_back(joint.contact ? *contact++
                                            : joint.stiffness * (nodal_u[joint.node - 1] - nodal_u[joint.node]) +
                                                  joint.damping * (nodal_v[joint.node - 1] - nodal_v[joint.node]));
    snapshot.joint_forces = joint_forces_;
    return snapshot;
  }

  /// Energy of a snapshot of the unknowns u; work and dissipation are those that the method knows.
  EnergyState energy(const Snapshot& of, std::span<const double> u, EnergyState known = {}) const {
    const BarEnergy bar = nodal_energy(system_.bar(), of.u, of.v);
    known.kinetic = bar.kinetic, known.elastic = bar.elastic, known.contact = contact_energy(system_.contacts(), u);
    return known;
  }

 private:
  Snapshot ends(double t, std::span<const double> u, std::span<const double> w) {
    const BarSystem& bar = system_.bar();
    for (const bool right : {false, true}) {
      const std::size_t i = bar.unknowns().end(right);
      (right ? u_.back() : u_.front()) =
          bar.unknowns().wall(right) ? *bar.unknowns().wall(right) : u[i] + system_.contacts().origin().at(i);
      (right ? v_.back() : v_.front()) = bar.unknowns().wall(right) ? 0.0 : w[i];
    }
    return {t, u_, v_};
  }

  PenalisedSystem& system_;
  bool reactions_, interior_;
  std::vector<double> u_, v_;  // where the unknowns are not the displacements of all nodes
  std::vector<double> joint_forces_;
  std::vector<double> a_;  // of all nodes, where an end is fixed
};

}  // namespace viscobar

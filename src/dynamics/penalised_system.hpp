#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "dynamics/acting_load.hpp"
#include "dynamics/contacts.hpp"
#include "viscobar/dynamics/bar_system.hpp"
#include "viscobar/dynamics/penalty_law.hpp"

namespace viscobar {

/// The semi-discrete system with penalised obstacles,
///
///     rho M u'' = M f(t) - E K u - eta K u' + sum_i s_i R_i e_i,     R_i = k_i d_i + b_i d_i' while contact i is
///     closed,
///
/// d_i = -(s_i u_i + gap_i), s_i the sign of the contact. Which contacts are closed is a state of its own, frozen while
/// an integrator makes its steps: between two changes the system is linear with constant coefficients, so a method sees
/// a smooth problem and a change is a located event [Petrov 2010, section 1].
///
/// At epsilon = 0 this is the rigid obstacle: k is infinite, a closed node is held at -s gap, its reaction is what its
/// row lacks, and it opens when that reaches zero. A node with mass has an impact as it closes, see collide() of
/// impact.hpp.
///
/// A contact at a joint of a chain pushes two nodes apart, R_i (e_b - e_a), by their clearance u_b - u_a + gap: where
/// it is rigid their rows are added and their velocities are one (docs/bars-in-line.md).
///
/// An end may have a Stop of its own instead of the penalty. A linear one is a k_i and a b_i like any; another adds its
/// force N(d_i, d_i'), and no more to the matrices. It is closed while it pushes, see push_weights().
///
/// Refers to a BarSystem that must outlive it; one object per integration (it owns the load's buffers).
class PenalisedSystem {
 public:
  /// @throws std::invalid_argument for contacts without epsilon, and for epsilon = 0 under a span obstacle, whose nodes
  /// collide together, or where a contact node has no unknown node beside it; for a stop on a node without mass, or at
  /// epsilon = 0
  PenalisedSystem(const BarSystem& bar, const Penalty& penalty) : bar_(bar), contacts_(bar, penalty), load_(bar) {}

  const BarSystem& bar() const { return bar_; }           ///< without its contacts
  std::size_t size() const { return bar_.size(); }        ///< n, number of unknown nodes
  const Contacts& contacts() const { return contacts_; }  ///< with their states
  Contacts& contacts() { return contacts_; }              ///< to be closed and opened
  const ActingLoad& load() const { return load_; }        ///< M f
  ActingLoad& load() { return load_; }                    ///< to be evaluated

  /// out = M f(t) - E K u - eta K w + reactions; w is the velocity of all unknowns.
  void force(double t, std::span<const double> u, std::span<const double> w, std::span<double> out);
  /// force <- (rho M)^{-1} force, zero at massless nodes and where a rigid contact holds a node with mass.
  void accelerate(std::span<double> force);
  /// out = u'', that of force().
  void acceleration(double t, std::span<const double> u, std::span<const double> w, std::span<double> out) {
    force(t, u, w, out);
    accelerate(out);
  }
  /// D(m,c,k) = m rho M + (c eta + k E) K + sum over closed contacts of (k k_i + c b_i) e_i e_i^T.
  void dynamic_stiffness(double m, double c, double k, BandedMatrix& out) const;
  /// The accelerations of the bar itself at all nodes, of a field in the frame. O(n)
  void expand_acceleration(double t, std::span<const double> u, std::span<const double> w, std::span<double> nodal);

  /// Sets the velocity of massless unknowns from their rows, which have no inertia: for eta > 0 the row itself, for
  /// eta = 0 its time derivative.
  void complete_velocity(double t, std::span<const double> u, std::span<double> w);
  /// Sets the displacement of massless unknowns for eta = 0, where their rows are algebraic. Nothing to do otherwise.
  void complete_displacement(double t, std::span<double> u);
  /// Opens or closes each contact as the state at the start asks for: closed when it penetrates, or touches and moves
  /// in, or touches at rest and is pressed in. Completes u and w at massless nodes on the way.
  void settle(double t, std::span<double> u, std::span<double> w);

 private:
  void complete_velocity_of(std::size_t end, double t, std::span<const double> u, std::span<double> w);
  void complete_displacement_of(std::size_t end, double t, std::span<double> u);
  double acceleration_rounding(const ContactNode& contact, double stretch, double rate) const;

  const BarSystem& bar_;
  Contacts contacts_;
  ActingLoad load_;
  TridiagonalFactor held_factor_;           // of rho M, nodes with mass that are held having an infinite one
  std::optional<std::uint64_t> held_from_;  // revision that it is of
};

}  // namespace viscobar

#pragma once

#include <array>
#include <cstddef>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "viscobar/discretisation/mass.hpp"
#include "viscobar/discretisation/mesh.hpp"
#include "viscobar/discretisation/tridiagonal.hpp"
#include "viscobar/dynamics/contact.hpp"
#include "viscobar/dynamics/elements.hpp"
#include "viscobar/dynamics/inertia.hpp"
#include "viscobar/dynamics/moving_frame.hpp"
#include "viscobar/dynamics/side_rows.hpp"
#include "viscobar/dynamics/state.hpp"
#include "viscobar/dynamics/support.hpp"
#include "viscobar/dynamics/unknowns.hpp"
#include "viscobar/scene/scene.hpp"

namespace viscobar {

class BarSystem;
struct NodalLoad;

/// So many times the difference of the loads of two systems of the same nodes.
struct LoadDifference {
  std::shared_ptr<const BarSystem> after;   ///< beyond the parameter's value
  std::shared_ptr<const BarSystem> before;  ///< below it; its load is subtracted
  double times;                             ///< factor of the difference
};

/// The P1 semi-discretisation without its contact forces,
///
///     (rho M + sum over the ends of m_e e_e e_e^T) u'' = F(t, u, u')
///         = M f(t) - E K u - eta K u' + sum over the ends of (F_e(t) - k_e u - c_e u') e_e,
///
/// less M (k u + c u') of a side that resists (see SideRows), over the nodes that are not fixed, with only the terms
/// that the scene has. M and K are of the functions of VaryingSection where the section varies. Contact constraints are
/// listed, not applied: the penalised system and the fully discrete schemes each do that in their way. rho M, with the
/// masses of the ends in it, is inertia(), E K and eta K are those of elements(), and the load is that of LoadVector.
/// Where an end is held by something that moves, u is measured in a frame() that moves with it.
class BarSystem {
 public:
  /// @throws std::invalid_argument when the mesh cannot carry the scene (no unknown node left; too few elements to
  /// redistribute the mass; redistributed mass with a span obstacle, or where supports and laws keep the mass of all
  /// contact nodes; a span obstacle with an end that moves).
  BarSystem(const Scene& scene, const Mesh& mesh, Mass mass);

  std::size_t size() const { return unknowns_.size(); }               ///< n, number of unknown nodes
  const Mesh& mesh() const { return elements_->mesh(); }              ///< that it lives on
  const Bar& bar() const { return elements_->bar(); }                 ///< its material
  Mass mass() const { return mass_; }                                 ///< how inertia is integrated
  const Unknowns& unknowns() const { return unknowns_; }              ///< which nodes they are
  const Elements& elements() const { return *elements_; }             ///< E K and eta K
  const Inertia& inertia() const { return *inertia_; }                ///< rho M
  const MovingFrame& frame() const { return *frame_; }                ///< in which u is measured
  const SideRows* side() const { return side_ ? &*side_ : nullptr; }  ///< resistance along the bar; null: none
  const NodalLoad* load() const { return load_.get(); }               ///< null: none but the frame's

  /// Nodes that an obstacle bounds, in the order left, right, span, joints.
  const std::vector<Contact>& contacts() const { return contacts_; }
  /// The law of that contact's own, of an end or a joint.
  const std::optional<Stop>& stop(const Contact& contact) const {
    static const std::optional<Stop> none;
    if (contact.joint > 0) return joint_stops_[contact.joint - 1];
    return contact.at_end() ? inputs_[contact.where == Where::right].stop : none;
  }
  /// Springs, dashpots and masses at the ends.
  const std::vector<Support>& supports() const { return supports_; }
  /// Force, spring, dashpot, mass and motion of the left and the right end.
  const std::array<EndInput, 2>& inputs() const { return inputs_; }

  /// True if there is a load: f, a force on an end, or a frame that moves.
  bool loaded() const;
  /// The same in a frame that moves with the obstacles that move, too.
  BarSystem following() const;
  /// Adds such a difference to its load.
  void add_load(LoadDifference difference);
  /// Makes the resistance along the bar that of another system of the same nodes.
  void take_side(const BarSystem& of);

  /// out = -(E K u + eta K w) and the forces of supports and side.
  void internal_force(std::span<const double> u, std::span<const double> w, std::span<double> out) const;
  /// D(m,c,k) = m rho M + (c eta + k E) K and c, k times those of supports and side, over the unknowns, written into
  /// `out` (allocates only when `out` grows).
  void dynamic_stiffness(double m, double c, double k, BandedMatrix& out) const;
  /// Energy 1/2 w.rho Q w + 1/2 E int u_x^2 + 1/2 sum k_e u_e^2 + SideRows::energy(), the contacts' apart.
  double energy(std::span<const double> u, std::span<const double> w) const;
  /// The force on the bar that holds a fixed end, in the direction of u: what its own row lacks,
  ///
  ///     (rho M a + M (k u + c v) + E K u + eta K v)_e - load,        load = (M f)_e, e = 0 or J,
  ///
  /// u, v, a being those of the bar itself, not in the frame, over all mesh nodes. Of the order of the mass.
  double holding_force(bool right, std::span<const double> u, std::span<const double> v, std::span<const double> a,
                       double load) const;
  /// True if M is not symmetric in the row of an end that may move, or between rows, so that forces do not do all that
  /// changes the energy.
  bool has_end_rows() const {
    return inertia_->matrix().unsymmetric() || (frame_->moving() && inertia_->whole().unsymmetric()) ||
           (side_ && side_->has_row_power());
  }

  /// Initial data at the unknown nodes. Velocities that enter by moments, see SteadyLoad, obey rho M w = rho int phi_i
  /// u_1 over the unknowns, held nodes being at rest, M of the bar alone. Else, on `fourth_order`, where an end is held
  /// whose initial velocity is another, the velocities are those after it has stopped: rho M w = rho M u_1 over the
  /// unknowns, the held node counted in u_1.
  State initial_state() const { return initial_; }

 private:
  void find_contacts(const Scene& scene);

  Mass mass_;
  Unknowns unknowns_;
  std::array<EndInput, 2> inputs_;  // left, right
  std::shared_ptr<const Elements> elements_;
  std::shared_ptr<const Inertia> inertia_;
  std::optional<SideRows> side_;
  std::shared_ptr<const MovingFrame> frame_;
  std::vector<Contact> contacts_;
  std::vector<std::optional<Stop>> joint_stops_;  // of all joints of a chain
  std::vector<Support> supports_;                 // of ends that have one
  State initial_;
  std::shared_ptr<const NodalLoad> load_;
};

}  // namespace viscobar

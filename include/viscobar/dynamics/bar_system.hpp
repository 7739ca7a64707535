#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "viscobar/discretisation/mass.hpp"
#include "viscobar/discretisation/mesh.hpp"
#include "viscobar/discretisation/tridiagonal.hpp"
#include "viscobar/dynamics/side_rows.hpp"
#include "viscobar/scene/scene.hpp"

namespace viscobar {

/// A load that is not finite where it is needed.
class LoadError : public std::runtime_error {
 public:
  /// With the message and the time of the fault.
  LoadError(double at, const std::string& what) : std::runtime_error(what), time(at) {}
  double time;  ///< at which it is not finite
};

class VaryingSection;
struct Piece;

/// Where a contact is: at an obstacle, or at a joint of a chain.
enum class Where { left, right, span, joint };

/// A node that an obstacle bounds: g = s u_node + gap >= 0, with the reaction s R, R >= 0. At a joint it is bounded by
/// the node before it, g = u_node - u_{node-1} + gap, on which R acts in the other direction.
struct Contact {
  std::size_t unknown = 0;    ///< index among the unknowns
  double gap = 0.0;           ///< >= 0
  double weight = 1.0;        ///< 1 at an end; trapezoidal weight of the node under a span obstacle
  Where where = Where::left;  ///< of the obstacle
  double sign = 1.0;          ///< s: 1 for an obstacle below, -1 for one above
  std::size_t joint = 0;      ///< number of its joint, from 1; 0: it is not at one

  double clearance(double u) const { return sign * u + gap; }  ///< g; at a joint of u_node - u_{node-1}
  /// u_node, or w_node, against what bounds it: at a joint less that of the node before.
  double of(std::span<const double> x) const { return joint > 0 ? x[unknown] - x[unknown - 1] : x[unknown]; }
  bool at_end() const { return where == Where::left || where == Where::right; }  ///< of the whole chain
};

/// A joint of a chain with a node on either side, a contact or a spring.
struct JointNodes {
  std::size_t number = 1;  ///< from the left, bonded ones counted
  std::size_t node = 1;    ///< mesh node to its right; the one before is to its left
  double stiffness = 0.0;  ///< of a spring
  double damping = 0.0;    ///< of a spring
  bool contact = false;    ///< true if it is one
};

/// Nodal displacement and velocity of the unknowns (n entries each; fixed nodes are not among them).
struct State {
  std::vector<double> u;  ///< displacement
  std::vector<double> v;  ///< velocity
};

/// A displacement, or its rate, that is linear in x.
struct Lift {
  double left = 0.0;   ///< at x = 0
  double right = 0.0;  ///< at x = L
  /// At that end.
  double of(bool at_right) const { return at_right ? right : left; }
  double& of(bool at_right) { return at_right ? right : left; }  ///< value at that end, to be changed
  /// At x = share L.
  double at(double share) const { return std::lerp(left, right, share); }
};

/// Jump of the frame at one time.
struct FrameJump {
  Lift displacement;  ///< of an obstacle that jumps; 0 where all moves continuously
  Lift velocity;      ///< where a motion has a kink
  /// True if the displacement jumps.
  bool displaces() const { return displacement.left != 0.0 || displacement.right != 0.0; }
};

/// The energy of a bar and of the springs and masses at its ends.
struct BarEnergy {
  double kinetic = 0.0;                               ///< of bar and masses
  double elastic = 0.0;                               ///< of bar and springs
  double total() const { return kinetic + elastic; }  ///< their sum
};

/// A spring and a dashpot between an end and the ground, and a mass on it.
struct Support {
  std::size_t unknown = 0;  ///< of the end
  double stiffness = 0.0;   ///< k
  double dashpot = 0.0;     ///< c
  double mass = 0.0;        ///< m
};

/// The P1 semi-discretisation without its contact forces,
///
///     (rho M + sum over the ends of m_e e_e e_e^T) u'' = F(t, u, u')
///         = M f(t) - E K u - eta K u' + sum over the ends of (F_e(t) - k_e u - c_e u') e_e,
///
/// less M (k u + c u') of a side that resists (see SideRows), over the nodes that are not fixed, with only the terms
/// that the scene has. M and K are of the functions of VaryingSection where the section varies. Contact constraints are
/// listed, not applied: the penalised system and the fully discrete schemes each do that in their way. Below, rho M has
/// the masses of the ends in it.
///
/// Where an end is held by something that moves, u everywhere here is measured in a frame that moves with it. The
/// displacement is u + lift(t). The lift is linear in x, across joints too, so that fixed ends stand still, and
///
///     - rho M lift'' - E K lift - eta K lift' - sum over the ends of (k_e lift + c_e lift') e_e
///
/// is part of the load. P1 holds what is linear: the semi-discrete solution is the same. An obstacle that moves has a
/// gap(t), and is nothing to the bar until that comes to it. From then on the system is the one in following(), whose
/// frame moves with the obstacle, too, so that its gap is constant.
class BarSystem {
 public:
  /// @throws std::invalid_argument when the mesh cannot carry the scene (no unknown node left; too few elements to
  /// redistribute the mass; redistributed mass with a span obstacle, or where supports and laws keep the mass of all
  /// contact nodes; a span obstacle with an end that moves).
  BarSystem(const Scene& scene, const Mesh& mesh, Mass mass);

  std::size_t size() const { return inertia_.size(); }             ///< n, number of unknown nodes
  std::size_t first_node() const { return left_fixed() ? 1 : 0; }  ///< mesh node of unknown 0
  const Mesh& mesh() const { return mesh_; }                       ///< that it lives on
  /// True if no row of K, and none of the mass away from the ends, differs from the next one.
  bool rows_alike() const { return inverse_spacing_.empty(); }
  bool is_chain() const { return chain_; }                           ///< of several bars in line
  const std::vector<JointNodes>& joints() const { return joints_; }  ///< of a chain, that are not bonded
  /// int dx / A over an element: its size, where the section does not vary. E / (int dx / A) is a spring. Of a chain E
  /// is that of bar(): int (E / E_e) dx / A, E / k at a joint that is a spring, infinite at a contact.
  double stretch(std::size_t element) const {
    if (chain_) return 1.0 / inverse_spacing_[element];
    return places_.empty() ? mesh_.element(element) : places_[element + 1] - places_[element];
  }
  /// The same of viscosity: eta / (eta / int dx / A). Of bars whose eta / E differ it is another one.
  double rate_stretch(std::size_t element) const {
    return inverse_rate_.empty() ? stretch(element) : 1.0 / inverse_rate_[element];
  }
  /// 1 / rate_stretch() of every element; empty if all are alike.
  const std::vector<double>& rate_weights() const { return inverse_rate_.empty() ? inverse_spacing_ : inverse_rate_; }
  /// h of the element of a bar that has the highest frequency, as one of bar() would have that.
  double finest() const { return chain_ ? finest_ : mesh_.smallest(); }
  double whole_stretch() const { return places_.empty() ? mesh_.length : places_.back(); }  ///< of the bar
  /// True if it is no joint's, and within the mesh.
  bool is_element_of_bar(std::size_t element) const;
  /// The element to the right of an unknown's node; the one to its left at the last node of a bar. A rigid body alone
  /// has the spring beside it, or else the nearest element of a bar.
  std::size_t element_at(std::size_t unknown) const;
  double stretch_at(std::size_t unknown) const { return stretch(element_at(unknown)); }  ///< of that
  Mass mass() const { return mass_; }                                                    ///< how inertia is integrated
  const Bar& bar() const { return bar_; }                                                ///< its material
  bool damped() const { return bar_.viscosity > 0.0; }                                   ///< eta > 0
  /// True if there is a load: f, a force on an end, or a frame that moves.
  bool loaded() const {
    return load_ || inputs_[0].force || inputs_[1].force || moving() || (difference_ && difference_->after->loaded());
  }
  /// Two systems of the same nodes.
  struct Difference {
    std::shared_ptr<const BarSystem> after;   ///< beyond the parameter's value
    std::shared_ptr<const BarSystem> before;  ///< below it; its load is subtracted
    double times;                             ///< factor of the difference
  };
  /// Adds so many times the difference of their loads to its own.
  void add_load(Difference difference) { difference_ = std::move(difference); }
  const std::optional<Difference>& added_load() const { return difference_; }  ///< by add_load()
  bool left_fixed() const { return walls_[0].has_value(); }                    ///< node 0 is no unknown
  bool right_fixed() const { return walls_[1].has_value(); }                   ///< node J is no unknown
  /// The unknown of an end that is not fixed: the first or the last.
  std::size_t end(bool right) const { return right ? size() - 1 : 0; }
  /// Which end that is.
  bool is_right(std::size_t end) const { return end > 0 || left_fixed(); }
  /// Springs, dashpots and masses at the ends.
  const std::vector<Support>& supports() const { return supports_; }
  bool has_dashpots() const;  ///< true if a support has one
  /// Resistance along the bar; null: none.
  const SideRows* side() const { return side_ ? &*side_ : nullptr; }
  /// Makes the resistance along the bar that of another system of the same nodes.
  void take_side(const BarSystem& of);
  /// The entry x of node j, or of a fixed end `left` or `right`: x_j of a field over the unknowns.
  auto at_nodes(std::span<const double> x, double left = 0.0, double right = 0.0) const {
    return [x, left, right, first = first_node()](std::size_t j) {
      return j < first ? left : j - first < x.size() ? x[j - first] : right;
    };
  }
  /// The same of row_values().
  auto at_nodes(RowValues x) const {
    return [x, first = first_node()](std::size_t j) { return j < first || j - first >= x.n ? 0.0 : x(j - first); };
  }
  /// How many row_values() of the unknowns end_power() asks for.
  std::size_t row_values() const {
    const bool ends = inertia_.skew.empty() && whole_inertia_.skew.empty() && inertia_.one_sided_at_ends();
    return ends ? 6 : size();
  }
  /// The same of displacements, fixed ends at theirs.
  auto displacement_at_nodes(std::span<const double> u) const {
    return at_nodes(u, walls_[0].value_or(0.0), walls_[1].value_or(0.0));
  }

  /// Force, spring, dashpot, mass and motion of the left and the right end.
  const std::array<EndInput, 2>& inputs() const { return inputs_; }

  /// Mass on the end that a contact is of; 0 under a span obstacle and at a joint.
  double mass_at(const Contact& contact) const {
    return contact.at_end() ? inputs_[contact.where == Where::right].mass : 0.0;
  }
  /// The law of that contact's own, of an end or a joint.
  const std::optional<Stop>& stop(const Contact& contact) const {
    static const std::optional<Stop> none;
    if (contact.joint > 0) return joint_stops_[contact.joint - 1];
    return contact.at_end() ? inputs_[contact.where == Where::right].stop : none;
  }

  /// True if the frame moves.
  bool moving() const { return moves_frame(false) || moves_frame(true); }
  /// The same in a frame that moves with the obstacles that move, too.
  BarSystem following() const;
  bool follows() const { return following_; }  ///< true if the frame moves with them
  /// True if the obstacle of a contact moves in the frame.
  bool moves(const Contact& contact) const {
    return contact.at_end() && !following_ && inputs_[contact.where == Where::right].motion.has_value();
  }
  /// gap(t) of a contact, or its derivative: constant where its obstacle does not move. @throws LoadError
  double gap(const Contact& contact, double t, int derivative = 0) const;
  /// Makes the state (u, w) at t of this system that of the same motion in another frame.
  void change_frame(const BarSystem& to, double t, std::span<double> u, std::span<double> w) const;
  /// Displacement of the frame, or its first or second derivative in time. @throws LoadError where it is not finite
  Lift lift(double t, int derivative) const;
  /// The same as lift(), from displacements a time `step` before and after t alone, as scheme (2.8) takes them: their
  /// mean, and the quotients of differences.
  Lift lift(double t, int derivative, double step) const;
  /// Its jump at t, where a motion has a kink, or the gap of an obstacle jumps; absent: none. Sides of t are as those
  /// of LoadVector::enter(). @throws LoadError where the motion of a fixed end jumps itself
  std::optional<FrameJump> kink(double t, double end) const;
  /// Applies a jump of the frame to displacements and velocities in it: u -= jump, so that the bar stays where it is,
  /// and w -= (rho M)^{-1} rho M jump, which without fixed ends leaves those of the bar.
  void pass_kink(const FrameJump& jump, std::span<double> u, std::span<double> w) const;
  /// gap(t), or a derivative of it, after less before a time at which that jumps; else 0.
  double gap_jump(const Contact& contact, double t, double end, int derivative = 0) const;
  /// A displacement of the frame, or its rate, against which a contact is measured: none at a joint, where it is the
  /// same on both sides.
  double lift_at(const Contact& contact, const Lift& lift) const {
    return contact.joint > 0 ? 0.0 : lift.at(share(contact.unknown));
  }
  /// x / L of a node or an unknown, for Lift::at(); of one bar whose section varies the share of int dx / A.
  double node_share(std::size_t j) const {
    return places_.empty() ? mesh_.node(j) / mesh_.length : places_[j] / places_.back();
  }
  double share(std::size_t unknown) const { return node_share(unknown + first_node()); }  ///< of an unknown's node
  /// Adds the lift to a field over all mesh nodes.
  void add_lift(const Lift& lift, std::span<double> nodal) const;
  /// Energy of displacements and velocities over all mesh nodes, not in the frame: the inertia of ends that are moved
  /// included.
  BarEnergy nodal_energy(std::span<const double> u, std::span<const double> v) const;
  /// Energy of u + lift and w + its rate.
  BarEnergy lifted_energy(const Lift& lift, const Lift& rate, std::span<const double> u,
                          std::span<const double> w) const;
  /// Contribution of the frame's velocity to the power that viscosity and supports take at velocities w(j) of all nodes
  /// in it. O(1) of one bar, which asks for the ends alone.
  double lift_loss(const Lift& rate, auto&& w) const {
    double sum = end_lift_loss(rate, w(std::size_t{0}), w(mesh_.elements));
    for (std::size_t e = 0; chain_ && damped() && e < mesh_.elements; ++e) {
      const double frame = rate.at(node_share(e + 1)) - rate.at(node_share(e));
      sum += bar_.viscosity * rate_weights()[e] * frame * (2.0 * (w(e + 1) - w(e)) + frame);
    }
    return sum;
  }
  /// The power of drag along the bar at velocities w(j) of all nodes.
  double side_lift_loss(const Lift& rate, auto&& w) const {
    if (!side_->has_drag()) return 0.0;
    return side_->drag_power(moved(rate, w)) - side_->drag_power(w);
  }
  /// Contribution of the frame to SideRows::row_power() of w(j) and u(j).
  double side_lift_power(const Lift& lift, const Lift& rate, auto&& w, auto&& u) const {
    return side_->row_power(moved(rate, w), moved(lift, u)) - side_->row_power(w, u);
  }

  /// Contribution of the frame to end_power(), of velocities w(j) and accelerations a(j) of all nodes in it.
  double lift_end_power(const Lift& rate, const Lift& acceleration, auto&& w, auto&& a) const {
    if (!whole_inertia_.unsymmetric()) return 0.0;
    return whole_inertia_.unsymmetric_product(moved(rate, w), moved(acceleration, a)) -
           whole_inertia_.unsymmetric_product(w, a);
  }

  /// Displacement of a fixed end, in the frame; absent: it is not fixed.
  const std::optional<double>& wall(bool right) const { return walls_[right]; }

  /// rho M; the row of a massless node is zero. Its symmetric part, rho Q, makes the kinetic energy.
  const BandedMatrix& inertia() const { return inertia_; }
  /// Nodes that an obstacle bounds, in the order left, right, span.
  const std::vector<Contact>& contacts() const { return contacts_; }

  /// Unknowns with inertia are the contiguous range [massive_begin, massive_end).
  std::size_t massive_begin() const { return massless_[0] ? 1 : 0; }
  /// One past the last unknown with inertia.
  std::size_t massive_end() const { return size() - (massless_[1] ? 1 : 0); }
  /// True if it has no inertia.
  bool massless(std::size_t unknown) const { return unknown < massive_begin() || unknown >= massive_end(); }
  /// True if any unknown has none.
  bool has_massless() const { return massless_[0] || massless_[1]; }
  /// rho M over all nodes, where something moves an end.
  const BandedMatrix& whole_inertia() const { return whole_inertia_; }

  /// The force on the bar that holds a fixed end, in the direction of u: what its own row lacks,
  ///
  ///     (rho M a + M (k u + c v) + E K u + eta K v)_e - load,        load = (M f)_e, e = 0 or J,
  ///
  /// u, v, a being those of the bar itself, not in the frame, over all mesh nodes. Of the order of the mass.
  double holding_force(bool right, std::span<const double> u, std::span<const double> v, std::span<const double> a,
                       double load) const;
  /// (rho M a)_e of a fixed end, a over all mesh nodes.
  double held_inertia(bool right, std::span<const double> a) const;

  /// out = -(E K u + eta K w) and the forces of supports and side. Stresses are differences of neighbours, so a rigid
  /// motion gives exactly zero.
  void internal_force(std::span<const double> u, std::span<const double> w, std::span<double> out) const;

  /// K_ii over the unknowns: the sum of 1/h of the elements beside, 2/h and, at an end that is not fixed, 1/h on a
  /// uniform mesh. Off the diagonal K is -1/h.
  double stiffness_diagonal(std::size_t i) const;

  /// D(m,c,k) = m rho M + (c eta + k E) K and c, k times those of supports and side, over the unknowns, written into
  /// `out` (allocates only when `out` grows).
  void dynamic_stiffness(double m, double c, double k, BandedMatrix& out) const;

  /// int u_x^2 of a displacement (fixed ends keep their displacement) and int w_x^2 of a velocity (they stand still);
  /// of a chain int (E_e / E) u_x^2 and int (eta_e / eta) w_x^2, joints included.
  double squared_strain(std::span<const double> u) const;
  double squared_strain_rate(std::span<const double> w) const;  ///< int w_x^2
  /// The same of velocities w(i), each an array of them at several times, summed up from `sum`.
  template <class Values>
  Values squared_strain_rate(auto&& w, Values sum) const {
    const double uniform = rows_alike() ? 1.0 / mesh_.spacing() : 0.0;
    std::size_t element = 0;
    const auto add = [&](const Values& difference) {
      sum += difference * difference * (inverse_spacing_.empty() ? uniform : rate_weights()[element]);
      ++element;
    };
    Values before = w(std::size_t{0});
    if (left_fixed()) add(before);
    for (std::size_t i = 1; i < size(); ++i) {
      const Values now = w(i);
      add(now - before);
      before = now;
    }
    if (right_fixed()) add(before);
    return sum;
  }

  /// Energy 1/2 w.rho Q w + 1/2 E int u_x^2 + 1/2 sum k_e u_e^2 + SideRows::energy(), the contacts' apart.
  double energy(std::span<const double> u, std::span<const double> w) const;

  /// True if M is not symmetric in the row of an end that may move, or between rows, so that forces do not do all that
  /// changes the energy.
  bool has_end_rows() const {
    return inertia_.unsymmetric() || (moving() && whole_inertia_.unsymmetric()) || (side_ && side_->has_row_power());
  }
  /// w . rho (M - Q) a, the power that rows of the mass take at velocity w and acceleration a in the frame; a has
  /// row_values().
  double end_power(std::span<const double> w, std::span<const double> a) const {
    return inertia_.unsymmetric_product([w](std::size_t i) { return w[i]; }, RowValues{a, size()});
  }

  /// Initial data at the unknown nodes. Velocities that enter by moments, see SteadyLoad, obey rho M w = rho int phi_i
  /// u_1 over the unknowns, held nodes being at rest, M of the bar alone. Else, on `fourth_order`, where an end is held
  /// whose initial velocity is another, the velocities are those after it has stopped: rho M w = rho M u_1 over the
  /// unknowns, the held node counted in u_1.
  State initial_state() const { return initial_; }

  /// Copies the unknowns into a field over all mesh nodes (J+1 entries); fixed nodes keep their displacement and stand
  /// still.
  void expand_displacement(std::span<const double> u, std::span<double> nodal) const;
  void expand_velocity(std::span<const double> w, std::span<double> nodal) const;  ///< the same of a velocity

  /// Acceleration of the massive unknowns from a force: force <- (rho M)^{-1} force, zero at massless nodes.
  void accelerate(std::span<double> force) const;

  /// k(x), or c(x), of a side for its nodes: their values there, or means over phi_i where k jumps or is too narrow for
  /// the mesh.
  std::vector<double> side_values(const SpaceFunction& f, const Places& places) const;
  /// 1 / (e . (rho M)^{-1} e) of every unknown, the mass with which a node answers to a force on it alone; 0 for
  /// massless ones.
  std::vector<double> effective_masses() const;

  /// The mass that a contact has to stop: at an end the node's effective mass, under a span obstacle the row sum of
  /// rho M, because there all nodes are stopped together (a bar that falls flat).
  double contact_mass(const Contact& contact) const;

 private:
  friend class LoadVector;

  struct SteadyVector {
    std::vector<double> weighted;  // M f
    std::array<double, 2> held{};  // the same of the ends, where they are fixed
  };
  struct SeparableVector {
    std::vector<double> weighted;  // M profile
    std::array<double, 2> held;    // the same of the ends, where they are fixed
    TimeFunction history;
    NextBreak breaks;
  };
  struct GeneralVector {
    SpaceTimeFunction density;
    NextBreak breaks;
    NextBreakAt breaks_at, breaks_in_x;
    BandedMatrix mass;  // over all nodes
  };

  bool moves_frame(bool right) const { return inputs_[right].motion && (walls_[right] || following_); }
  void take_forces();
  void enter_frame();
  // Force on an unknown by the frame's motion, where it is not in the rows of the ends alone: of a side, and of a
  // chain.
  double lift_force(const Lift& lift, const Lift& rate, std::size_t unknown) const;
  bool has_lift_force() const { return side_ || chain_; }
  double end_lift_loss(const Lift& rate, double left, double right) const;
  void add_masses();
  enum class Moments { of_load, of_velocity, of_side };
  std::vector<double> moments_of(std::string_view what, const SpaceFunction& f, const Places& places, Moments of) const;
  void take_elements(const Scene& scene);
  void take_joints(const Scene& scene);
  void start_from(std::vector<double> moments);
  void stop_fixed_ends(const Scene& scene);
  void uniform_force(std::span<const double> u, std::span<const double> w, std::span<double> out) const;
  void graded_force(std::span<const double> u, std::span<const double> w, std::span<double> out) const;
  void unlike_force(std::span<const double> u, std::span<const double> w, std::span<double> out) const;
  void unlike_forces(std::span<const double> u, std::span<const double> w, std::span<double> out, auto&& stress) const;
  double squared_differences_of(std::span<const double> x, std::array<const double*, 2> walls,
                                std::span<const double> weights) const;
  void uniform_stiffness(double m, double scale, BandedMatrix& out) const;  // scale K + m rho M
  void graded_stiffness(double m, double scale, BandedMatrix& out) const;   // scale K + m rho M
  void unlike_stiffness(double m, double c, double k, BandedMatrix& out) const;

  // A field of all nodes with the frame's motion.
  auto moved(const Lift& by, const auto& x) const {
    return [this, &by, &x](std::size_t j) { return x(j) + by.at(node_share(j)); };
  }

  Mesh mesh_;
  Mass mass_;
  Bar bar_;
  bool chain_ = false;
  double finest_ = 0.0;                               // of a chain
  std::shared_ptr<const std::vector<Piece>> pieces_;  // one, or those of a chain
  std::vector<std::optional<Stop>> joint_stops_;      // of its joints
  std::vector<JointNodes> joints_;
  std::vector<double> places_;                        // int_0^x dx / A of every node; empty without it
  std::array<std::optional<double>, 2> walls_;        // displacement of a fixed end
  std::array<bool, 2> massless_{};                    // the ends
  std::array<std::array<double, 3>, 2> held_rows_{};  // of rho M, of fixed ends, inwards
  std::vector<double> inverse_spacing_;               // 1 / stretch() of every element; empty if all are alike
  std::vector<double> inverse_rate_;                  // 1 / rate_stretch(), where that is another one
  BandedMatrix inertia_;
  TridiagonalFactor massive_factor_;  // of the massive block of rho M
  std::vector<Contact> contacts_;
  State initial_;
  std::optional<std::variant<SteadyVector, SeparableVector, GeneralVector>> load_;
  std::optional<Difference> difference_;
  std::array<EndInput, 2> inputs_;                   // left, right
  bool varying_forces_ = false;                      // true if their forces are to be added to the load
  bool following_ = false;                           // true if the frame moves with obstacles, too
  std::array<bool, 2> free_{};                       // the ends
  bool rigid_frame_ = false;                         // moves as a whole, since the other end is free
  std::vector<Support> supports_;                    // of ends that have one
  BandedMatrix whole_inertia_;                       // of all nodes, where something moves an end
  std::array<std::vector<double>, 2> lift_inertia_;  // rho M (1 - x/L) and rho M x/L, likewise
  std::optional<SideRows> side_;
  // -(M k + E K) and -(M c + eta K) times those without rho M, K of a chain, where has_lift_force().
  std::array<std::array<std::vector<double>, 2>, 2> lift_rows_;
};

/// M f(t) of a system, its forces on the ends and the frame's part included, with the buffers that its evaluation
/// needs: one per integration, so that a BarSystem can be shared. Exists only where the system is loaded().
class LoadVector {
 public:
  /// The system is loaded and outlives it. With a step the frame's part is by BarSystem::lift(t, derivative, step).
  explicit LoadVector(const BarSystem& system, double step = 0.0);

  /// M f(t) over the unknowns (n entries), valid until the next call.
  /// @throws LoadError when the load is not finite at t.
  std::span<const double> at(double t);
  /// Its entry of one unknown, of the same value: the load is evaluated beside its node only. Not counted.
  /// @throws LoadError
  double at(double t, std::size_t unknown) const;
  /// (M f)_e of a fixed end, the frame's part left out. Not counted. @throws LoadError
  double at_held(double t, bool right) const;

  /// Time of the first break of the load after t, at any node, or `end` where there is none before: until then the load
  /// is smooth. From here on at() evaluates it at the nearest time that is 64 roundings of the time away from that
  /// break and from one at t, so that the load has its one-sided limits there. Two breaks closer than that are one.
  /// `end` is the same at every call.
  double enter(double t, double end);
  /// The jumps, after less before, of M f and of its rate where the load has a break at t; false: it has none there,
  /// but for those that a density in x and t has at each node. A rate is of a time `apart`, and 0 where the load breaks
  /// again within that. `end` as in enter(). @throws LoadError
  bool jump(double t, double end, double apart, std::span<double> force, std::span<double> rate);
  /// The time at which at(t) evaluates the load.
  double inside(double t) const { return std::clamp(t, first_, last_); }

  /// Where M f(t) is a function of time alone times one vector, that vector: M f(t) = history(t) profile().
  const std::vector<double>* profile() const;
  double history(double t) const;  ///< not counted @throws LoadError

  bool steady() const { return steady_; }                   ///< the same at all times
  std::size_t evaluations() const { return evaluations_; }  ///< of the load's functions of time

 private:
  template <class Kind>
  const Kind* load_as() const {
    return system_.load_ ? std::get_if<Kind>(&*system_.load_) : nullptr;
  }
  double next_break(double after, double until);
  bool breaks_within(double from, double to) const;
  void find_distributed(double t);
  template <class Add>
  void add_moments(double t, std::size_t first, std::size_t last, Add&& add) const;  // of elements [first, last)
  double distributed(double t, std::size_t node) const;
  void add_inputs(double t);
  std::array<double, 2> end_forces(double t) const;
  Lift lift(double t, int derivative) const;

  const BarSystem& system_;  // outlives this
  double step_;
  bool steady_;
  std::vector<double> nodal_, weighted_;
  std::vector<LoadVector> difference_;  // loads of the two systems of Difference, or none
  std::optional<double> time_;
  std::vector<NextBreak> breaks_;
  NextBreakAt breaks_at_;
  std::vector<double> next_;  // breaks of the whole load, and of it at each node, where that has its own
  double first_ = -std::numeric_limits<double>::infinity(), last_ = std::numeric_limits<double>::infinity();
  std::size_t evaluations_ = 0;
};

}  // namespace viscobar

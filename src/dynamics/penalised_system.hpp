#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <utility>
#include <vector>

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
/// row lacks, and it opens when that reaches zero. A node with mass has an impact as it closes, see collide().
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
  /// A contact and its own law.
  struct OwnStop {
    std::size_t contact;
    Stop law;
  };

  /// @throws std::invalid_argument for contacts without epsilon, and for epsilon = 0 under a span obstacle, whose nodes
  /// collide together, or where a contact node has no unknown node beside it; for a stop on a node without mass, or at
  /// epsilon = 0
  PenalisedSystem(const BarSystem& bar, const Penalty& penalty);

  const BarSystem& bar() const { return bar_; }     ///< without its contacts
  std::size_t size() const { return bar_.size(); }  ///< n, number of unknown nodes

  std::size_t contact_count() const { return laws_.size(); }                  ///< N
  const Contact& contact(std::size_t i) const { return bar_.contacts()[i]; }  ///< 0 <= i < N
  const PenaltyLaw& law(std::size_t i) const { return laws_[i]; }             ///< of contact i; its linear part
  const Stop* stop(std::size_t i) const { return stop_in(stops_, i); }        ///< of contact i; null: the penalty
  const Stop* bent(std::size_t i) const { return stop_in(bent_, i); }         ///< the same, of one that is not linear
  std::span<const OwnStop> bent() const { return bent_; }                     ///< all of those
  bool closed(std::size_t i) const { return closed_[i] != 0; }                ///< true if contact i acts
  /// True if the obstacle of contact i moves in the frame: it does not act then, and is looked for by gap(t) alone.
  bool moves(std::size_t i) const { return bar_.moves(contact(i)); }
  void set_closed(std::size_t i, bool closed);  ///< from here on
  /// Changes whenever a contact does: a factor of the dynamic stiffness is valid for one revision.
  std::uint64_t revision() const { return revision_; }

  /// Measures the displacement of the node of contact i from its obstacle from here on, those of a span obstacle
  /// together, so that the penetration keeps all its digits. `u` is changed to match, unless it is empty; whatever
  /// takes a u below expects it so. A node is measured from one obstacle only, the first.
  void measure_from_obstacle(std::size_t i, std::span<double> u);
  /// True if that of contact i is.
  bool measured_from_obstacle(std::size_t i) const { return measured_[i] != 0; }
  /// Added to u it gives displacements: -s gap at nodes measured from their obstacle, 0 at others; empty
  /// where there are none.
  std::span<const double> origin() const { return origin_; }
  double origin_at(std::size_t unknown) const { return origin_.empty() ? 0.0 : origin_[unknown]; }  ///< of one node
  /// max |u_j| of the displacements
  double largest_displacement(std::span<const double> u) const;

  /// Puts the node of contact i on its obstacle.
  void place_on_obstacle(std::size_t i, std::span<double> u) const {
    const std::size_t node = contact(i).unknown;
    u[node] = contact(i).joint > 0 ? u[node - 1] - offsets_[i] : -contact(i).sign * offsets_[i];
  }
  /// s_i times the displacement of the node of contact i, plus gap_i.
  double clearance(std::size_t i, std::span<const double> u) const {
    return contact(i).sign * contact(i).of(u) + offsets_[i];
  }
  /// The same at u = 0.
  double clearance_at_origin(std::size_t i) const { return offsets_[i]; }
  /// Indicator of contact i. It is closed by the sign of p = linear part of some entries of (u, w) + offset(t),
  /// negative where it should be closed. p is a displacement:
  ///
  ///     a node with inertia or viscosity    its clearance
  ///     a contact that holds(), while it is closed
  ///                                         (h/E) times minus its reaction R, s (u_1 + (eta/E) w_1 + (h/E) (M f)_i -
  ///                                         (h/E) (rho M a)_i) + gap
  ///     a closed contact that holds two nodes of a joint
  ///                                         (h/E) times minus N, which the row of the bar's node tells
  ///     an undamped massless node           the same in either state, its clearance while it is open: its own
  ///                                         displacement shrinks by 1 + k h/E as it closes, this one passes smoothly
  std::vector<std::size_t> indicator_entries(std::size_t i) const;
  /// Weights in p of the values of those entries, in their order, and where it needs_rates() of the rates of the
  /// last two.
  struct IndicatorWeights {
    std::array<double, 8> values{};  ///< beyond the third only with a side that resists, or at a joint
    std::array<double, 6> rates{};
    bool sided = false;                           ///< true if those count
    bool alone = true;                            ///< the first value is all that it takes
    std::optional<double> offset = std::nullopt;  ///< the rest, where it is the same at all times

    double operator()(std::span<const double> entries, std::span<const double> of_entries = {}) const {
      if (alone) return values[0] * entries[0];
      double sum = values[1] * entries[1] + values[2] * entries[2];
      for (std::size_t k = 3; sided && k < entries.size(); ++k) sum += values[k] * entries[k];
      for (std::size_t k = 2; k < of_entries.size(); ++k) sum += rates[k - 2] * of_entries[k];
      return sum;
    }
  };
  IndicatorWeights indicator_weights(std::size_t i);
  /// True if p has accelerations: of a rigid contact with mass, while it is closed.
  bool indicator_needs_rates(std::size_t i) const { return collides(i) && closed(i); }
  double indicator_offset(std::size_t i, double t);  ///< the rest: gap, and load where the row asks for it
  /// A stop that may let go pushes where p < 0 and this condition is negative, too, -(a d + b d' + e) of Stop::Push, of
  /// the same entries; absent: of contact i p alone tells.
  std::optional<IndicatorWeights> push_weights(std::size_t i) const;
  /// The derivative of that condition, in the motion (u, w) that is one of this system by a parameter, by which those
  /// of the stop's numbers are `rates`; w_bar is the velocity of the bar itself.
  double push_rate(std::size_t i, double clearance, double w, double w_bar, const Stop& rates) const;
  /// Penetration of a closed contact per -p.
  double penetration_share(std::size_t i) const;
  /// omega = sqrt(k / m) of the node on its spring alone, m = rho M_ii; 0 without mass, where nothing oscillates.
  double contact_rate(std::size_t i) const { return rates_[i]; }
  /// True if a step of that length passes over the spring of contact i, omega times it > 10: formulas of order five
  /// accept one only where the oscillation is below their tolerance.
  /// Two nodes at a joint are not: the motion of both is what steps resolve.
  bool is_passed_over(std::size_t i, double length) const {
    return rates_[i] * length > 10.0 && contact(i).joint == 0 && !by_law(i);
  }
  /// True if the law alone tells the force of contact i, and no row: that of a rigid body without a bar, beside another
  /// contact; of a penalty also where no other one meets the body.
  bool by_law(std::size_t i) const { return by_law_[i] != 0; }
  /// The smaller mass of rigid bodies alone that contact i, at a joint, has; 0 where both nodes are of bars.
  double lightest_body(std::size_t i) const;
  /// True if one of the two nodes of contact i, at a joint, is the end of a bar: else both are rigid bodies.
  bool is_of_bar(std::size_t i) const;
  /// True if the node of closed contact i rests on a stiff spring, kappa > 1e4, after so long without a contact change:
  /// the dashpot has left of the oscillation less than exp(-40), which is below rounding, zeta omega = b / (2 m).
  bool has_come_to_rest(std::size_t i, double time) const;
  bool rigid() const { return rigid_; }  ///< epsilon = 0
  /// True if contact i is rigid on a node with mass.
  bool collides(std::size_t i) const { return rigid_ && !massless(contact(i).unknown); }
  bool collides() const { return collides_; }  ///< true if any contact collides

  /// Result of an impact.
  struct Collision {
    bool rests;                         ///< the contact stays closed
    double dissipated;                  ///< of the energy
    double end_inertia;                 ///< energy that the end rows of the mass took
    double impulse;                     ///< P, on the bar
    double height;                      ///< H of a rebound onto which the bar is pressed, else 0
    std::vector<std::size_t> released;  ///< closed contacts that the impact would have pulled, open now
  };
  /// Negligible sizes of a displacement, of (h/E) times a reaction, and of a velocity.
  struct Negligible {
    double displacement;  ///< of the node, the height of a bounce
    double reaction;      ///< times h/E, a displacement
    double velocity;      ///< with which contacts that an impact pulls would part
  };
  /// The impact of open contact i, which collides(), its node being at the obstacle with velocity s w_i <= 0, here for
  /// s = 1:
  ///
  ///     rho M (w+ - w) = P e_i,    w+_i = -e w_i,    P = -(1 + e) w_i / (e_i . (rho M)^{-1} e_i),
  ///
  /// closed contacts elsewhere holding their nodes as far as they push. A node that is already below the surface by d
  /// leaves with e (w_i^2 - 2 A d)^(1/2), where A is the acceleration by which the bar presses it on. The impact takes
  /// (1 - e^2) m w_i^2 / 2, where m is the mass in that quotient. With e = 0 the node stays where the bar presses it
  /// on, a_i < 0 at w+. With e > 0 it leaves, unless the bounces to come are negligible: it would rise by H = (e w_i)^2
  /// / (2 A) and rest after 2 e |w_i| / (A (1 - e)). It rests at once then, w+_i = 0, and nothing is displaced by more
  /// than H: but for the node's momentum m u_i', whose integral over time is m H at most, the bar has the same impulse.
  Collision collide(std::size_t i, double t, std::span<const double> u, std::span<double> w,
                    const Negligible& negligible);
  /// True if contact i, while closed, holds its node at -s gap: a rigid one does, and a spring on a massless node that
  /// gives way by less than the rounding of the strain, kappa = k h / E > (1 + eta / (h sqrt(E rho))) / rounding.
  bool holds(std::size_t i) const { return holds_[i] != 0; }
  bool held(std::size_t unknown) const;  ///< by a closed contact that holds(), against the ground
  /// True if contact i is closed on a node without mass and a stiff spring, kappa > 1e4, whose penetration is at once
  /// what the strain beside it makes of it.
  bool relaxes(std::size_t i) const;
  /// On a damped node without mass the row of contact i has the sign of its reaction, too: on the surface the node
  /// moves at s w_i = -(h/eta) R, R being row_reaction(). It leaves where R < 0 and stays where R > 0. k times a depth
  /// that is less than a step may be wrong by has no sign of its own.
  bool changes_by_row(std::size_t i) const { return massless(contact(i).unknown) && bar_.damped(); }
  /// k h / E
  double relative_stiffness(std::size_t i) const;
  /// Rounding error of a clearance, for displacements up to `largest`.
  double clearance_rounding(std::size_t i, double largest) const;
  /// Rounding error of the indicator p: as clearance_rounding(); of a closed contact measured from its
  /// obstacle, smaller by 1 / (1 + kappa).
  double indicator_rounding(std::size_t i, double largest) const;

  /// force <- (rho M)^{-1} force, zero at massless nodes and where a rigid contact holds a node with mass.
  void accelerate(std::span<double> force);

  /// out = M f(t) - E K u - eta K w + reactions; w is the velocity of all unknowns.
  void force(double t, std::span<const double> u, std::span<const double> w, std::span<double> out);

  /// D(m,c,k) = m rho M + (c eta + k E) K + sum over closed contacts of (k k_i + c b_i) e_i e_i^T.
  void dynamic_stiffness(double m, double c, double k, BandedMatrix& out) const;

  /// To be called where a leg begins: the time to which the load stays smooth, `end` at most (see LoadVector::enter).
  double begin_leg(double t, double end) { return load_ ? load_->enter(t, end) : end; }

  /// Sets the velocity of massless unknowns from their rows, which have no inertia: for eta > 0 the row itself, for
  /// eta = 0 its time derivative.
  void complete_velocity(double t, std::span<const double> u, std::span<double> w);

  /// Sets the displacement of massless unknowns for eta = 0, where their rows are algebraic. Nothing to do otherwise.
  void complete_displacement(double t, std::span<double> u);

  /// The row of an unknown whose inertia counts for little, of first order, n being its one or two neighbours:
  ///
  ///     u_i' + rate u_i = sum_n (u_share u_n + w_share u_n' - a_share u_n'') + load_share (M f)_i + constant.
  struct RelaxingRow {
    /// Contribution of the neighbour n.
    struct Neighbour {
      std::size_t unknown;  ///< n
      double u_share;       ///< of its displacement, per time
      double w_share;       ///< of its velocity
      double a_share;       ///< of its acceleration, a time: off the diagonal of the mass
    };
    std::size_t unknown;                  ///< i
    double rate;                          ///< per time
    double load_share;                    ///< of the load, velocity per force
    double constant;                      ///< of springs and fixed ends, a velocity
    double inertia;                       ///< m over the stiffness, a time squared: what u_i'' adds is -rate times it
    std::array<Neighbour, 2> neighbours;  ///< the first `count`
    std::size_t count;                    ///< 1 or 2
  };
  /// Those of the massless unknowns that are not held, as long as no contact changes; none for eta = 0.
  std::vector<RelaxingRow> relaxing_rows() const;
  /// The row of the node of contact i, with mass, closed on a spring that a step passes over. Without damping it
  /// follows its neighbours at 1000 omega.
  RelaxingRow resting_row(std::size_t i) const;
  /// (M f)_i at t, 0 without a load.
  double load(std::size_t unknown, double t) {
    return (load_ ? load_->at(t)[unknown] : 0.0) + (added_.empty() ? 0.0 : added_[unknown]);
  }
  /// From here on `force` acts beside the load: an entry for each unknown, which outlives this. `rates` are those of
  /// its first and last entry, where massless nodes without viscosity follow it.
  void add_force(std::span<const double> force, std::array<double, 2> rates) { added_ = force, added_rates_ = rates; }
  /// (M f)_e of a fixed end.
  double load_held(bool right, double t) const { return load_ ? load_->at_held(t, right) : 0.0; }
  /// The accelerations of the bar itself at all nodes, of a field in the frame. O(n)
  void expand_acceleration(double t, std::span<const double> u, std::span<const double> w, std::span<double> nodal);
  /// The same, evaluated at that node alone.
  double load_alone(std::size_t unknown, double t) const { return load_ ? load_->at(t, unknown) : 0.0; }
  /// Displacement of the frame (see BarSystem::lift), on the same side of a break as the load.
  Lift lift(double t, int derivative) const { return bar_.moving() ? bar_.lift(load_->inside(t), derivative) : Lift{}; }
  /// Two times of the leg, 1e-4 element transit times or less to either side of t: the difference of the loads there
  /// gives the load's rate at t. The same time twice in a leg that is too short to have a rate.
  std::pair<double, double> beside(double t) const;
  /// Adds (M f)' by that difference, and by no more: nothing where there is no rate.
  void add_load_rate(double t, std::span<double> rate);
  /// Where the load has a break at t, the jumps of M f and of its rate (see LoadVector::jump).
  bool load_jump(double t, double end, std::span<double> force, std::span<double> rate);

  /// Opens or closes each contact as the state at the start asks for: closed when it penetrates, or touches and moves
  /// in, or touches at rest and is pressed in. Completes u and w at massless nodes on the way.
  void settle(double t, std::span<double> u, std::span<double> w);

  /// Reactions of the contacts at the left and the right end, and of those of a span obstacle, in the direction of u,
  /// the sum of s_i R_i.
  std::array<double, 3> reactions(double t, std::span<const double> u, std::span<const double> w);
  /// N of each contact of a joint, of closed ones, in the order of the contacts; 0 of the others.
  std::vector<double> joint_forces(double t, std::span<const double> u, std::span<const double> w);

  /// Reaction of a closed contact that holds(), as its row gives it, of either sign; at a joint N.
  double holding_force(std::size_t i, double t, std::span<const double> u, std::span<const double> w);
  /// The remainder of the row of contact i, whose node has no mass, on its obstacle: it holds the node there, R >= 0
  /// where it pushes. R = -(E (u_1 + s gap) + eta w_1) s / h - s (M f)_i, less k gap of a spring at that end.
  double row_reaction(std::size_t i, double t, std::span<const double> u, std::span<const double> w);

  /// Force of closed contact i, which does not hold(), in the direction of u, at a clearance and velocity of its node.
  double contact_force(std::size_t i, double clearance, double w) const {
    const double linear = -(contact(i).sign * laws_[i].stiffness * clearance + laws_[i].damping * w);
    return bent_.empty() ? linear : linear + bent_force(i, clearance, w);
  }
  /// dN/dd and dN/dd' of contact i there.
  PenaltyLaw tangent(std::size_t i, double clearance, double w) const;
  /// Makes contact i, not linear in the bar, one of that linear law here: of a derivative, which has its tangent.
  void linearise(std::size_t i, const PenaltyLaw& tangent);

  /// The row beside contact i, at a joint, without the contact itself: that of the end of a bar, or of a rigid body
  /// that no other contact meets,
  ///
  ///     sign N = inertia . (a_node, a_next, a_beyond) + k (u_node - u_next) + c (w_node - w_next)
  ///              + k_0 u_node + c_0 w_node - f_0 + (M (k u + c w))_node - (M f)_node,
  ///
  /// with k_0, c_0 and f_0 of a spring to the ground, and M (k u + c w) of resistance along the bar.
  struct JointRow {
    std::size_t node, next, beyond;           ///< unknowns, from the joint inwards
    double sign;                              ///< 1 where the row is to the right of the joint, -1 to the left
    double scale;                             ///< E / h, by which the indicator counts N
    double stiffness = 0.0, viscosity = 0.0;  ///< k, c
    double ground_stiffness = 0.0, ground_viscosity = 0.0, ground_force = 0.0;  ///< k_0, c_0, f_0
    std::array<double, 3> inertia{}, side_stiffness{}, side_drag{};             ///< of the three nodes
    /// The row of rho M times v: of velocities the row's momentum, of accelerations its force of inertia.
    double inertia_times(std::span<const double> v) const {
      return inertia[0] * v[node] + inertia[1] * v[next] + inertia[2] * v[beyond];
    }
  };
  /// Where contact i is by_law() it has b and a for nodes, and zeros.
  JointRow joint_row(std::size_t i) const;

  /// Energy of the springs of closed contacts.
  double contact_energy(std::span<const double> u) const;
  /// Kinetic, elastic and contact energy, in the frame of the system.
  double energy(std::span<const double> u, std::span<const double> w) const;
  /// Contribution of a frame that moves, 0 otherwise. The work of what moves it is the increase of that, the power of
  /// the load, and frame_loss(): the balance of energy is then the frame's.
  double frame_energy(double t, std::span<const double> u, std::span<const double> w) const;
  /// Makes the state that of another frame, by BarSystem::change_frame(); returns the increase of frame_energy().
  double change_frame(const BarSystem& to, double t, std::span<double> u, std::span<double> w) const;
  /// eta w.K w + sum c_e w_e^2 + sum b_i w_i^2, and that of drag along the bar.
  double dissipated_power(std::span<const double> w) const {
    return dissipated_power([w](std::size_t i) { return w[i]; }, bar_.damped() ? bar_.squared_strain_rate(w) : 0.0);
  }
  /// The same of velocities w(i), numbers or arrays of them at several times, with w.K w.
  template <class Values>
  Values dissipated_power(auto&& w, const Values& squared_strain_rate) const {
    Values power = bar_.bar().viscosity * squared_strain_rate;
    for (const Support& support : bar_.supports()) power += support.dashpot * w(support.unknown) * w(support.unknown);
    for (std::size_t i = 0; dashpots_ && i < laws_.size(); ++i) {
      if (!closed(i)) continue;
      const std::size_t node = contact(i).unknown;
      if (contact(i).joint == 0) {
        power += laws_[i].damping * w(node) * w(node);
      } else {
        const Values apart = w(node) - w(node - 1);
        power += laws_[i].damping * apart * apart;
      }
    }
    if (const SideRows* side = bar_.side(); side && side->has_drag()) {
      const Values still = power - power;
      power += side->drag_power([&, first = bar_.first_node()](std::size_t j) -> Values {
        return j < first || j - first >= size() ? still : w(j - first);
      });
    }
    return power;
  }
  /// The same of closed stops that are not linear.
  double stop_loss(std::span<const double> u, std::span<const double> w) const {
    double power = 0.0;
    for (const auto& [i, law] : bent_) {
      const double depth = -clearance(i, u), rate = -contact(i).sign * contact(i).of(w);
      if (closed(i)) power += (law.force(depth, rate) - law.force(depth, 0.0)) * rate;
    }
    return power;
  }
  /// Energy stored in contact i, a stop, while it is closed.
  double stop_energy(std::size_t i, std::span<const double> u) const { return stop(i)->energy(-clearance(i, u)); }
  bool has_stops() const { return !stops_.empty(); }  ///< with a law of their own
  /// Gives both nodes of each rigid contact of a joint that is closed one velocity again, after a kink of the frame,
  /// which changes those of the nodes near an end; momentum is kept.
  void tie_joints(std::span<double> w) const;
  /// Contribution of a frame that moves (see BarSystem::lift_loss).
  double frame_loss(double t, std::span<const double> w) const {
    if (!bar_.moving()) return 0.0;
    const Lift rate = bar_.lift(t, 1);
    const double sum = bar_.lift_loss(rate, bar_.at_nodes(w));
    return bar_.side() ? sum + bar_.side_lift_loss(rate, bar_.at_nodes(w)) : sum;
  }
  /// w.M f(t)
  double load_power(double t, std::span<const double> w);
  std::span<const double> nodal_load(double t) { return load_->at(t); }  ///< M f(t), where loaded()
  /// Power of the end rows of the mass (see BarSystem::end_power) at the acceleration a, of which it has row_values(),
  /// with that of SideRows, and what of it is the frame's, which what moves the frame does.
  /// Where a is that of F(t, u, w), it has E/h times what u is wrong by, which does no work but adds up in a long
  /// flight: the derivative of the same w has not.
  struct EndPower {
    double all, of_frame;
  };
  EndPower end_power(double t, std::span<const double> u, std::span<const double> w, std::span<const double> a) const;
  bool dissipates() const { return bar_.damped() || dashpots_; }  ///< by viscosity or a contact's dashpot
  /// By those, a stop's, a support's dashpot, drag along the bar, or impacts.
  bool takes_energy() const {
    return dissipates() || collides_ || bar_.has_dashpots() || stops_take_ || (bar_.side() && bar_.side()->has_drag());
  }
  bool loaded() const { return load_.has_value(); }               ///< f is not zero
  bool load_varies() const { return load_ && !load_->steady(); }  ///< f depends on time

  /// Evaluations of the load's functions of time so far.
  std::size_t load_evaluations() const { return load_ ? load_->evaluations() : 0; }

 private:
  bool massless(std::size_t unknown) const { return bar_.massless(unknown); }
  bool is_met_elsewhere(std::size_t i, std::size_t unknown) const;
  void add_joint_weights(std::size_t i, IndicatorWeights& weights) const;
  double joint_force(std::size_t i, std::span<const double> force, std::span<const double> a) const;
  double held_impulse(std::size_t i, std::span<const double> change) const;
  std::vector<double> answer_of(std::size_t i, double negligible, std::vector<std::size_t>& released);
  bool has_one_sided() const { return !bar_.inertia().one_sided.empty(); }
  static std::size_t neighbour(std::size_t end) { return end == 0 ? 1 : end - 1; }
  std::array<double, 2> inertia_beside(std::size_t end) const;
  double held_inertia_times(std::size_t end, std::span<const double> v) const;
  bool gives_way_by_rounding(std::size_t i) const;
  static const Stop* stop_in(std::span<const OwnStop> stops, std::size_t i) {
    for (const OwnStop& one : stops)
      if (one.contact == i) return &one.law;
    return nullptr;
  }
  double bent_force(std::size_t i, double clearance, double w) const;
  double push_time() const;
  void accelerate_held(double t, std::span<const double> u, std::span<const double> w);
  void accelerate_held();
  double held_force(std::size_t i) const;
  void complete_velocity_of(std::size_t end, double t, std::span<const double> u, std::span<double> w);
  void complete_displacement_of(std::size_t end, double t, std::span<double> u);
  // True if the node of contact i follows its neighbour at once.
  bool follows(std::size_t i) const { return massless(contact(i).unknown) && !bar_.damped(); }
  void find_offsets();
  std::vector<double> displacement(std::span<const double> u) const;
  double frame_energy(const BarSystem& bar, double t, std::span<const double> u, std::span<const double> w) const;
  // True if contact i is a closed one of that node.
  bool closed_at(std::size_t i, std::size_t unknown) const {
    return closed(i) && contact(i).unknown == unknown && contact(i).joint == 0;
  }

  const BarSystem& bar_;
  std::vector<PenaltyLaw> laws_;
  std::vector<OwnStop> stops_, bent_;  // the latter those of them that are not linear
  std::vector<double> rates_;          // omega of each contact
  std::vector<unsigned char> closed_, measured_, holds_, by_law_;
  std::vector<double> acceleration_;                     // scratch
  std::array<double, 2> lacking_{};                      // -F at the ends, where that is the force that accelerates
  std::vector<double> origin_, origin_force_, offsets_;  // the force -E K origin; clearance minus u of each contact
  TridiagonalFactor held_factor_;           // of rho M, nodes with mass that are held having an infinite one
  std::optional<std::uint64_t> held_from_;  // revision that it is of
  double restitution_;
  bool dashpots_ = false, rigid_ = false, collides_ = false, stops_take_ = false;
  std::uint64_t revision_ = 0;
  std::optional<LoadVector> load_;
  std::span<const double> added_;
  std::array<double, 2> added_rates_{};
};

}  // namespace viscobar

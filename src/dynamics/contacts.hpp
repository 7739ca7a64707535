#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <type_traits>
#include <utility>
#include <vector>

#include "dynamics/contact_law.hpp"
#include "viscobar/dynamics/bar_system.hpp"

namespace viscobar {

/// Added to u it gives displacements: -s gap at nodes that are measured from their obstacle, so that a penetration
/// keeps all its digits, and 0 at others.
class Origin {
 public:
  std::span<const double> values() const { return values_; }  ///< empty where all are 0
  std::span<const double> force() const { return force_; }    ///< -E K times them; empty, too
  double at(std::size_t unknown) const { return values_.empty() ? 0.0 : values_[unknown]; }  ///< of one node
  /// Moves it, n values.
  void move(const BarSystem& bar, std::vector<double> values) {
    values_ = std::move(values);
    const std::vector<double> nothing(values_.size(), 0.0);
    std::vector<double> without(values_.size());
    force_.resize(values_.size());
    bar.internal_force(values_, nothing, force_);
    bar.internal_force(nothing, nothing, without);
    for (std::size_t i = 0; i < force_.size(); ++i) force_[i] -= without[i];
  }
  /// The displacements.
  std::vector<double> displacement(std::span<const double> u) const {
    std::vector<double> displacement(u.begin(), u.end());
    for (std::size_t i = 0; i < values_.size(); ++i) displacement[i] += values_[i];
    return displacement;
  }
  /// max |u_j| of them
  double largest_displacement(std::span<const double> u) const {
    const Eigen::Map<const Eigen::ArrayXd> relative(u.data(), static_cast<Eigen::Index>(u.size()));
    if (values_.empty()) return relative.abs().maxCoeff();
    return (relative + Eigen::Map<const Eigen::ArrayXd>(values_.data(), relative.size())).abs().maxCoeff();
  }

 private:
  std::vector<double> values_, force_;
};

/// A contact, its law, and how its node follows: all that is the same whether it is closed or open.
struct ContactNode : Contact {
  ContactLaw law;
  double restitution = 1.0;         ///< e of an impact
  double relative_stiffness = 0.0;  ///< kappa = k h / E
  /// omega = sqrt(k / m) of the node on its spring alone, m = rho M_ii; 0 without mass, where nothing oscillates.
  double rate = 0.0;
  /// Its obstacle moves in the frame: it does not act then, and is looked for by gap(t) alone.
  bool moves = false;
  bool rigid = false;     ///< epsilon = 0
  bool massless = false;  ///< its node has no inertia
  bool follows = false;   ///< the node is where its neighbour puts it at once: without mass or viscosity
  bool collides = false;  ///< rigid, on a node with mass
  bool of_bar = false;    ///< one of the two nodes of a joint is the end of a bar: else both are rigid bodies
  bool has_body = false;  ///< one of them is such a body
  /// The row that tells the force is that of the node to the right of the contact, else to its left.
  bool to_right = false;
  /// The contact on the other side of a rigid body whose row that is: the row has its force, too.
  std::optional<std::size_t> beyond{};
  /// The law alone tells the force, and no row: that of a penalty on a rigid body without a bar, of an obstacle where
  /// another contact meets the body.
  bool by_law = false;
  /// While closed it holds its node at -s gap: a rigid one does, and a spring on a massless node that gives way by less
  /// than the rounding of the strain, kappa > (1 + eta / (h sqrt(E rho))) / rounding.
  bool holds = false;
  /// On a damped node without mass the row has the sign of the reaction, too: on the surface the node moves at s w_i =
  /// -(h/eta) R, R being row_reaction(). It leaves where R < 0 and stays where R > 0. k times a depth that is less than
  /// a step may be wrong by has no sign of its own.
  bool changes_by_row = false;

  static constexpr double stiff = 1e4;  ///< kappa from which a spring is stiff

  /// True if the rows of bodies and of bars beside them tell the force, as at joints: else that of the end of a bar.
  bool has_joint_row() const { return joint > 0 || (beyond && !by_law); }
  /// True if a step of that length passes over the spring, omega times it > 10: formulas of order five accept one only
  /// where the oscillation is below their tolerance. Two nodes at a joint are not: the motion of both is what steps
  /// resolve.
  bool is_passed_over(double length) const { return rate * length > 10.0 && joint == 0 && !by_law; }
  /// True if the closed node rests on a stiff spring, after so long without a contact change: the dashpot has left of
  /// the oscillation less than exp(-40), which is below rounding, zeta omega = b / (2 m).
  bool has_come_to_rest(double time) const {
    const auto& [stiffness, damping] = law.linear();
    return !by_law && relative_stiffness > stiff && rate * rate * damping * time > 80.0 * stiffness;
  }
  /// True if the closed node is without mass and on a stiff spring, so that its penetration is at once what the strain
  /// beside it makes of it.
  bool relaxes() const { return massless && !follows && !holds && relative_stiffness > stiff; }
  /// Penetration while closed, per -p of its indicator.
  double penetration_share() const { return rigid ? 0.0 : follows || holds ? 1.0 / (1.0 + relative_stiffness) : 1.0; }
  /// Rounding error of a clearance, for displacements up to `largest`.
  double clearance_rounding(double largest) const {
    return 32.0 * std::numeric_limits<double>::epsilon() * (gap + largest);
  }
};

/// Rounding error of the difference of two of these velocities. Those of bars that move as one differ by it.
inline double velocity_rounding(std::span<const double> w) {
  double largest = 0.0;
  for (const double one : w) largest = std::max(largest, std::abs(one));
  return 32.0 * std::numeric_limits<double>::epsilon() * largest;
}

/// The contacts of a system, which of them are closed, and where their nodes are measured from. `u` is measured from
/// origin() throughout.
class Contacts {
 public:
  /// The bar outlives it. @throws std::invalid_argument as PenalisedSystem
  Contacts(const BarSystem& bar, const Penalty& penalty);

  const BarSystem& bar() const { return bar_; }                             ///< without them
  std::size_t size() const { return nodes_.size(); }                        ///< N
  const ContactNode& operator[](std::size_t i) const { return nodes_[i]; }  ///< 0 <= i < N
  bool collides() const { return collides_; }                               ///< true if any does
  bool bend() const { return bend_; }                                       ///< true if a law is not linear
  bool has_stops() const { return stops_; }                                 ///< with a law of their own
  bool has_dashpots() const { return dashpots_; }                           ///< true if a linear law has one
  bool take_energy() const { return collides_ || stops_take_; }             ///< by impacts, or a stop's damper

  bool closed(std::size_t i) const { return closed_[i] != 0; }  ///< true if contact i acts
  /// True if contact i is a closed one of that node, against the ground.
  bool closed_at(std::size_t i, std::size_t unknown) const {
    return closed(i) && nodes_[i].unknown == unknown && nodes_[i].joint == 0;
  }
  bool holds_mass(std::size_t i) const { return nodes_[i].collides && closed(i); }  ///< closed, and collides
  /// By a closed contact that holds, against the ground, or by one of a joint to a node that is.
  bool held(std::size_t unknown) const;
  void set_closed(std::size_t i, bool closed) { closed_[i] = closed ? 1 : 0, ++revision_; }  ///< from here on
  /// Changes whenever a contact does: a factor of the dynamic stiffness is valid for one revision.
  std::uint64_t revision() const { return revision_; }
  /// Makes the law of contact i, not linear in the bar, that linear one: of a derivative, which has its tangent.
  void linearise(std::size_t i, const PenaltyLaw& tangent) { nodes_[i].law.linearise(tangent); }
  /// Ties the rows of both nodes of each rigid contact of a joint that is closed. Where one is held, its entry of the
  /// diagonal being infinite, so is the other.
  void tie_joints(BandedMatrix& matrix) const;

  const Origin& origin() const { return origin_; }
  /// Measures the displacement of the node of contact i from its obstacle from here on, those of a span obstacle
  /// together. `u` is changed to match, unless it is empty. A node is measured from one obstacle only, the first.
  void measure(std::size_t i, std::span<double> u);
  bool measured(std::size_t i) const { return measured_[i] != 0; }  ///< true if that of contact i is
  /// s_i times the displacement of the node of contact i, plus gap_i.
  double clearance(std::size_t i, std::span<const double> u) const {
    return nodes_[i].sign * nodes_[i].of(u) + offsets_[i];
  }
  double offset(std::size_t i) const { return offsets_[i]; }                     ///< the same at u = 0
  double surface(std::size_t i) const { return -nodes_[i].sign * offsets_[i]; }  ///< u at which the clearance is 0
  /// Puts the node of contact i on its obstacle.
  void place(std::size_t i, std::span<double> u) const {
    const std::size_t node = nodes_[i].unknown;
    u[node] = nodes_[i].joint > 0 ? u[node - 1] + surface(i) : surface(i);
  }

  /// Content of a checkpoint: which are closed, and which have been measured from, as the archived state is.
  static void members(auto& contacts, auto&& each) {
    std::vector<unsigned char> measured = contacts.measured_;
    each(std::span(contacts.closed_), std::span(measured));
    if constexpr (!std::is_const_v<std::remove_reference_t<decltype(contacts)>>) {
      ++contacts.revision_;
      for (std::size_t i = 0; i < measured.size(); ++i)
        if (measured[i]) contacts.measure(i, {});
    }
  }

 private:
  void add(const Contact& contact, const Penalty& penalty);
  void find_row(ContactNode& node) const;
  double rate_of(const ContactNode& node) const;
  void find_offsets();

  const BarSystem& bar_;
  std::vector<ContactNode> nodes_;
  std::vector<unsigned char> closed_, measured_;
  Origin origin_;
  std::vector<double> offsets_;  // clearance minus u of each contact
  bool dashpots_ = false, collides_ = false, stops_take_ = false, stops_ = false, bend_ = false;
  std::uint64_t revision_ = 0;
};

}  // namespace viscobar

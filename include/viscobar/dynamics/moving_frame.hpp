#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "viscobar/dynamics/contact.hpp"
#include "viscobar/dynamics/elements.hpp"
#include "viscobar/dynamics/inertia.hpp"
#include "viscobar/dynamics/unknowns.hpp"
#include "viscobar/scene/scene.hpp"

namespace viscobar {

class SideRows;

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

/// The frame in which the unknowns of a bar are measured: it moves with what holds an end, the displacement is u +
/// lift(t). The lift is linear in x, across joints too, so that fixed ends stand still, and
///
///     - rho M lift'' - E K lift - eta K lift' - M (k lift + c lift') - sum over the ends of (k_e lift + c_e lift') e_e
///
/// is part of the load. P1 holds what is linear: the semi-discrete solution is the same. An obstacle that moves has a
/// gap(t), and is nothing to the bar until that comes to it. From then on the frame is following() it, too, so that its
/// gap is constant.
class MovingFrame {
 public:
  /// @param scene with what moves its ends
  /// @param unknowns nodes that move
  /// @param elements their stiffness
  /// @param inertia their mass
  /// @param side resistance along the bar; null: none
  MovingFrame(const Scene& scene, const Unknowns& unknowns, std::shared_ptr<const Elements> elements,
              std::shared_ptr<const Inertia> inertia, const SideRows* side);

  /// True if it moves.
  bool moving() const { return moves(false) || moves(true); }
  /// True if it moves with what holds that end, or with an obstacle there.
  bool moves(bool right) const { return motions_[right] && (unknowns_.wall(right) || following_); }
  /// The frame that moves with the obstacles that move, too.
  MovingFrame following(const SideRows* side) const;
  /// The frame that moves with fixed ends alone, in which BarSystem::initial_state() is.
  MovingFrame resting(const SideRows* side) const;
  /// This one, with another resistance along the bar.
  MovingFrame with(const SideRows* side) const;
  bool follows() const { return following_; }  ///< true if it moves with obstacles
  /// True if the obstacle of a contact moves in the frame.
  bool moves(const Contact& contact) const {
    return contact.at_end() && !following_ && motions_[contact.where == Where::right].has_value();
  }
  /// gap(t) of a contact, or its derivative: constant where its obstacle does not move. @throws LoadError
  double gap(const Contact& contact, double t, int derivative = 0) const;
  /// gap(t), or a derivative of it, after less before a time at which that jumps; else 0.
  double gap_jump(const Contact& contact, double t, double end, int derivative = 0) const;

  /// Displacement of the frame, or its first or second derivative in time. @throws LoadError where it is not finite
  Lift lift(double t, int derivative) const;
  /// The same as lift(), from displacements a time `step` before and after t alone, as scheme (2.8) takes them: their
  /// mean, and the quotients of differences.
  Lift lift(double t, int derivative, double step) const;
  /// A displacement of the frame, or its rate, against which a contact is measured: none at a joint, where it is the
  /// same on both sides.
  double lift_at(const Contact& contact, const Lift& lift) const {
    return contact.joint > 0 ? 0.0 : lift.at(share(contact.unknown));
  }
  /// Elements::share() of an unknown's node, for Lift::at().
  double share(std::size_t unknown) const { return elements_->share(unknown + unknowns_.first_node()); }
  /// Adds the lift to a field over all mesh nodes.
  void add_lift(const Lift& lift, std::span<double> nodal) const;
  /// A field x(j) of all nodes with the lift, to both of which it refers.
  auto moved(const Lift& by, const auto& x) const {
    return [this, &by, &x](std::size_t j) { return x(j) + by.at(elements_->share(j)); };
  }
  /// Makes the state (u, w) at t in this frame that of the same motion in another one.
  void change(const MovingFrame& to, double t, std::span<double> u, std::span<double> w) const;

  /// Its jump at t, where a motion has a kink, or the gap of an obstacle jumps; absent: none. Sides of t are as those
  /// of LoadVector::enter(). @throws LoadError where the motion of a fixed end jumps itself
  std::optional<FrameJump> kink(double t, double end) const;
  /// Applies a jump of the frame to displacements and velocities in it: u -= jump, so that the bar stays where it is,
  /// and w -= (rho M)^{-1} rho M jump, which without fixed ends leaves those of the bar.
  void pass_kink(const FrameJump& jump, std::span<double> u, std::span<double> w) const;

  /// (rho M a)_i of an acceleration of the frame.
  double inertial_force(const Lift& acceleration, std::size_t unknown) const {
    return acceleration.left * inertial_[0][unknown] + acceleration.right * inertial_[1][unknown];
  }
  /// True if it stretches more than a bar alone, whose elements feel it at the ends only: of a side, and of a chain.
  bool has_inner_force() const { return !inner_[0][0].empty(); }
  /// -(M (k lift + c rate) + E K lift + eta K rate)_i, where has_inner_force().
  double inner_force(const Lift& lift, const Lift& rate, std::size_t unknown) const;

 private:
  void enter(const SideRows* side);

  std::shared_ptr<const Elements> elements_;
  std::shared_ptr<const Inertia> inertia_;
  Unknowns unknowns_;
  std::array<std::optional<EndMotion>, 2> motions_;
  std::array<bool, 2> free_{};                   // the ends
  bool following_ = false;                       // true if it moves with obstacles, too
  bool rigid_ = false;                           // moves as a whole, since the other end is free
  std::array<std::vector<double>, 2> inertial_;  // rho M (1 - x/L) and rho M x/L, where it moves
  std::array<std::array<std::vector<double>, 2>, 2>
      inner_;  // -(M k + E K) and -(M c + eta K) times those without rho M
};

}  // namespace viscobar

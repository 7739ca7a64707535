#pragma once

#include <optional>

#include "viscobar/dynamics/penalty_law.hpp"
#include "viscobar/scene/stop.hpp"

namespace viscobar {

/// The answer of a contact of sign s to its clearance g and the velocity w of its node, in the direction of u:
///
///     s R = -(s k g + b w) + s N(-g, -s w).
///
/// k and b are in the matrices of a system, infinite where the contact is rigid. N is what a Stop of its own has beside
/// them: all of its force where that is not linear, else nothing. Whoever asks for forces, tangents and energies asks
/// here, so that a further formula is one of Stop and touches no system.
class ContactLaw {
 public:
  ContactLaw(double sign, const PenaltyLaw& linear) : sign_(sign), linear_(linear) {}
  ContactLaw(double sign, const Stop& stop)
      : sign_(sign),
        linear_(stop.linear() ? PenaltyLaw{stop.stiffness, stop.damping} : PenaltyLaw{}),
        stop_(stop),
        bent_(!stop.linear()) {}

  const PenaltyLaw& linear() const { return linear_; }                   ///< k and b
  const Stop* stop() const { return stop_ ? &*stop_ : nullptr; }         ///< null: the penalty
  const Stop* bent() const { return bent_ ? &*stop_ : nullptr; }         ///< the same, of one that is not linear
  void linearise(const PenaltyLaw& as) { linear_ = as, bent_ = false; }  ///< from here on it is that
  /// s R, of either sign.
  double force(double clearance, double w) const {
    const double linear = -(sign_ * linear_.stiffness * clearance + linear_.damping * w);
    return bent_ ? linear + sign_ * stop_->force(-clearance, -sign_ * w) : linear;
  }
  /// dR/dd and dR/dd' at the depth d = -g.
  PenaltyLaw tangent(double clearance, double w) const {
    if (!bent_) return linear_;
    return {stop_->by_depth(-clearance, -sign_ * w), stop_->by_rate(-clearance, -sign_ * w)};
  }
  /// The power that N takes.
  double loss(double clearance, double w) const {
    if (!bent_) return 0.0;
    const double depth = -clearance, rate = -sign_ * w;
    return (stop_->force(depth, rate) - stop_->force(depth, 0.0)) * rate;
  }

 private:
  double sign_;
  PenaltyLaw linear_;
  std::optional<Stop> stop_{};
  bool bent_ = false;
};

}  // namespace viscobar

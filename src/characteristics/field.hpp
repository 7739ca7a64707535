#pragma once

#include <cmath>
#include <cstddef>
#include <optional>

#include "characteristics/gauss_legendre.hpp"
#include "characteristics/piecewise.hpp"

namespace viscobar::characteristics {

/// The bar at one time, by place in lengths of it: the waves on their way through it, and what they have gained.
class Field {
 public:
  /// What the two ends sent in this passage, up to s, and in the one before; what a load has added since then.
  struct Sent {
    const Piecewise &left_now, &left_before, &right_now, &right_before;
    const Piecewise *rightward_gain, *leftward_gain;  ///< null without a load
  };
  /// `left` and `right` are the displacements of the ends, `passage` is L / c.
  Field(const Sent& sent, double s, double left, double right, double passage)
      : left_(left),
        passage_(passage),
        right_going_(sent.left_now, sent.left_before, s),
        left_going_(sent.right_now, sent.right_before, s) {
    if (sent.rightward_gain) rightward_.emplace(*sent.rightward_gain);
    if (sent.leftward_gain) leftward_.emplace(*sent.leftward_gain);
    whole_left_going_ = left_going_.integral(1.0);
    correction_ = right - displacement(1.0);
  }

  double rightward(double place) { return right_going_.value(place) + (rightward_ ? rightward_->value(place) : 0.0); }
  double leftward(double place) { return left_going_.value(1.0 - place) + (leftward_ ? leftward_->value(place) : 0.0); }
  double velocity(double place) { return 0.5 * (rightward(place) + leftward(place)); }
  /// From the left end by the strain; what it misses the right end by, a rounding, is spread over the bar.
  double displacement(double place) {
    double sum = whole_left_going_ - left_going_.integral(1.0 - place) - right_going_.integral(place);
    if (rightward_) sum -= rightward_->integral(place);
    if (leftward_) sum += leftward_->integral(place);
    return left_ + 0.5 * passage_ * sum + place * correction_;
  }
  double correction() const { return correction_; }

 private:
  // What an end has sent, by the way l that it has come: sent at s - l of this passage, or of the one before.
  class Train {
   public:
    Train(const Piecewise& now, const Piecewise& before, double s)
        : now_(now), before_(before), s_(s), now_integral_(now_.integral(s)), before_integral_(before.integral()) {}
    double value(double way) { return way < s_ ? now_.value(s_ - way) : before_.value(1.0 + s_ - way); }
    double integral(double way) {
      return way < s_ ? now_integral_ - now_.integral(s_ - way)
                      : now_integral_ + before_integral_ - before_.integral(1.0 + s_ - way);
    }

   private:
    Cursor now_, before_;
    double s_, now_integral_, before_integral_;
  };

  double left_, passage_;
  Train right_going_, left_going_;
  std::optional<Cursor> rightward_, leftward_;
  double whole_left_going_ = 0.0, correction_ = 0.0;
};

}  // namespace viscobar::characteristics

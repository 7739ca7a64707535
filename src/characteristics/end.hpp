#pragma once

#include <cstddef>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

#include "characteristics/piecewise.hpp"
#include "viscobar/run/run.hpp"

namespace viscobar::characteristics {

/// Contact change at the part s of a passage.
struct Turn {
  double s;
  Change change;
  double velocity;   ///< of the end beside it: before a closing, after an opening
  ContactPeak peak;  ///< of the contact that ends, by parts of the passage and / (rho c)
};

/// One end of the bar. A passage is the time that a wave takes through the bar, s = 0 ... 1; within it what arrives, w
/// = v -+ s/(rho c), is known, and the end answers with what it sends back:
///
///     free       v = w, sends  w
///     fixed      v = 0, sends -w
///     obstacle   0 <= g  _|_  R >= 0:   open g' = w, sends w;   closed g = 0, R = -rho c w, sends -w,
///
/// so that the clearance g is the running integral G of w, lifted by what it has fallen below 0 so far: g = G + max(0,
/// max -G). That is for an obstacle below; above, g = -u + gap, and w and R have their signs turned. Two w whose
/// integrals differ by at most d give clearances that differ by at most 2 d.
///
/// A mass on the end lags behind what arrives: with a the rate of a passage,
///
///     open   dv/ds = a (w - v),     closed   v = 0, after an impulse v / a in the units of the others,
///
/// and a free or open end sends v.
class End {
 public:
  struct Start {
    double displacement, velocity;
  };
  /// `passage` is L / c, `rate` is a; 0: no mass. Data that touch up to their rounding touch.
  End(const EndCondition& condition, const Start& start, double passage, double rate);

  /// How large displacements and velocities are: what is smaller by 64 roundings is nothing.
  struct Scale {
    double place, velocity;
  };
  /// Sets `sent` to the wave it sends while `arriving` arrives, up to s = until.
  void answer(const Piecewise& arriving, double until, const Scale& scale, Piecewise& sent);

  /// Displacement between two passages; the clearance s u + gap at an end with an obstacle.
  double place() const { return place_; }
  double displacement() const { return displacement_of(place_); }  ///< u between two passages
  /// Within the passage answered last, of which `sent` was sent.
  double displacement_at(double s, Cursor& sent) const;
  double velocity_at(double s, Cursor& sent) const;
  double force_at(double s, Cursor& sent) const;    ///< of what holds it, / (rho c), in the direction of u
  double impulse_at(double s, Cursor& sent) const;  ///< from the beginning on, likewise
  bool held_at(double s) const { return kind_ == Kind::fixed || mark_at(s).closed; }  ///< fixed, or in contact

  /// From the beginning on: multiply impulses by rho c L / c and reactions by rho c.
  double impulse() const { return sign_ * borne_.impulse; }
  double max_reaction() const { return borne_.max_reaction; }  ///< away from an obstacle
  const ContactPeak& latest() const { return latest_; }        ///< as in Turn, of the last contact
  std::pair<double, double> range() const;                     ///< the least displacement and the largest

  const std::vector<Turn>& turns() const { return turns_; }  ///< of that passage, in order
  std::size_t searched() const { return searched_; }         ///< pieces, for turns

  /// As between two passages.
  static void members(auto& end, auto&& each) {
    each(end.place_, end.velocity_, end.closed_, end.borne_, end.searched_, end.latest_);
  }

 private:
  enum class Kind { free, fixed, obstacle };

  // Impulse and largest reaction, away from an obstacle, and the range of its places.
  struct Borne {
    double impulse = 0.0, max_reaction = 0.0;
    double lowest = std::numeric_limits<double>::infinity(), highest = -lowest;
    static void members(auto& borne, auto&& each) {
      each(borne.impulse, borne.max_reaction, borne.lowest, borne.highest);
    }
  };
  // From here on, until the next.
  struct Mark {
    double s, place, sent, impulse;  // sent: its integral, by of_sent(); both so far
    bool closed;
  };

  const Mark& mark_at(double s) const;
  double place_after(const Mark& mark, double sent) const {
    return mark.place + passage_ * (of_sent(sent) - mark.sent);
  }
  double displacement_of(double place) const { return kind_ == Kind::obstacle ? sign_ * (place - gap_) : place; }
  void meet(const Piecewise& arriving, std::size_t i, double end, const Scale& scale, Piecewise& sent);
  std::optional<double> closing(const Chebyshev& velocity, double duration, double clearance, const Scale& scale) const;
  void send_behind(const Piecewise::Piece& piece, const Chebyshev& arriving, double until, const Scale& scale,
                   Piecewise& sent);
  void turn(double s, double velocity, const Piecewise& sent);
  void send(const Piecewise::Piece& piece, const Chebyshev& arriving, double until, Piecewise& sent);
  void widen(const Chebyshev& velocity, double duration, double from, double to);
  void widen_to(double place);

  double of_sent(double value) const { return sign_ * value; }  // of its integral or value, towards open contact

  Kind kind_ = Kind::free;
  double passage_, rate_, sign_ = 1.0, gap_ = 0.0;
  double place_, velocity_;  // the latter of a mass, towards open contact
  bool closed_ = false;
  Borne borne_;
  ContactPeak latest_;
  std::size_t searched_ = 0;
  std::vector<Mark> marks_;
  std::vector<Turn> turns_;
};

}  // namespace viscobar::characteristics

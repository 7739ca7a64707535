#pragma once

#include <limits>

#include "characteristics/end.hpp"
#include "characteristics/piecewise_fit.hpp"
#include "viscobar/scene/scene.hpp"

namespace viscobar::characteristics {

/// Input of an end, a spring apart: a force F, a dashpot c, and the velocity V of what holds or bounds it. With Z
/// = rho c the impedance of the bar and w what arrives, an end that is free to move has Z (v - w) = F - c v,
///
///     v = (Z w + F) / (Z + c),     and, in contact or fixed,     v = V,   R = (Z + c) (V - (Z w + F) / (Z + c)).
///
/// So the end answers to w_r = (Z w + F) / (Z + c) - V as one that is given nothing answers to w (see End): what it
/// would send is its velocity against V, or R / (Z + c), and what it does send is 2 v - w. A mass m on an end that has
/// no V makes that m v' + (Z + c) v = Z w + F, of the rate (Z + c) / m.
class DrivenEnd {
 public:
  /// `impedance` is rho c, `passage` is L / c, `start` the time of passage 0. Refers to `input`.
  DrivenEnd(const EndInput& input, double impedance, double passage, double start);

  /// True if the end has an input.
  bool active() const { return active_; }
  /// To be called for each passage. @throws LoadError
  void enter(std::size_t passage);
  /// w_r of `arriving`; valid until the next call.
  const Piecewise& relative(const Piecewise& arriving);
  /// Sets `sent` to the wave it sends while `arriving` arrives, if `end` answers w_r by `moved`.
  void send(const End& end, const Piecewise& moved, const Piecewise& arriving, Piecewise& sent);

  double force_factor() const { return factor_; }  ///< (Z + c) / Z
  double mass() const { return input_.mass; }      ///< m
  /// (Z + c) / m of a passage; 0: no mass.
  double rate() const { return input_.mass > 0.0 ? factor_ * impedance_ * passage_ / input_.mass : 0.0; }
  double displacement(double t) const { return input_.motion ? input_.motion->displacement(t) : 0.0; }
  double velocity(double t) const { return input_.motion ? input_.motion->velocity(t) : 0.0; }
  bool moves() const { return input_.motion.has_value(); }
  double error() const { return error_; }  ///< of F and V over the passages, as velocities

  /// Its energies from the beginning of the passage to `until`.
  struct Flow {
    double work = 0.0, dissipated = 0.0;
  };
  Flow flow(const End& end, const Piecewise& moved, double until) const;

  /// Its energies and range since the start.
  struct Account : Flow {
    double lowest = std::numeric_limits<double>::infinity(), highest = -lowest;  // u, where it moves
    static void members(auto& account, auto&& each) {
      each(account.work, account.dissipated, account.lowest, account.highest);
    }
  };
  /// Adds the passage in which `end` moved so.
  void add(const End& end, const Piecewise& moved, Account& account) const;

 private:
  void fit(const TimeFunction& f, const NextBreak& breaks, const char* what, Piecewise& fitted);

  const EndInput& input_;
  double impedance_, passage_, start_, factor_ = 1.0, error_ = 0.0;
  bool active_;
  std::size_t now_ = 0;
  PiecewiseFit fit_;
  Piecewise force_, velocity_, relative_, scratch_;  // force_ is F / Z
  std::vector<double> breaks_;
};

}  // namespace viscobar::characteristics

#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <span>
#include <vector>

#include "dynamics/energy_terms.hpp"

namespace viscobar {

/// Finds the leg on which a multistep method resolves the spring of a contact at rest for nothing, and tells how to
/// pass over it.
///
/// A contact that stays closed does not bounce, and its oscillation dies out. Once that is smaller than what is
/// promised, it need not be followed. But Adams' formulas have to resolve the spring for stability, and backward
/// differentiation of order 5 amplifies an oscillation of omega h < 9.4. Of order 1 and 2 it is L-stable: so the leg
/// goes on with these, and errors of the size of the oscillation, for as many steps as it may take to leave the region
/// of instability behind, and then with all orders again (docs/internals/storms.md).
class RestWatch {
 public:
  enum class Advice {
    go_on,
    damp,      ///< begin anew by backward differentiation of order 1 and 2, with errors of w up to oscillation()
    release,   ///< go on by backward differentiation of all orders
    give_back  ///< it has not led further: begin anew by backward differentiation of all orders
  };

  /// The contacts are those of the leg.
  void begin_leg(const Contacts& contacts, double t) {
    look_for_springs(contacts);
    patience_ = first_patience;
    begin_stretch(t, State::resolving);
  }

  /// After each step, which led to t and the velocities w; `promised` is the error of w that is promised.
  Advice stepped(double t, std::span<const double> w, double promised) {
    if (nodes_.empty()) return Advice::go_on;
    const double pace = (t - times_[steps_ % window]) / window;  // time per step, over the last ones
    times_[steps_ % window] = t;
    double& largest = velocities_[steps_ % window] = 0.0;
    for (const std::size_t i : nodes_) largest = std::max(largest, std::abs(w[i]));
    ++steps_;
    switch (state_) {
      case State::resolving:
      case State::released:
        if (steps_ < patience_ || pace >= 0.5 * period_) return Advice::go_on;
        oscillation_ = *std::ranges::max_element(velocities_);
        if (oscillation_ > share * promised) return Advice::go_on;
        return begin_stretch(t, State::damped), Advice::damp;
      case State::damped:
        if (steps_ >= window && pace > released_periods * period_)
          return begin_stretch(t, State::released), Advice::release;
        if (steps_ < most_damped) return Advice::go_on;
        patience_ *= 2;
        return begin_stretch(t, State::resolving), Advice::give_back;
    }
    return Advice::go_on;
  }

  /// Largest velocity of a node at rest, over the last steps before it was damped.
  double oscillation() const { return oscillation_; }

 private:
  enum class State { resolving, damped, released };

  static constexpr std::size_t window = 20;           // steps
  static constexpr std::size_t first_patience = 400;  // steps on a leg before it is damped: a bounce takes tens
  static constexpr std::size_t most_damped = 300;     // steps
  static constexpr double released_periods = 2.5;     // omega h = 5 pi
  static constexpr double share = 0.1;                // of the promised error, that the oscillation may be

  // None where nothing dissipates, and an oscillation stays.
  void look_for_springs(const Contacts& contacts) {
    nodes_.clear();
    period_ = 0.0;
    if (!dissipates(contacts)) return;
    for (std::size_t i = 0; i < contacts.size(); ++i) {
      const double rate = contacts.closed(i) ? contacts[i].rate : 0.0;
      if (rate == 0.0) continue;
      nodes_.push_back(contacts[i].unknown);
      period_ = std::max(period_, 2.0 * std::numbers::pi / rate);
    }
  }

  void begin_stretch(double t, State state) {
    state_ = state;
    times_.fill(t);
    velocities_.fill(0.0);
    steps_ = 0;
  }

  std::vector<std::size_t> nodes_;                     // with mass, of closed contacts
  double period_ = 0.0;                                // of the slowest of their springs
  std::array<double, window> times_{}, velocities_{};  // that the last steps led to
  double oscillation_ = 0.0;
  std::size_t steps_ = 0, patience_ = first_patience;
  State state_ = State::resolving;
};

}  // namespace viscobar

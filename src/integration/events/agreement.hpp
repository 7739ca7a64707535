#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <functional>
#include <limits>
#include <optional>
#include <span>
#include <vector>

#include "dynamics/indicator.hpp"
#include "integration/bernstein.hpp"
#include "integration/stepper.hpp"

namespace viscobar {

/// 1 of an open contact, -1 of a closed one: times that its indicator descends through zero where it changes.
inline double orientation(const Contacts& contacts, std::size_t i) { return contacts.closed(i) ? -1.0 : 1.0; }

/// The motion's agreement to a change of a contact.
///
/// Its indicator alone may err by what a step errs by. So a contact changes only where the motion agrees: a node that
/// closes moves in, and the row of a damped node without mass has the sign that the new state asks for. Where it does
/// not agree at the descent of the indicator, the change is where it begins to.
///
/// A contact that pulls, R < 0, holds back the bar of mass m and its node. The bar loses a velocity, V = int |R|/m dt.
/// The node misses the way int |R| / (A eta/h + z) + V dt; z is A sqrt(E rho) for one with mass, else 0. A damped node
/// without mass, one that a rigid contact holds, and one that toggles on a spring without rebound are let go as soon as
/// V or that way exceeds the tolerance of a step, and the bar gets V back. A pull that is an error of the motion turns
/// before.
class Agreement {
 public:
  /// The oriented indicator of a contact that holds a node with mass, at a time of the step made last: its row.
  using HeldRow = std::function<double(std::size_t i, double t)>;
  /// All outlive it; `size` is that of the state.
  Agreement(PenalisedSystem& system, LegStepper& stepper, std::size_t size, HeldRow held_row);

  /// The first part of the step from `begin` to `end`, from s on, at which contact i changes, whose oriented indicator
  /// p has descended there.
  std::optional<double> to_change(std::size_t i, double begin, double end, double s, const Bernstein& p);

  /// Positive where the motion at t, in the state y, speaks against a change of contact i.
  double against(std::size_t i, double t, std::span<const double> y) const;
  /// The same at a time of the step made last.
  double against(std::size_t i, double t);

  /// The indicator of contact i is known up to that.
  double uncertainty(std::size_t i) const;
  /// From here on the clearance of contact i counts as uncertain by a share of the tolerance, too.
  void distrust(std::size_t i, double share) { distrusted_ = i, share_ = share; }

  /// Since when contact i has pulled, at the latest t, where it opens.
  double pulled_since(std::size_t i, double t) const { return std::min(t, pulls_[i].since); }
  /// The velocity that it has taken from the bar meanwhile.
  double held_back(std::size_t i) const { return pulls_[i].velocity; }

  /// The polynomial of the step's order through f at equidistant times.
  Bernstein polynomial(double from, double end, auto&& f) const {
    const std::size_t order = stepper_.order();
    std::array<double, Bernstein::max_degree + 1> values{};
    for (std::size_t j = 0; j <= order; ++j)
      values[j] = f(j == order ? end : from + (end - from) * static_cast<double>(j) / static_cast<double>(order));
    return Bernstein::through(std::span(values).first(order + 1));
  }

 private:
  // Pull of a closed contact that opens by it: its beginning, how far it is known, and what the bar, its node and a
  // rigid body at it have missed.
  struct Pull {
    double since = std::numeric_limits<double>::infinity(), until = since, velocity = 0.0, distance = 0.0;
    double of_body = 0.0, way_of_body = 0.0;
  };

  std::optional<double> lasting(std::size_t i, double begin, double end, double s, const Bernstein& p);
  bool counts(std::size_t i, double from, double until, const Bernstein& pushes, Pull& pull) const;
  double noticed(std::size_t i, double h) const;
  double push(std::size_t i, double t);
  double pressed_back(std::size_t i, double t);
  bool opens_by_pull(std::size_t i) const {
    return contacts_.closed(i) && (contacts_[i].changes_by_row || contacts_[i].collides);
  }
  // A spring on a node with mass, whose depth may be less than a step is wrong by. One that never throws its node out
  // opens by its pull where it toggles.
  bool springs(std::size_t i) const { return !contacts_[i].massless && !contacts_[i].collides; }
  bool rebounds(std::size_t i) const { return contacts_[i].restitution > 0.0 || contacts_[i].law.stop(); }
  bool toggles(std::size_t i) const { return i == distrusted_ && share_ > 0.0; }

  PenalisedSystem& system_;
  const Contacts& contacts_;
  Indicators indicators_;
  LegStepper& stepper_;
  HeldRow held_row_;
  double mass_;                               // of all members
  std::vector<double> state_, acceleration_;  // where the indicator descends
  std::vector<Pull> pulls_;                   // of each contact
  std::size_t distrusted_ = 0;
  double share_ = 0.0;
};

}  // namespace viscobar

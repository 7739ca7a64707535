#include "integration/events/agreement.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "dynamics/contact_forces.hpp"
#include "dynamics/contact_rows.hpp"
#include "dynamics/pieces.hpp"

namespace viscobar {

namespace {

// The mass of all members.
double mass_of(const std::vector<Piece>& pieces) {
  double mass = 0.0;
  for (const Piece& piece : pieces) {
    mass += piece.mass;
    for (std::size_t e = 0; e < piece.mesh.elements; ++e)
      mass += piece.bar.density * piece.area(e) * piece.mesh.element(e);
  }
  return mass;
}

}  // namespace

Agreement::Agreement(PenalisedSystem& system, LegStepper& stepper, std::size_t size, HeldRow held_row)
    : system_(system),
      contacts_(system.contacts()),
      indicators_(contacts_, system.load()),
      stepper_(stepper),
      held_row_(std::move(held_row)),
      mass_(mass_of(system.bar().elements().pieces())),
      state_(size),
      pulls_(contacts_.size()) {}

// A spring answers to its own clearance, which is known to rounding, and a rigid contact to its reaction. What toggles
// is more and more of the tolerance uncertain.
double Agreement::uncertainty(std::size_t i) const {
  const ErrorWeights& weights = stepper_.weights();
  if (contacts_[i].holds)
    return contacts_.closed(i)     ? contacts_[i].clearance_rounding(weights.largest_displacement())
           : contacts_[i].collides ? weights.tolerance_at(i)
                                   : weights.displacement_tolerance();
  const double rounding = indicators_.rounding(i, weights.largest_displacement());
  if (!toggles(i) || (contacts_.closed(i) && springs(i))) return rounding;
  return rounding + share_ * (contacts_.closed(i) && contacts_[i].relaxes()
                                  ? weights.reaction_tolerance() / (1.0 + contacts_[i].relative_stiffness)
                                  : weights.displacement_tolerance());
}

// The velocity of a node that is to close, away from the obstacle, or that is to leave, towards it; by the row of a
// damped node without mass, (h/E) times a reaction that holds it, or pulls.
double Agreement::against(std::size_t i, double t, std::span<const double> y) const {
  const std::size_t n = system_.size(), node = contacts_[i].unknown;
  const std::span<const double> u = y.first(n), w = y.subspan(n, n);
  if (contacts_[i].changes_by_row)
    return -orientation(contacts_, i) * row_reaction(system_, i, t, u, w) *
           system_.bar().elements().stretch_beside(node) / system_.bar().bar().modulus;
  // The indicator of an undamped node without mass is its neighbour's.
  return system_.bar().inertia().massless(node) ? 0.0
                                                : orientation(contacts_, i) * contacts_[i].sign * contacts_[i].of(w);
}

double Agreement::against(std::size_t i, double t) {
  if (contacts_.holds_mass(i)) return held_row_(i, t);
  stepper_.interpolate_ends(t, state_);
  return against(i, t, state_);
}

// (h/E) times the reaction of a closed contact that opens by it. One whose spring is on a node with mass counts as open
// meanwhile: the spring's own force is mostly its stiffness times the error of a depth.
double Agreement::push(std::size_t i, double t) {
  if (!springs(i)) return against(i, t);
  const std::size_t n = system_.size();
  acceleration_.resize(n);
  stepper_.interpolate(t, state_);
  const std::span<double> u(state_.data(), n), w(state_.data() + n, n);
  return resting_force(system_, i, t, u, w, acceleration_) *
         system_.bar().elements().stretch_beside(contacts_[i].unknown) / system_.bar().bar().modulus;
}

// Positive where the bar presses the node of contact i, open now, back before it rises by what is uncertain: a spring
// that rebounds answers to its own clearance, one that is critically damped to the tolerance.
double Agreement::pressed_back(std::size_t i, double t) {
  const double within = rebounds(i) ? uncertainty(i) : stepper_.weights().displacement_tolerance();
  push(i, t);
  const double leaves = contacts_[i].of(std::span<const double>(state_).subspan(system_.size(), system_.size()));
  return -contacts_[i].sign * contacts_[i].of(acceleration_) * within - 0.5 * leaves * leaves;
}

// Where nothing speaks against it any more. The row of a held node with mass is p itself.
std::optional<double> Agreement::to_change(std::size_t i, double begin, double end, double s, const Bernstein& p) {
  // From s on.
  const auto wait = [&](auto&& speaks_against) {
    const double from = begin + s * (end - begin);
    if (!(speaks_against(from) > 0.0)) return true;
    const auto part = polynomial(from, end, speaks_against).first_descent(0.0);
    if (part) s += *part * (1.0 - s);
    return part.has_value();
  };
  if (!contacts_.holds_mass(i) && !wait([&](double t) { return against(i, t); })) return std::nullopt;
  if (!contacts_.closed(i) || !springs(i)) return opens_by_pull(i) ? lasting(i, begin, end, s, p) : std::optional(s);
  system_.contacts().set_closed(i, false);
  std::optional<double> opens;
  if (wait([&](double t) { return pressed_back(i, t); }))
    opens = toggles(i) && !rebounds(i) ? lasting(i, begin, end, s, p) : s;
  system_.contacts().set_closed(i, true);
  return opens;
}

// Where contact i opens, which pulls from the part s of the step on, and maybe since earlier: by all that it pulls up
// to the end of the step, or by one of the pulls in it that the rest of a long step outweighs.
std::optional<double> Agreement::lasting(std::size_t i, double begin, double end, double s, const Bernstein& p) {
  Pull& pull = pulls_[i];
  if (pull.until != begin) pull = {};
  const auto time = [=](double part) { return part == 1.0 ? end : begin + part * (end - begin); };
  const auto push_between = [&](double from, double to) {
    return contacts_.holds_mass(i) ? p.between(from, to)
                                   : polynomial(time(from), time(to), [&](double t) { return push(i, t); });
  };
  const auto turn_of = [](const Bernstein& of, double from) {
    const auto turn = of.first_descent(0.0);
    return turn ? std::optional(from + *turn * (1.0 - from)) : std::nullopt;
  };
  Bernstein pushes = push_between(s, 1.0);
  if (counts(i, time(s), end, pushes, pull)) return s;
  // No more of them than a polynomial has zeros.
  for (std::size_t k = 0; k < stepper_.order(); ++k) {
    Bernstein pulls = pushes.negative();
    pulls.begin_at_least_at_zero();  // but for rounding
    const auto until = turn_of(pulls, s);
    if (!until) return std::nullopt;
    if (Pull one; counts(i, time(s), time(*until), push_between(s, *until), one)) return pull = one, s;
    const auto next = turn_of(push_between(*until, 1.0), *until);
    if (!next) return std::nullopt;
    s = *next;
    pushes = push_between(s, 1.0);
  }
  return std::nullopt;
}

// True if contact i opens by its pull with that of the time from `from` to `until`, the bar pushing it as told.
bool Agreement::counts(std::size_t i, double from, double until, const Bernstein& pushes, Pull& pull) const {
  const double time = until - from;
  const Bar& bar = system_.bar().bar();
  const ErrorWeights& weights = stepper_.weights();
  const std::size_t node = contacts_[i].unknown;
  const Elements& elements = system_.bar().elements();
  const std::size_t beside = elements.beside(node);
  const double h = elements.stretch(beside), dashpot = bar.viscosity / elements.rate_stretch(beside),
               own = bar_at(elements.pieces(), node + system_.bar().unknowns().first_node()).impedance(),
               impedance = system_.bar().inertia().massless(node) ? 0.0
                           : own > 0.0                            ? own
                                                                  : mass_ / bar.transit();  // of a rigid body
  const double force = std::max(-pushes.mean(), 0.0) * bar.modulus / h;
  const double gained = force / mass_ * time;
  pull.distance += (force / (dashpot + impedance) + pull.velocity + 0.5 * gained) * time;
  pull.velocity += gained;
  if (const auto body = row_of_free_body(contacts_, i)) {
    const double mass = body->inertia[0];
    pull.way_of_body += (pull.of_body + 0.5 * force / mass * time) * time;
    pull.of_body += force / mass * time;
  }
  pull.since = std::min(pull.since, from);
  pull.until = pushes.end() < 0.0 ? until : -std::numeric_limits<double>::infinity();
  const bool counts = pull.velocity > weights.velocity_tolerance() ||
                      pull.distance > weights.displacement_tolerance() || pull.of_body > weights.velocity_tolerance() ||
                      pull.way_of_body > weights.displacement_tolerance() ||
                      (contacts_[i].collides && pushes.first_descent(-noticed(i, h)));
  if (counts) pull.velocity -= gained;
  return counts;
}

// (h/E) times the pull that opens a rigid contact on a node with mass at once, which has an effect. On a fine mesh the
// error of a step shows in the reaction as more than that, and a bar that comes to rest may toggle: then, and for that
// contact alone, the reaction counts as uncertain by a share of that error.
double Agreement::noticed(std::size_t i, double h) const {
  const ErrorWeights& weights = stepper_.weights();
  const double least = weights.negligible_reaction(h);
  return toggles(i) ? least + share_ * ErrorWeights::inertial_share * weights.reaction_tolerance() : least;
}

}  // namespace viscobar

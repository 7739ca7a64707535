#include "integration/events/contact_changes.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "dynamics/impact.hpp"
#include "dynamics/obstacle_motion.hpp"
#include "dynamics/pieces.hpp"

namespace viscobar {

// Rigid contacts strike one after the other: those to come are open, and one that has moved apart by then stays so.
bool ContactChanges::start(double t, const State& data, const std::vector<double>& approach) {
  std::vector<std::size_t> settled;
  for (std::size_t i = 0; i < contacts_.size(); ++i) {
    if (!contacts_.closed(i)) continue;
    settled.push_back(i);
    if (contacts_[i].collides) contacts_.set_closed(i, false);
  }
  bool struck = false, any = false;
  for (const std::size_t i : settled) {
    if (contacts_[i].collides && contacts_[i].sign * contacts_[i].of(w()) > 0.0) continue;
    any = true;
    differentiate_start(t, i, data, approach);
    const double velocity = struck ? contacts_[i].of(w()) : contacts_[i].of(approach);
    struck = struck || contacts_[i].collides;
    if (contacts_[i].collides)
      strike(t, i, velocity);
    else
      tell(t, i, Change::closing, velocity);
    if (on_.sensitivities) on_.sensitivities->after(t, i, on_.y);
  }
  return any;
}

// The contact is closed from the start on: the bar comes to it with the velocities that it is given.
void ContactChanges::differentiate_start(double t, std::size_t i, const State& data,
                                         const std::vector<double>& approach) {
  if (!on_.sensitivities) return;
  if (contacts_[i].collides) {  // after those that have struck before it
    changes_ = on_.sensitivities->before(t, t, i, false, on_.y);
    return;
  }
  const bool closed = contacts_.closed(i);
  const std::vector<double> settled = on_.y;
  contacts_.set_closed(i, false);
  std::ranges::copy(data.u, u().begin());
  std::ranges::copy(approach, w().begin());
  on_.system.complete_displacement(t, u());
  changes_ = on_.sensitivities->before(t, t, i, false, on_.y);
  std::copy_n(settled.begin(), 2 * on_.layout.nodes, on_.y.begin());
  contacts_.set_closed(i, closed);
}

void ContactChanges::switch_at(double t, double begin, double end, double load_break) {
  on_.system.complete_velocity(t, u(), w());
  on_.search.look_at(begin, t);
  const std::size_t first = on_.search.first_contact();
  switch_one(first, t, begin, end, load_break);  // it may be told of a time before t
  for (std::size_t i = 0; i < contacts_.size(); ++i)
    if (i != first && on_.search.changes(i, t, on_.y)) switch_one(i, t, begin, end, load_break);
  on_.watchdog.change(t, first);
  distrust_toggling();
}

void ContactChanges::switch_one(std::size_t i, double t, double begin, double end, double load_break) {
  const bool opens = contacts_.closed(i), first = i == on_.search.first_contact();
  const bool by_push = first && on_.search.by_push();
  const double told =
      opens && first ? std::max(on_.search.agreement().pulled_since(i, t), on_.watchdog.last_change()) : t;
  if (on_.sensitivities)
    changes_ = (opens || by_push) && t == load_break ? on_.sensitivities->at_break(t, on_.end, i, on_.y)
                                                     : on_.sensitivities->before(t, told, i, by_push, on_.y);
  if (by_push)
    on_.books.dissipate((opens ? 1.0 : -1.0) * contacts_[i].law.stop()->energy(-contacts_.clearance(i, u())));
  if (!opens) close(t, i, contacts_[i].of(w()));
  // A node that follows its neighbour at once is put where the new state has it as the next leg begins.
  if (!by_push && (!on_.system.bar().inertia().massless(contacts_[i].unknown) || on_.system.bar().bar().damped()))
    contacts_.place(i, u());
  if (opens) open(i, told, {t, begin, end, on_.watchdog.last_change(), load_break});
  if (on_.sensitivities) on_.sensitivities->after(t, i, on_.y);
}

void ContactChanges::open(std::size_t i, double told, const Opening& opening) {
  const double t = opening.t;
  contacts_.set_closed(i, false);
  if (i == on_.search.first_contact()) give_back(contacts_[i].sign * on_.search.agreement().held_back(i));
  // A rounding of its penetration is a velocity of a node without mass.
  if (contacts_[i].changes_by_row) on_.system.complete_velocity(t, u(), w());
  tell(told, i, Change::opening, contacts_[i].of(w()));
  if (!contacts_[i].law.stop() && (contacts_[i].is_passed_over(opening.end - opening.begin) ||
                                   contacts_[i].has_come_to_rest(t - opening.last_change)))
    weigh_opening({on_.system, on_.layout, on_.stepper}, i, opening, inner_, statistics_.late_opening);
}

// The velocity that the pull of a contact has taken from the bar before it opened, and the heat that made of it.
void ContactChanges::give_back(double velocity) {
  if (velocity == 0.0) return;
  const double before = kinetic_energy(w());
  for (std::size_t i = 0; i < on_.layout.nodes; ++i)
    if (!contacts_.held(i)) w()[i] += velocity;
  on_.books.dissipate(-(kinetic_energy(w()) - before));
}

// 0 where nobody keeps the account.
double ContactChanges::kinetic_energy(std::span<const double> w) const {
  return on_.layout.account() > 0 ? 0.5 * on_.system.bar().inertia().matrix().quadratic_form(w) : 0.0;
}

// Its node is at the obstacle, or there to rounding. Bounces lower than what a step may be wrong by are not resolved.
void ContactChanges::close(double t, std::size_t i, double velocity) {
  if (contacts_[i].collides) return strike(t, i, velocity);
  tell(t, i, Change::closing, velocity);
  contacts_.set_closed(i, true);
  Watchdog::close(t, contacts_[i].unknown + on_.system.bar().unknowns().first_node(), contacts_[i].rate);
}

// The impact of a rigid contact. `closing` is the velocity that its closing is told with, absent where that has been
// told. One that neither rests nor rebounds, because the bar pulls its node away at once, is an error of the mesh: it
// is no contact, unless the wave that it sends brings the node back (see tell_closing()). Where a mass of the scene
// strikes, or an obstacle moves in by more than half of that velocity and turns back, it is one.
void ContactChanges::strike(double t, std::size_t i, std::optional<double> closing) {
  ErrorWeights& weights = on_.stepper.weights();
  const double h = on_.system.bar().elements().stretch_beside(contacts_[i].unknown);
  std::vector<double> change(w().begin(), w().end());
  const Collision collision =
      collide(on_.system, i, t, u(), w(),
              {weights.negligible_bounce(i), weights.negligible_reaction(h), weights.promised_velocity()});
  weights.bounce(i, collision.height);
  on_.books.dissipate(collision.dissipated);
  on_.books.lose_in_end_rows(kinetic_energy(change) - kinetic_energy(w()) - collision.dissipated);
  const double leaves = contacts_[i].of(w());
  const bool felt = closing && std::abs(*closing) > weights.promised_velocity();
  const bool counts = collision.rests || leaves != 0.0 || !closing || (felt && is_of_scene(t, i, *closing));
  if (closing && counts)
    tell_closing(t, i, *closing);
  else if (felt)
    withhold_closing(t, i, *closing);
  for (std::size_t j = 0; j < change.size(); ++j) change[j] = w()[j] - change[j];
  if (on_.ends) on_.ends->strike(i, collision.impulse, change);
  if (on_.sensitivities) on_.sensitivities->rebound(i, changes_);
  for (const std::size_t k : collision.released) {
    if (on_.sensitivities) on_.sensitivities->lose(t, "an impact opens another contact", on_.y);
    // They are at the time of the impact, each with a velocity of its own.
    for (ChangeSensitivity& told : changes_) told.velocity = std::numeric_limits<double>::quiet_NaN();
    tell(t, k, Change::opening, contacts_[k].of(w()));
  }
  if (collision.rests)
    contacts_.set_closed(i, true);
  else if (counts)
    tell(t, i, Change::opening, leaves);
}

bool ContactChanges::is_of_scene(double t, std::size_t i, double closing) const {
  const BarSystem& bar = on_.system.bar();
  const auto has_mass = [&](std::size_t unknown) {
    return std::ranges::any_of(
               bar.supports(),
               [&](const Support& support) { return support.unknown == unknown && support.mass > 0.0; }) ||
           std::ranges::any_of(bar.elements().pieces(), [&](const Piece& piece) {
             return piece.rigid() && piece.has(unknown + bar.unknowns().first_node());
           });
  };
  const Contact& contact = contacts_[i];
  return (has_mass(contact.unknown) && (contact.joint == 0 || has_mass(contact.unknown - 1))) ||
         2.0 * contact.sign * frame_velocity(t, i) > std::abs(closing);
}

// Energy that the penalty has stored is lost, as work of the obstacle.
void ContactChanges::leave_obstacles(double t, const FrameJump& jump) {
  const double largest = on_.stepper.weights().largest_displacement();
  for (const std::size_t i : left_by_jump(contacts_, jump, t, u(), largest)) {
    contacts_.set_closed(i, false);
    on_.system.complete_velocity(t, u(), w());
    if (on_.sensitivities) changes_ = on_.sensitivities->at_break(t, on_.end, i, on_.y);
    tell(t, i, Change::opening, w()[contacts_[i].unknown]);
  }
}

void ContactChanges::strike_by_kink(double t, const FrameJump& jump) {
  for (std::size_t i = 0; i < contacts_.size(); ++i) {
    const std::size_t node = contacts_[i].unknown;
    if (!contacts_.holds_mass(i) || contacts_[i].joint > 0) continue;
    // A kink of the other end's motion leaves a rounding.
    if (jump.velocity.at(on_.system.bar().frame().share(node)) == 0.0) w()[node] = 0.0;
    if (w()[node] == 0.0) continue;
    contacts_.set_closed(i, false);
    if (on_.sensitivities) changes_ = on_.sensitivities->at_break(t, on_.end, i, on_.y);
    if (contacts_[i].sign * w()[node] < 0.0)
      strike(t, i, std::nullopt);
    else
      tell(t, i, Change::opening, w()[node]);
  }
}

// A step across a jump of the load may leave the surface by less than its error, to either side, and a bar that has
// stood at the origin has no rounding to speak of: what toggles is more and more of the tolerance uncertain.
void ContactChanges::distrust_toggling() {
  const std::size_t toggles = on_.watchdog.toggles();
  const double share = std::pow(10.0, std::min(static_cast<double>(toggles) - 10.0, 0.0));
  on_.search.agreement().distrust(on_.watchdog.last_contact(), toggles > 0 ? share : 0.0);
}

// The velocity of the frame at a contact is that of its obstacle, at a kink on the side of the leg.
double ContactChanges::frame_velocity(double t, std::size_t i) const {
  const BarSystem& bar = on_.system.bar();
  return bar.frame().moving() ? bar.frame().lift_at(contacts_[i], on_.system.load().lift(t, 1)) : 0.0;
}

// True if the node is back before a wave has crossed the element behind it: no mesh tells these strikes apart.
bool ContactChanges::goes_on(double t, std::size_t i) const {
  if (!withheld_ || withheld_->contact != i) return false;
  const Mesh& mesh = on_.system.bar().mesh();
  const Contact& contact = contacts_[i];
  const double h = mesh.element(contact.joint > 0              ? on_.system.bar().elements().beside(contact.unknown)
                                : contact.where == Where::left ? 0
                                                               : mesh.elements - 1);
  return t - withheld_->last < h * on_.system.bar().bar().slowness();
}

void ContactChanges::withhold_closing(double t, std::size_t i, double velocity) {
  if (goes_on(t, i)) {
    withheld_->last = t;
    return;
  }
  withheld_ = {i, t, t, velocity + frame_velocity(t, i), sensitivities_at(t, i), std::nullopt};
  const Contact& contact = contacts_[i];
  if (statistics_.account)
    withheld_->impulse = statistics_.account->of({.where = contact.where, .node = contact.joint}).impulse;
}

// A contact begins with the first of the strikes that are one.
void ContactChanges::tell_closing(double t, std::size_t i, double velocity) {
  if (!goes_on(t, i)) return tell(t, i, Change::closing, velocity);
  const Withheld first = *std::exchange(withheld_, std::nullopt);
  notifier_.event(first.time, on_.system.bar().unknowns().first_node(), contacts_[i], Change::closing, first.velocity,
                  first.sensitivities, first.impulse);
}

void ContactChanges::tell(double t, std::size_t i, Change change, double velocity) {
  withheld_.reset();  // events are told in their order
  notifier_.event(t, on_.system.bar().unknowns().first_node(), contacts_[i], change, velocity + frame_velocity(t, i),
                  sensitivities_at(t, i));
}

std::vector<ChangeSensitivity> ContactChanges::sensitivities_at(double t, std::size_t i) const {
  std::vector<ChangeSensitivity> of_bar = changes_;
  if (on_.sensitivities) on_.sensitivities->add_frame(t, i, of_bar);
  return of_bar;
}

}  // namespace viscobar

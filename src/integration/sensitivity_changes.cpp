// Derivatives through contact changes.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <span>
#include <vector>

#include "dynamics/contact_forces.hpp"
#include "dynamics/indicator.hpp"
#include "integration/sensitivities.hpp"

namespace viscobar {

// Makes time_ the motion of (v, a).
void Sensitivities::differentiate_by_time(const Moment& at) {
  std::ranges::fill(load_rate_, 0.0);
  system_.load().add_rate(at.t, load_rate_);
  time_.take_contacts();
}

// Acceleration of the node of contact i; that of a massless one follows from its row. Without viscosity this needs a
// second derivative of the load, which nobody knows.
double Sensitivities::acceleration_of(const Moment& at, std::size_t i) {
  const BarSystem& bar = system_.bar();
  const std::size_t node = contacts_[i].unknown;
  if (!bar.inertia().massless(node)) return contacts_[i].of(acceleration_);
  if (!bar.bar().damped() && system_.load().varies()) return nothing;
  differentiate_by_time(at);
  std::vector<double> rates = acceleration_;
  time_.motion().complete_velocity(at.t, at.w, rates);
  return rates[node];
}

// Rate of s u + gap, or of the push condition or the reaction where that decides.
double Sensitivities::indicator_rate(const Moment& at, std::size_t i, bool by_push) {
  if (by_push) {
    // Those of the clearance and of its rate, the latter of the node itself.
    const auto weights = *push_weights(contacts_, i);
    const double of_rate = contacts_[i].joint > 0 ? weights.values[3] : weights.values[2];
    return weights.values[1] * contacts_[i].of(at.w) + of_rate * contacts_[i].of(acceleration_);
  }
  if (!opens_by_reaction(i)) return contacts_[i].sign * contacts_[i].of(at.w);
  differentiate_by_time(at);
  return time_.opening_reaction(i, at, at.w, acceleration_);
}

// With delta ten tolerances of the indicator, phi + phi' tau + phi'' tau^2 / 2 = +-delta has no root where phi'^2 is
// less than 2 |phi''| delta. Of a reaction phi'' is not known: a bar's own time is L / c.
bool Sensitivities::grazes(std::size_t i, double rate) const {
  const BarSystem& bar = system_.bar();
  const double tolerances = 10.0 / promised_multiple;
  const double u = tolerances * weights_->promised_displacement(), w = tolerances * weights_->promised_velocity();
  const std::size_t node = contacts_[i].unknown;
  if (!opens_by_reaction(i))
    return std::abs(rate) <= w || rate * rate <= 2.0 * std::abs(contacts_[i].of(acceleration_)) * u;
  const double h = bar.elements().stretch_beside(node), length = bar.bar().length;
  const double reaction = ErrorWeights::inertial_share * (u + bar.bar().viscosity / bar.bar().modulus * w);
  const double speed = bar.bar().wave_speed();
  const double flattest = std::sqrt(2.0 * reaction * h / length * weights_->largest_displacement()) * speed / length;
  return std::abs(rate) * h / bar.bar().modulus <= flattest;
}

// A stiff spring on a node without mass has its reaction from the row, too.
bool Sensitivities::opens_by_reaction(std::size_t i) const {
  return contacts_.closed(i) && (contacts_[i].holds || (contacts_[i].relaxes() && contacts_[i].changes_by_row));
}

// True if a rigid contact opens because of another's change at that time, which leaves it with a pull: then its time is
// that of the other.
bool Sensitivities::is_torn_off(const Moment& at, std::size_t i) {
  if (at.t != last_change_.first || i == last_change_.second || !contacts_.closed(i) || !contacts_[i].collides)
    return false;
  const Bar& bar = system_.bar().bar();
  const double h = system_.bar().elements().stretch_beside(contacts_[i].unknown);
  const double pull = -contacts_[i].sign * holding_force(system_, i, at.t, at.u, at.w) * h / bar.modulus;
  return pull > weights_->promised_displacement() + bar.viscosity / bar.modulus * weights_->promised_velocity();
}

// True if the rate of the state jumps where contact i changes: without a dashpot a spring begins and ends with none,
// and a stop ends with none.
bool Sensitivities::jumps(std::size_t i, bool by_push) const {
  if (contacts_[i].law.stop() && (contacts_.closed(i) || by_push)) return false;
  return contacts_[i].holds || contacts_[i].law.linear().damping > 0.0;
}

std::vector<ChangeSensitivity> Sensitivities::before(double t, double since, std::size_t i, bool by_push,
                                                     std::span<double> y) {
  std::vector<ChangeSensitivity> changes(pointers_.size(), {nothing, nothing});
  shifted_ = false;
  if (lost()) return changes;
  const std::size_t n = layout_->nodes;
  const Contact& contact = contacts_[i];
  const Moment at = look_at(t, y);
  const double rate = indicator_rate(at, i, by_push);
  const bool forced = is_torn_off(at, i), held = opens_by_reaction(i);
  const bool graze = !forced && (grazes(i, rate) || (since < t && contacts_[i].collides));
  const double acceleration = acceleration_of(at, i);
  old_velocity_ = w_;
  old_acceleration_ = acceleration_;
  bool moves = false;
  each(y, [&](std::size_t k, Derivative& derivative, const Block& s) {
    complete(derivative, at, s);
    const double fall = by_push ? derivative.push_rate(i, at, s.u(), s.w())
                        : held  ? derivative.opening_reaction(i, at, s.u(), s.w())
                                : derivative.motion().contacts().clearance(i, s.u());
    // A reaction that is nothing from another contact's opening on, as of two forces on one body, ends with that.
    const bool follows = fall == 0.0 && held && graze && t == last_change_.first && i != last_change_.second;
    if (!follows && !forced) shifts_[k] = fall == 0.0 ? 0.0 : -fall / rate;
    moves |= fall != 0.0;
    if (!graze || fall == 0.0)
      changes[k] = {shifts_[k], contact.of(s.w()) + (shifts_[k] == 0.0 ? 0.0 : acceleration * shifts_[k])};
  });
  if (t == last_change_.first && i != last_change_.second && contacts_.collides()) {
    std::vector<double> answer(n, 0.0);
    answer[contact.unknown] = 1.0;
    if (contact.joint > 0) answer[contact.unknown - 1] = -1.0;
    system_.accelerate(answer);
    const double beside = std::abs(contacts_[last_change_.second].of(answer));
    if (beside > 1e-8 * std::abs(contact.of(answer))) {
      lose(t, "two contacts change at once, and what follows depends on which is first", y);
      changes.assign(changes.size(), {nothing, nothing});
      return changes;
    }
  }
  last_change_ = {t, i};
  if (!jumps(i, by_push)) return changes;
  if (graze && moves) {
    lose(since,
         fmt::format("a contact {} with an indicator that hardly moves, a graze: its time has no derivative",
                     contacts_.closed(i) ? "opens" : "closes"),
         y);
    return changes;
  }
  shift_to_change(at, i, y);
  return changes;
}

// The derivatives are those at the time of the change from here on, until after().
void Sensitivities::shift_to_change(const Moment& at, std::size_t i, std::span<double> y) {
  shifted_ = true;
  layout_->each_impulse([&](std::size_t e, std::size_t end) { blow_[e] = end_rows(contacts_, end, i); });
  find_reactions(at);
  each(y, [&](std::size_t k, Derivative& derivative, const Block& s) {
    book_bodies(derivative, at, s, 1.0, shifts_[k]);
    shift(s, old_velocity_, old_acceleration_, shifts_[k]);
    book_blow(derivative, at, s, -1.0);
  });
}

// An obstacle before a rigid body that another contact meets. Its force R jumps where any contact changes, and other
// rows may tell it from there on. p is the momentum of the rows that tell it, q that of the rows that a blow strikes.
// The impulse gains p' + R dt*/dp before the change and loses the same after it. Between the two it gains what q' grows
// by, from s- to s+.
void Sensitivities::find_reactions(const Moment& at) {
  for (const bool right : {false, true})
    if (const auto i = contact_of_body(contacts_, right))
      reactions_[right] = !contacts_.closed(*i) ? 0.0
                          : contacts_[*i].holds
                              ? holding_force(system_, *i, at.t, at.u, at.w)
                              : contacts_[*i].law.force(contacts_.clearance(*i, at.u), contacts_[*i].of(at.w));
}

void Sensitivities::book_bodies(Derivative& derivative, const Moment& at, const Block& s, double times,
                                double shift) const {
  layout_->each_impulse([&](std::size_t e, std::size_t end) {
    const EndRows rows = end_rows(contacts_, end);
    if (!rows.of_body) return;
    const double reaction = reactions_[system_.bar().unknowns().is_right(end)];
    s.impulses()[e] += times * (derivative.momentum(end, rows, at, s.u(), s.w()) + reaction * shift);
  });
}

void Sensitivities::book_blow(Derivative& derivative, const Moment& at, const Block& s, double times) const {
  layout_->each_impulse([&](std::size_t e, std::size_t end) {
    if (blow_[e].of_body) s.impulses()[e] += times * derivative.momentum(end, blow_[e], at, s.u(), s.w());
  });
}

void Sensitivities::rebound(std::size_t i, std::vector<ChangeSensitivity>& changes) const {
  if (lost()) return;
  for (std::size_t k = 0; k < changes.size(); ++k)
    changes[k].velocity =
        -restitution_ * changes[k].velocity - directions_[k].restitution * contacts_[i].of(old_velocity_);
}

void Sensitivities::after(double t, std::size_t i, std::span<double> y) {
  if (lost()) return;
  const Contact& contact = contacts_[i];
  const std::size_t n = layout_->nodes, node = contact.unknown;
  const Moment at = look_at(t, y);
  const double came = contact.of(old_velocity_), goes = contact.of(w_);
  // A node that is released may get its velocity from the mesh.
  const bool struck = shifted_ && contacts_[i].collides && came != 0.0 && goes != came;
  const auto leave_with = [&](const Block& s, double velocity) {
    s[n + node] = contact.joint > 0 ? s[n + node - 1] + velocity : velocity;
  };
  const bool rebounds = struck && !contacts_.closed(i);
  if (shifted_) find_reactions(at);
  each(y, [&](std::size_t k, Derivative& derivative, const Block& s) {
    if (struck) {
      // v+ - v- goes along (rho M)^{-1} d, d.v the velocity of the contact: in parts that change by -(rho M)^{-1}
      // (rho M)' (v+ - v-), d.v left out.
      const double left = contact.of(s.w());
      const double reflected = rebounds ? -restitution_ * left - directions_[k].restitution * came : 0.0;
      double share = (reflected - left) / (goes - came);
      for (std::size_t j = 0; j < n; ++j) load_rate_[j] = w_[j] - old_velocity_[j];
      if (derivative.multiply_inertia(load_rate_, parted_)) {
        system_.accelerate(parted_);
        share += contact.of(parted_) / (goes - came);
        for (std::size_t j = 0; j < n; ++j) s[n + j] -= parted_[j];
      }
      for (std::size_t j = 0; j < n; ++j) s[n + j] += share * (w_[j] - old_velocity_[j]);
      leave_with(s, reflected);
    }
    if (contacts_.closed(i) && contacts_[i].holds) {
      derivative.motion().contacts().place(i, s.u());
      leave_with(s, 0.0);
    }
    if (shifted_) {
      book_blow(derivative, at, s, 1.0);
      shift(s, w_, acceleration_, -shifts_[k]);
    }
    complete(derivative, at, s);
    if (shifted_) book_bodies(derivative, at, s, -1.0, shifts_[k]);
  });
  shifted_ = false;
}

// dt*/dp of a break at t, as the contact has it. The obstacle is where it is before and after a kink of its own: there
// gap_p + gap' dt*/dp does not jump. Every other break is at a time of the scene.
double Sensitivities::break_rate(std::size_t k, double t, double end, const Contact& contact) const {
  const double moved = pointers_[k]->data().frame().gap_jump(contact, t, end);
  if (moved == 0.0 || system_.bar().frame().gap_jump(contact, t, end) != 0.0) return 0.0;
  const double bend = system_.bar().frame().gap_jump(contact, t, end, 1);
  return bend == 0.0 ? 0.0 : -moved / bend;
}

std::vector<ChangeSensitivity> Sensitivities::at_break(double t, double end, std::size_t i, std::span<double> y) {
  std::vector<ChangeSensitivity> changes(pointers_.size(), {nothing, nothing});
  shifted_ = false;
  if (lost() && *account_->lost < t) return changes;
  bool moves = false;
  for (std::size_t k = 0; k < changes.size(); ++k) {
    changes[k].time = shifts_[k] = break_rate(k, t, end, contacts_[i]);
    moves |= shifts_[k] != 0.0;
  }
  if (lost()) return changes;
  const Moment at = look_at(t, y);
  old_velocity_ = w_;
  old_acceleration_ = acceleration_;
  each(y, [&](std::size_t k, Derivative& derivative, const Block& s) {
    complete(derivative, at, s);
    // A node without mass has a velocity that jumps as its row does.
    if (!contacts_[i].massless || (shifts_[k] == 0.0 && !contacts_.closed(i)))
      changes[k].velocity = contacts_[i].of(s.w()) + contacts_[i].of(old_acceleration_) * shifts_[k];
  });
  if (moves) shift_to_change(at, i, y);
  return changes;
}

// To a time later by that, at the rate (v, a).
void Sensitivities::shift(const Block& s, std::span<const double> v, std::span<const double> a, double time) {
  for (std::size_t j = 0; j < s.nodes; ++j) s.u()[j] += v[j] * time;
  for (std::size_t j = 0; j < s.nodes; ++j) s.w()[j] += a[j] * time;
}

void Sensitivities::add_frame(double t, std::size_t i, std::vector<ChangeSensitivity>& changes) const {
  const BarSystem& bar = system_.bar();
  if (!bar.frame().moving()) return;
  const Contact& contact = contacts_[i];
  const double acceleration = bar.frame().lift_at(contact, system_.load().lift(t, 2));
  for (std::size_t k = 0; k < changes.size(); ++k)
    changes[k].velocity +=
        acceleration * changes[k].time + bar.frame().lift_at(contact, pointers_[k]->motion().load().lift(t, 1));
}

}  // namespace viscobar

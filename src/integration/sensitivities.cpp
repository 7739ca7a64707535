#include "integration/sensitivities.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>
#include <utility>
#include <vector>

#include "dynamics/contact_forces.hpp"
#include "dynamics/contact_rows.hpp"
#include "dynamics/indicator.hpp"
#include "viscobar/dynamics/load_error.hpp"

namespace viscobar {

namespace {

constexpr double nothing = std::numeric_limits<double>::quiet_NaN();

// Nothing of the scene depends on time but its load.
Direction still(const Direction& of) {
  Direction direction;
  Scene& data = direction.data = of.data;
  data.displacement = data.velocity = [](double) { return 0.0; };
  data.displacement_places = data.velocity_places = {};
  data.left_input = data.right_input = {};
  data.load.reset(), data.side.reset();
  for (Obstacle* obstacle :
       {std::get_if<Obstacle>(&data.left), std::get_if<Obstacle>(&data.right), data.span ? &*data.span : nullptr})
    if (obstacle) obstacle->gap = 0.0;
  for (Member& member : data.chain) member.joint.gap = 0.0, member.displacement = member.velocity = data.velocity;
  direction.members.resize(data.chain.size(), Member{.bar = {0.0, 0.0, 0.0, 0.0}});
  return direction;
}

}  // namespace

Sensitivities::Sensitivities(PenalisedSystem& system, const Penalty& penalty, std::span<const Direction> directions)
    : system_(system),
      contacts_(system.contacts()),
      directions_(directions),
      restitution_(penalty.restitution),
      time_direction_(still(directions.front())),
      time_(system, penalty, time_direction_),
      w_(system.size()),
      acceleration_(system.size()),
      load_rate_(system.size()),
      parted_(system.size()),
      shifts_(directions.size()),
      jumps_(directions.size(), {std::vector<double>(system.size()), std::vector<double>(system.size())}) {
  for (const Direction& direction : directions_) pointers_.push_back(&all_.emplace_back(system_, penalty, direction));
  const std::size_t nodes = system.bar().mesh().nodes();
  fields_.assign(directions.size(), {std::vector<double>(nodes), std::vector<double>(nodes)});
  time_.motion().load().add(load_rate_, {});
}

void Sensitivities::attach(const Layout& layout, SensitivityAccount& account, const ErrorWeights& weights) {
  layout_ = &layout, account_ = &account, weights_ = &weights;
  for (auto* of_account : {&account.impulse_left, &account.impulse_right, &account.energy})
    of_account->resize(directions_.size(), nothing);
}

void Sensitivities::begin(double t, double end, std::span<double> y) {
  const Moment at = look_at(t, y);
  each(y, [&](std::size_t, Derivative& derivative, const Block& s) {
    const State initial = derivative.initial_state(t);
    std::ranges::copy(initial.u, s.u().begin());
    std::ranges::copy(initial.v, s.w().begin());
    derivative.motion().load().begin_leg(t, end);
    complete(derivative, at, s);
    book_momentum(derivative, at, s, -1.0);
  });
}

void Sensitivities::begin_leg(double t, double end, std::span<double> y) {
  const Moment at = look_at(t, y);
  each(y, [&](std::size_t, Derivative& derivative, const Block& s) {
    derivative.motion().load().begin_leg(t, end);
    derivative.take_contacts();
    if (!lost()) complete(derivative, at, s);
  });
}

// With the bar's own acceleration there.
Moment Sensitivities::look_at(double t, std::span<double> y) {
  const std::span<const double> u = layout_->u(y);
  std::ranges::copy(layout_->w(y), w_.begin());
  system_.complete_velocity(t, u, w_);
  system_.acceleration(t, u, w_, acceleration_);
  return {t, u, w_, acceleration_};
}

void Sensitivities::complete(Derivative& derivative, const Moment& at, const Block& s) {
  derivative.take_contacts();
  derivative.drive(at);
  derivative.motion().complete_displacement(at.t, s.u());
  derivative.motion().complete_velocity(at.t, s.u(), s.w());
}

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
  shifted_ = true;
  each(y, [&](std::size_t k, Derivative&, const Block& s) { shift(s, old_velocity_, old_acceleration_, shifts_[k]); });
  return changes;
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
    if (shifted_) shift(s, w_, acceleration_, -shifts_[k]);
    complete(derivative, at, s);
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
    shift(s, old_velocity_, old_acceleration_, shifts_[k]);
    // A node without mass has a velocity that jumps as its row does.
    if (!contacts_[i].massless || (shifts_[k] == 0.0 && !contacts_.closed(i)))
      changes[k].velocity = contacts_[i].of(s.w());
  });
  shifted_ = moves;
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

// Where the state jumps without an obstacle, that is none of its impulse.
void Sensitivities::book_momentum(Derivative& derivative, const Moment& at, const Block& s, double times) const {
  layout_->each_impulse(
      [&](std::size_t e, std::size_t node) { s.impulses()[e] += times * derivative.momentum(node, at, s.u(), s.w()); });
}

void Sensitivities::book_momentum(double t, double times, std::span<double> y) {
  if (lost() || !(layout_->left || layout_->right)) return;
  const Moment at = look_at(t, y);
  each(y, [&](std::size_t, Derivative& derivative, const Block& s) { book_momentum(derivative, at, s, times); });
}

void Sensitivities::cross_frames(double t, double times, std::span<double> y) {
  if (lost()) return;
  const Moment at = look_at(t, y);
  each(y, [&](std::size_t, Derivative& derivative, const Block& s) {
    complete(derivative, at, s);
    book_momentum(derivative, at, s, times);
  });
}

void Sensitivities::leave_frame(double t, double after, std::span<double> y) {
  cross_frames(t, 1.0, y);
  each(y, [&](std::size_t, Derivative& derivative, const Block& s) {
    const BarSystem& data = derivative.data();
    if (!lost()) data.frame().change(data.following().frame(), after, s.u(), s.w());
  });
}

void Sensitivities::pass_jumps(JumpFilter& filter, std::span<double> y) {
  if (!filter.has_shifted() || lost()) return;
  each(y, [&](std::size_t k, Derivative& derivative, const Block& s) {
    filter.differentiate(derivative, jumps_[k].first, jumps_[k].second, s.u(), s.w());
  });
}

void Sensitivities::pass_kink(double t, double end, const FrameJump* of_bar, std::span<double> y) {
  if (lost()) return;
  const bool kinks = of_bar && (of_bar->velocity.left != 0.0 || of_bar->velocity.right != 0.0);
  for (std::size_t i = 0; i < contacts_.size() && kinks; ++i)
    if (contacts_.holds_mass(i))
      return lose(t, "the motion of an end has a kink, and a rigid contact that is closed an impact or an end", y);
  for (std::size_t k = 0; k < pointers_.size(); ++k) {
    Derivative& derivative = *pointers_[k];
    if (!derivative.data().frame().moving()) continue;
    derivative.motion().load().begin_leg(t, end);
    const Block s = layout_->derivative(y, k);
    try {
      const auto jump = derivative.data().frame().kink(t, end);
      if (!jump) continue;
      const Moment at = look_at(t, y);
      complete(derivative, at, s);
      book_momentum(derivative, at, s, 1.0);
      derivative.data().frame().pass_kink(*jump, s.u(), s.w());
      book_momentum(derivative, at, s, -1.0);
      if (kinks && !of_bar->displaces()) strike_by_kink(*of_bar, *jump, at, s);
    } catch (const LoadError&) {
      return lose(t, fmt::format("the motion of an end has a kink whose time moves with {}", directions_[k].key), y);
    }
  }
}

// Where the velocity of an obstacle jumps, so does the force of its dashpot, or of the row of a node without mass that
// it holds. If the time of that moves, the derivative of the obstacle jumps, and drags at them with an impulse.
void Sensitivities::strike_by_kink(const FrameJump& of_bar, const FrameJump& moved, const Moment& at, const Block& s) {
  const BarSystem& bar = system_.bar();
  std::vector<double> impulse(s.nodes, 0.0);
  for (std::size_t i = 0; i < contacts_.size(); ++i) {
    const Contact& contact = contacts_[i];
    const std::size_t node = contact.unknown;
    const double by = bar.frame().lift_at(contact, moved.displacement),
                 faster = bar.frame().lift_at(contact, of_bar.velocity);
    if (!contacts_.closed(i) || by == 0.0 || faster == 0.0) continue;
    const double clearance = contacts_.clearance(i, at.u), w = contact.of(at.w);
    if (!contacts_[i].massless)
      impulse[node] +=
          (contacts_[i].law.force(clearance, w - faster) - contacts_[i].law.force(clearance, w)) * by / faster;
    else if (contacts_[i].holds)
      impulse[neighbour(node)] += bar.bar().viscosity / bar.elements().stretch_beside(node) * by;
  }
  system_.accelerate(impulse);
  for (std::size_t j = 0; j < s.nodes; ++j) s.w()[j] += impulse[j];
}

void Sensitivities::lose(double t, std::string why, std::span<double> y) {
  if (!lost()) account_->lost = t, account_->why = std::move(why);
  // The derivatives that are advanced from here on are not told.
  for (std::size_t k = 0; k < pointers_.size(); ++k) std::ranges::fill(layout_->derivative(y, k), 0.0);
}

std::span<const FieldSensitivity> Sensitivities::fields(double t, std::span<double> y, const Snapshot& snapshot) {
  told_.clear();
  if (lost()) {
    for (Field& field : fields_) {
      std::ranges::fill(field.u, nothing);
      std::ranges::fill(field.v, nothing);
      told_.push_back(
          {field.u, field.v, nothing, nothing, std::vector<double>(system_.bar().elements().joints().size(), nothing)});
    }
    return told_;
  }
  const BarSystem& bar = system_.bar();
  const Moment at = look_at(t, y);
  // Accelerations at all nodes, where an end is fixed.
  std::vector<double> own(bar.unknowns().left_fixed() || bar.unknowns().right_fixed() ? snapshot.u.size() : 0),
      of_own(own);
  if (!own.empty()) system_.expand_acceleration(t, layout_->u(y), w_, own);
  for (std::size_t k = 0; k < pointers_.size(); ++k) {
    Derivative& derivative = *pointers_[k];
    const Block s = layout_->derivative(y, k);
    complete(derivative, at, s);
    Field& field = fields_[k];
    derivative.expand(t, s.u(), s.w(), field.u, field.v);
    FieldSensitivity told{field.u, field.v, 0.0, 0.0, derivative.joint_forces(at, s.u(), s.w())};
    for (std::size_t i = 0; i < contacts_.size(); ++i) {
      if (!contacts_.closed(i) || contacts_[i].joint > 0) continue;
      const std::size_t node = contacts_[i].unknown;
      const double reaction = derivative.reaction(i, at, s.u(), s.w());
      if (!bar.unknowns().left_fixed() && node == 0) told.reaction_left += reaction;
      if (!bar.unknowns().right_fixed() && node + 1 == s.nodes) told.reaction_right += reaction;
    }
    if (!own.empty()) {
      derivative.motion().expand_acceleration(t, s.u(), s.w(), of_own);
      const auto force = [&](bool right) {
        return derivative.holding_force(right, t, {snapshot.u, snapshot.v, own}, {field.u, field.v, of_own});
      };
      if (bar.unknowns().left_fixed()) told.reaction_left = force(false);
      if (bar.unknowns().right_fixed()) told.reaction_right = force(true);
    }
    told_.push_back(told);
  }
  return told_;
}

void Sensitivities::sum_up(double t, std::span<double> y) {
  const Moment at = look_at(t, y);
  for (std::size_t k = 0; k < pointers_.size(); ++k) {
    std::array<double, 2> impulses = {nothing, nothing};
    double energy = nothing;
    if (!lost()) {
      Derivative& derivative = *pointers_[k];
      const Block s = layout_->derivative(y, k);
      complete(derivative, at, s);
      layout_->each_impulse([&](std::size_t e, std::size_t node) {
        impulses[layout_->left ? e : 1] = s.impulses()[e] + derivative.momentum(node, at, s.u(), s.w());
      });
      energy = derivative.energy(at, s.u(), s.w());
    }
    account_->impulse_left[k] = impulses[0];
    account_->impulse_right[k] = impulses[1];
    account_->energy[k] = energy;
  }
}

}  // namespace viscobar

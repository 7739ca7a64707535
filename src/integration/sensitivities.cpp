#include "integration/sensitivities.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <span>
#include <utility>
#include <vector>

#include "dynamics/contact_rows.hpp"
#include "viscobar/dynamics/load_error.hpp"

namespace viscobar {

namespace {

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

// Where the state jumps without an obstacle, that is none of its impulse.
void Sensitivities::book_momentum(Derivative& derivative, const Moment& at, const Block& s, double times) const {
  layout_->each_impulse([&](std::size_t e, std::size_t node) {
    s.impulses()[e] += times * derivative.momentum(node, end_rows(contacts_, node), at, s.u(), s.w());
  });
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
        impulses[layout_->left ? e : 1] =
            s.impulses()[e] + derivative.momentum(node, end_rows(contacts_, node), at, s.u(), s.w());
      });
      energy = derivative.energy(at, s.u(), s.w());
    }
    account_->impulse_left[k] = impulses[0];
    account_->impulse_right[k] = impulses[1];
    account_->energy[k] = energy;
  }
}

}  // namespace viscobar

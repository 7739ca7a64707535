#include "schemes/step_reactions.hpp"

#include <algorithm>

namespace viscobar {

namespace {

EndAccount& of(bool right, RunAccount& account) { return right ? account.right : account.left; }

}  // namespace

StepReactions::StepReactions(const BarSystem& system, const TimeStep& step, std::span<const double> times, double dt,
                             std::size_t steps)
    : system_(system), step_(step), begin_(times.front()), end_(times.back()), dt_(dt), steps_(steps) {
  const auto& contacts = step.contacts();
  spanned_ = std::ranges::any_of(contacts, [](const Contact& one) { return one.where == Where::span; });
  for (const bool right : {false, true}) {
    const std::optional<double>& wall = system.unknowns().wall(right);
    const std::size_t i = system.unknowns().end(right);
    if (!wall || system.frame().moving())
      watched_.push_back({right, wall ? &*wall : &step.u()[i], wall ? nullptr : &step.p()[i]});
    if (wall) continue;
    const auto begin = std::ranges::lower_bound(contacts, i, {}, &Contact::unknown),
               end = std::ranges::upper_bound(contacts, i, {}, &Contact::unknown);
    // A rigid body there may be the right side of a joint as well.
    const auto of_joint = [](const Contact& contact) { return contact.joint > 0; };
    const auto first = std::find_if_not(begin, end, of_joint);
    at_end_[right] = {first - contacts.begin(), std::find_if(first, end, of_joint) - contacts.begin()};
  }
}

void StepReactions::begin(const State& start, RunAccount& account) const {
  for (const bool right : {false, true}) {
    EndAccount& end = of(right, account);
    const std::size_t i = system_.unknowns().end(right);
    end.displacement = system_.unknowns().wall(right)  ? *system_.unknowns().wall(right)
                       : system_.inertia().massless(i) ? step_.u()[i] - dt_ * step_.p()[i]
                                                       : start.u[i];
    end.lowest = end.highest = end.displacement;
    each_contact_at(right, [&](std::size_t k) {
      end.impulse += sign(k) * step_.start_impulse()[k];
      end.peak_reaction = std::max(end.peak_reaction, end.latest.raise(sign(k) * step_.reaction_before()[k], begin_));
    });
    if (end.peak_reaction > 0.0) end.contact.close(begin_);
  }
  for (std::size_t k = 0; k < step_.contacts().size(); ++k) {
    const std::size_t number = step_.contacts()[k].joint;
    if (number == 0) continue;
    account.joints.resize(std::max(account.joints.size(), number));
    ContactAccount& joint = account.joints[number - 1];
    joint.impulse = step_.start_impulse()[k];
    joint.peak_reaction = joint.latest.raise(step_.reaction_before()[k], begin_);
  }
  account.span.impulse = span_sum(step_.start_impulse());
  account.span.peak_reaction = account.span.latest.raise(span_sum(step_.reaction_before()), begin_);
}

void StepReactions::pass(std::size_t n, RunAccount& account) const {
  const double theta = n < steps_ ? 1.0 : std::min((end_ - time(n - 1)) / dt_, 1.0);
  const double until = std::min(time(n), end_);
  const double *now = step_.reaction().data(), *then = step_.reaction_before().data();
  for (const WatchedEnd& watched : watched_) {
    EndAccount& end = of(watched.right, account);
    double displacement = *watched.u;
    if (theta < 1.0 && watched.p) displacement -= (1.0 - theta) * dt_ * *watched.p;
    if (system_.frame().moving()) displacement += system_.frame().lift(until, 0).of(watched.right);
    end.displacement = displacement;
    if (displacement < end.lowest) end.lowest = displacement;
    if (displacement > end.highest) end.highest = displacement;
    each_contact_at(watched.right, [&](std::size_t k) {
      if (now[k] == 0.0 && then[k] == 0.0) return;
      const double before = n > 1 ? (1.0 - theta / 2) * then[k] : 0.0;
      end.impulse += sign(k) * (dt_ * theta * (before + theta / 2 * now[k]));
      end.peak_reaction = std::max(end.peak_reaction, end.latest.raise(sign(k) * of_contact(k, theta), until));
    });
  }
  if (!step_.pushed()) return;
  for (std::size_t k = 0; k < step_.contacts().size(); ++k) {
    const std::size_t number = step_.contacts()[k].joint;
    if (number == 0 || (now[k] == 0.0 && then[k] == 0.0)) continue;
    ContactAccount& joint = account.joints[number - 1];
    joint.impulse += dt_ * theta * ((n > 1 ? (1.0 - theta / 2) * then[k] : 0.0) + theta / 2 * now[k]);
    joint.peak_reaction = std::max(joint.peak_reaction, joint.latest.raise(of_contact(k, theta), until));
  }
  if (!spanned_) return;
  const double before = span_sum(step_.reaction_before()), after = span_sum(step_.reaction());
  SpanAccount& span = account.span;
  span.impulse += dt_ * theta * ((n > 1 ? (1.0 - theta / 2) * before : 0.0) + theta / 2 * after);
  span.peak_reaction = std::max(span.peak_reaction, span.latest.raise((1.0 - theta) * before + theta * after, until));
}

void StepReactions::close(std::size_t k, double t, Event& event, RunAccount& account) const {
  const bool of_span = event.where == Where::span;
  const double now = of_span ? span_sum(step_.reaction()) : sign(k) * step_.reaction()[k];
  ContactAccount& place = account.of(event);
  place.latest.raise(now, t);
  if (event.impulse) *event.impulse = place.closings == 1 ? 0.0 : *event.impulse - dt_ / 2 * now;
}

double StepReactions::of_end(bool right, double theta) const {
  double sum = 0.0;
  each_contact_at(right, [&](std::size_t k) { sum += sign(k) * of_contact(k, theta); });
  return sum;
}

double StepReactions::span_sum(std::span<const double> values) const {
  double sum = 0.0;
  for (std::size_t k = 0; k < values.size(); ++k)
    if (step_.contacts()[k].where == Where::span) sum += sign(k) * values[k];
  return sum;
}

}  // namespace viscobar

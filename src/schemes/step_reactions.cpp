#include "schemes/step_reactions.hpp"

#include <algorithm>

namespace viscobar {

StepReactions::StepReactions(const BarSystem& system, const TimeStep& step, std::span<const double> times, double dt,
                             std::size_t steps)
    : system_(system), step_(step), begin_(times.front()), end_(times.back()), dt_(dt), steps_(steps) {
  const auto& contacts = step.contacts();
  for (const bool right : {false, true}) {
    const std::optional<double>& wall = system.unknowns().wall(right);
    const std::size_t i = system.unknowns().end(right);
    if (!wall || system.frame().moving())
      watched_.push_back({right, wall ? &*wall : &step.u()[i], wall ? nullptr : &step.p()[i]});
    Force& force = forces_.emplace_back(Force{right ? Where::right : Where::left, 0, 0});
    if (wall) continue;
    const auto found = std::ranges::equal_range(contacts, i, {}, &Contact::unknown);
    // A rigid body there may be the right side of a joint as well.
    const auto of_joint = [](const Contact& contact) { return contact.joint > 0; };
    const auto first = std::find_if_not(found.begin(), found.end(), of_joint);
    force.first = static_cast<std::size_t>(first - contacts.begin());
    force.last = static_cast<std::size_t>(std::find_if(first, found.end(), of_joint) - contacts.begin());
  }
  const bool spans = std::ranges::any_of(contacts, [](const Contact& one) { return one.where == Where::span; });
  forces_.push_back({Where::span, 0, spans ? contacts.size() : 0});
  for (std::size_t k = 0; k < contacts.size(); ++k)
    if (contacts[k].joint > 0) forces_.push_back({Where::joint, k, k + 1});
}

double StepReactions::sum(const Force& force, std::span<const double> values) const {
  double sum = 0.0;
  for (std::size_t k = force.first; k < force.last; ++k)
    if (const Contact& one = step_.contacts()[k]; force.where != Where::span || one.where == Where::span)
      sum += one.sign * values[k];
  return sum;
}

ContactAccount& StepReactions::account_of(const Force& force, RunAccount& account) const {
  switch (force.where) {
    case Where::left: return account.left;
    case Where::right: return account.right;
    case Where::span: return account.span;
    case Where::joint: break;
  }
  return account.joints[step_.contacts()[force.first].joint - 1];
}

void StepReactions::begin(const State& start, RunAccount& account) const {
  for (const Contact& contact : step_.contacts()) account.joints.resize(std::max(account.joints.size(), contact.joint));
  for (const Force& force : forces_) {
    ContactAccount& of = account_of(force, account);
    of.impulse = sum(force, step_.start_impulse());
    of.peak_reaction = of.latest.raise(sum(force, step_.reaction_before()), begin_);
  }
  for (const bool right : {false, true}) {
    EndAccount& end = right ? account.right : account.left;
    const std::size_t i = system_.unknowns().end(right);
    end.displacement = system_.unknowns().wall(right)  ? *system_.unknowns().wall(right)
                       : system_.inertia().massless(i) ? step_.u()[i] - dt_ * step_.p()[i]
                                                       : start.u[i];
    end.lowest = end.highest = end.displacement;
    if (end.peak_reaction > 0.0) end.contact.close(begin_);
  }
}

void StepReactions::pass(std::size_t n, RunAccount& account) const {
  const double theta = n < steps_ ? 1.0 : std::min((end_ - time(n - 1)) / dt_, 1.0);
  const double until = std::min(time(n), end_);
  for (const WatchedEnd& watched : watched_) {
    EndAccount& end = watched.right ? account.right : account.left;
    double displacement = *watched.u;
    if (theta < 1.0 && watched.p) displacement -= (1.0 - theta) * dt_ * *watched.p;
    if (system_.frame().moving()) displacement += system_.frame().lift(until, 0).of(watched.right);
    end.displacement = displacement;
    if (displacement < end.lowest) end.lowest = displacement;
    if (displacement > end.highest) end.highest = displacement;
  }
  for (const Force& force : forces_) {
    const double now = sum(force, step_.reaction()), then = sum(force, step_.reaction_before());
    if (now == 0.0 && then == 0.0) continue;
    ContactAccount& of = account_of(force, account);
    of.impulse += dt_ * theta * ((n > 1 ? (1.0 - theta / 2) * then : 0.0) + theta / 2 * now);
    of.peak_reaction = std::max(of.peak_reaction, of.latest.raise((1.0 - theta) * then + theta * now, until));
  }
}

void StepReactions::close(std::size_t k, double t, Event& event, RunAccount& account) const {
  const Contact& contact = step_.contacts()[k];
  const double now = contact.sign * step_.reaction()[k];
  ContactAccount& of = account.of(event);
  of.latest.raise(contact.where == Where::span ? of_span(1.0) : now, t);
  if (contact.at_end()) *event.impulse = of.closings == 1 ? 0.0 : *event.impulse - dt_ / 2 * now;
}

}  // namespace viscobar

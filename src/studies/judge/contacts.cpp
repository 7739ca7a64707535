#include "studies/judge/contacts.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "studies/compare/matching.hpp"
#include "studies/touch.hpp"
#include "viscobar/studies/compare/difference.hpp"
#include "viscobar/studies/fit/fit.hpp"

namespace viscobar {

namespace {

using Periods = std::vector<ContactPeriod>;

// In so many samples one at least shows a contact that chatters, if it is closed half of the time: 2^-10 do not.
constexpr std::ptrdiff_t enough_samples = 10;

// A place where the bar may touch: contacts of both there, and their distances from the obstacle at their times, empty
// where they are not known.
struct Spot {
  JudgedContact at;
  Periods own = {}, coarser = {}, theirs = {};
  std::vector<double> own_clearance = {}, their_clearance = {};
};

// Times from `begin` to `end` in which a node of the obstacle, or the joint, is in contact, flights shorter than
// `merge` left out.
Periods periods_of(std::span<const Event> all, Where where, std::size_t joint, double begin, double end, double merge) {
  const auto until = std::ranges::upper_bound(all, end, {}, &Event::time);
  const std::vector<const Event*> changes = changes_at({all.begin(), until}, where, joint);
  const auto close = [&](const Touch& one, const Touch& next) { return next.begin() - one.end(end) < merge; };
  Periods periods;
  for (const Touch& touch : touches(changes, close))
    if (touch.end(end) >= begin) periods.push_back({.begin = std::max(begin, touch.begin()), .end = touch.end(end)});
  return periods;
}

// The same of samples: where values are at most `most`, those that are none left out.
Periods periods_of(const std::vector<double>& times, const std::vector<double>& values, double most) {
  Periods periods;
  bool closed = false;
  for (std::size_t k = 0; k < times.size(); ++k) {
    if (!std::isfinite(values[k])) continue;
    const bool now = values[k] <= most;
    if (now && !closed) periods.push_back({.begin = times[k]});
    if (now) periods.back().end = times[k];
    closed = now;
  }
  return periods;
}

// Makes one of neighbours that meet the same one of `whole`, to a time that is no flight, and no other.
Periods joined(const Periods& parts, const Periods& whole, double near) {
  Periods all;
  std::vector<std::size_t> last;
  for (const ContactPeriod& part : parts) {
    std::vector<std::size_t> met;
    for (std::size_t k = 0; k < whole.size(); ++k)
      if (whole[k].begin <= part.end + near && part.begin <= whole[k].end + near) met.push_back(k);
    if (met.size() == 1 && met == last)
      all.back().end = part.end, all.back().bounces += part.bounces;
    else
      all.push_back(part);
    last = met;
  }
  return all;
}

std::vector<Match> matched(const Periods& one, const Periods& other, double duration) {
  const auto begins = [](const Periods& all) {
    std::vector<double> times;
    for (const ContactPeriod& period : all) times.push_back(period.begin);
    return times;
  };
  const double reach = 2.0 * duration / static_cast<double>(std::max({one.size(), other.size(), std::size_t{1}}));
  return match_times(begins(one), begins(other), reach);
}

// How theirs are seen.
struct Sight {
  const std::vector<double>& times;
  double begin, end;
  double sample;  // 0: by changes
  double near;    // times apart that are one
  double touch;
};

// True if theirs may have a contact of ours between its samples: there are few of them, and its end is nowhere further
// off than it goes from one sample to the next.
bool may_hide(const ContactPeriod& own, const Spot& spot, const Sight& sight) {
  const std::vector<double>&t = sight.times, &clearance = spot.their_clearance;
  if (sight.sample == 0.0 ||
      std::ranges::upper_bound(t, own.end) - std::ranges::lower_bound(t, own.begin) > enough_samples)
    return false;
  double step = 0.0;
  for (const std::vector<double>* of : {&clearance, &spot.own_clearance})
    for (std::size_t k = 1; k < of->size(); ++k) step = std::fmax(step, std::abs((*of)[k] - (*of)[k - 1]));
  bool near = clearance.empty();
  for (std::size_t k = 1; k < clearance.size(); ++k)
    if (t[k] >= own.begin && t[k - 1] <= own.end)
      near = near || !(clearance[k] + clearance[k - 1] > step + 2.0 * sight.touch);
  return near;
}

// True if ours is at the obstacle, to its own error, where theirs has a contact.
bool grazes(const ContactPeriod& theirs, const Spot& spot, const Sight& sight) {
  for (std::size_t k = 0; k < spot.own_clearance.size(); ++k)
    if (sight.times[k] >= theirs.begin - sight.sample && sight.times[k] <= theirs.end + sight.sample &&
        spot.own_clearance[k] <= sight.touch)
      return true;
  return false;
}

void judge_spot(std::vector<JudgedContact>& all, const Spot& spot, const Sight& sight) {
  const double duration = sight.end - sight.begin;
  const Periods theirs = joined(spot.theirs, spot.own, sight.near), own = joined(spot.own, theirs, sight.near);
  std::vector<JudgedContact> contacts(own.size(), spot.at);
  for (std::size_t i = 0; i < own.size(); ++i)
    contacts[i].begin = own[i].begin, contacts[i].end = own[i].end, contacts[i].parts = own[i].bounces;
  for (const Match& pair : matched(own, spot.coarser, duration)) {
    const ContactPeriod &one = own[pair.first], &other = spot.coarser[pair.other];
    contacts[pair.first].own_error = std::max(std::abs(one.begin - other.begin), std::abs(one.end - other.end));
  }
  std::vector<JudgedContact*> owner(theirs.size(), nullptr);
  for (const Match& pair : matched(own, theirs, duration)) owner[pair.other] = &contacts[pair.first];
  std::vector<JudgedContact> further;
  further.reserve(theirs.size());
  for (std::size_t j = 0; j < theirs.size(); ++j) {
    JudgedContact& contact = owner[j] ? *owner[j] : further.emplace_back(spot.at);
    contact.their_begin = theirs[j].begin, contact.their_end = theirs[j].end, contact.their_parts = theirs[j].bounces;
    if (!owner[j]) contact.verdict = grazes(theirs[j], spot, sight) ? ContactVerdict::untold : ContactVerdict::made_up;
  }
  double delay = 0.0;  // of the contact before
  for (std::size_t i = 0; i < own.size(); ++i) {
    const bool behind = own[i].begin + delay > sight.end - sight.sample;
    if (!contacts[i].their_begin)
      contacts[i].verdict = behind || may_hide(own[i], spot, sight) ? ContactVerdict::untold : ContactVerdict::missed;
    delay = contacts[i].delay().value_or(delay);
  }
  all.insert(all.end(), contacts.begin(), contacts.end());
  all.insert(all.end(), further.begin(), further.end());
}

}  // namespace

void judge_contacts(JudgedSolution& judged, const TheirSolution& theirs, const Case& run, const OwnContacts& ours) {
  const std::vector<double>& t = theirs.times;
  const double begin = t.empty() ? 0.0 : t.front(), end = t.empty() ? run.end : t.back();
  judged.sample = theirs.changes ? 0.0 : (end - begin) / static_cast<double>(t.size() - 1);
  // Shorter flights are no flights: of samples two do not see them, of changes they are bounces that die away.
  const double merge = theirs.changes ? 1e-3 * (end - begin) : 2.0 * judged.sample;
  const Sight sight{t, begin, end, judged.sample, theirs.changes ? merge : judged.sample, ours.touch};
  const auto spot_of = [&](Where where, std::size_t joint = 0) {
    Spot spot{.at = {.where = where}};
    if (joint > 0) spot.at.place = static_cast<double>(joint);
    const auto periods = [&](std::span<const Event> all) { return periods_of(all, where, joint, begin, end, merge); };
    spot.own = periods(ours.changes);
    spot.coarser = periods(ours.coarser);
    if (theirs.changes) spot.theirs = periods(*theirs.changes);
    return spot;
  };
  // Where their forces push, to a part of the largest.
  const auto pushing = [&](const std::vector<double>& forces) {
    std::vector<double> reached;  // -|R|
    double most = -1e9 * std::numeric_limits<double>::min();
    for (const double value : forces) reached.push_back(-std::abs(value)), most = std::fmin(most, reached.back());
    return periods_of(t, reached, 1e-9 * most);
  };
  const auto clearances = [&](const std::vector<double>& u, const Obstacle& obstacle, const EndInput& input) {
    std::vector<double> all;
    for (std::size_t k = 0; k < u.size(); ++k)
      all.push_back(-obstacle.depth(u[k] - (input.motion ? input.motion->displacement(t[k]) : 0.0)));
    return all;
  };
  for (const bool right : {false, true}) {
    const auto* obstacle = std::get_if<Obstacle>(right ? &run.scene.right : &run.scene.left);
    const auto *reaction = theirs.column(right ? "reaction_right" : "reaction_left"),
               *u = theirs.column(right ? "u_right" : "u_left");
    if (!obstacle || !(theirs.changes || reaction || u)) continue;
    const EndInput& input = right ? run.scene.right_input : run.scene.left_input;
    Spot spot = spot_of(right ? Where::right : Where::left);
    spot.own_clearance = clearances(ours.ends[right], *obstacle, input);
    if (u) spot.their_clearance = clearances(u->values, *obstacle, input);
    if (!theirs.changes && !reaction) spot.theirs = periods_of(t, spot.their_clearance, ours.touch);
    if (!theirs.changes && reaction) spot.theirs = pushing(reaction->values);
    judge_spot(judged.contacts, spot, sight);
  }
  for (std::size_t k = 1, at = 2; k < run.scene.chain.size(); ++k) {
    const Joint& joint = run.scene.chain[k - 1].joint;
    if (joint.kind != JointKind::contact) continue;
    const std::vector<double>&own_left = ours.ends[at], &own_right = ours.ends[at + 1];
    at += 2;
    const auto *force = theirs.column(fmt::format("force:{}", k)), *left = theirs.column(fmt::format("u_left:{}", k)),
               *right = theirs.column(fmt::format("u_right:{}", k));
    if (!(theirs.changes || force || (left && right))) continue;
    const auto clear = [&](const std::vector<double>& a, const std::vector<double>& b) {
      std::vector<double> all;
      for (std::size_t i = 0; i < a.size(); ++i) all.push_back(b[i] - a[i] + joint.gap);
      return all;
    };
    Spot spot = spot_of(Where::joint, k);
    spot.own_clearance = clear(own_left, own_right);
    if (left && right) spot.their_clearance = clear(left->values, right->values);
    if (!theirs.changes) spot.theirs = force ? pushing(force->values) : periods_of(t, spot.their_clearance, ours.touch);
    judge_spot(judged.contacts, spot, sight);
  }
  if (run.scene.span && theirs.changes) judge_spot(judged.contacts, spot_of(Where::span), sight);
  for (const JudgedColumn& column : judged.columns) {
    if (!run.scene.span || theirs.changes || column.jumps()) continue;
    const auto [of, place] = *trace_column(column.name);
    Spot spot{.at = {.where = Where::span, .place = of == TraceColumn::u_right ? run.scene.bar.length : place}};
    spot.own_clearance = clearances(column.ours, *run.scene.span, {});
    spot.their_clearance = clearances(column.theirs, *run.scene.span, {});
    spot.own = periods_of(t, spot.own_clearance, ours.touch);
    spot.theirs = periods_of(t, spot.their_clearance, ours.touch);
    judge_spot(judged.contacts, spot, sight);
  }
  std::ranges::stable_sort(judged.contacts, {},
                           [](const JudgedContact& one) { return one.begin.value_or(one.their_begin.value_or(0.0)); });
}

}  // namespace viscobar

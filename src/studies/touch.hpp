#pragma once

#include <cstddef>
#include <set>
#include <span>
#include <vector>

#include "viscobar/run/run.hpp"

namespace viscobar {

/// A time in contact at one place of a run, from a closing to an opening. The one is absent of a contact from the start
/// on, the other of one that goes on to the end.
struct Touch {
  const Event* closing = nullptr;
  const Event* opening = nullptr;
  std::size_t bounces = 1;  ///< contacts that were made one

  double begin() const { return closing ? closing->time : 0.0; }
  double end(double of_run) const { return opening ? opening->time : of_run; }
  /// Integral of the reaction, by what the changes tell of it and that of the whole run.
  double impulse(double of_run) const {
    return (opening ? opening->impulse.value_or(0.0) : of_run) - (closing ? closing->impulse.value_or(0.0) : 0.0);
  }
};

/// Contacts by the changes of one place, in order of time. Neighbours with joins(one, next) are one: the flight between
/// them counts for nothing.
std::vector<Touch> touches(const std::vector<const Event*>& changes, auto&& joins) {
  std::vector<Touch> all, joined;
  for (const Event* change : changes) {
    if (change->change == Change::closing || all.empty()) all.emplace_back();
    (change->change == Change::closing ? all.back().closing : all.back().opening) = change;
  }
  for (const Touch& next : all)
    if (joined.empty() || !joins(joined.back(), next))
      joined.push_back(next);
    else
      joined.back().opening = next.opening, joined.back().bounces += next.bounces;
  return joined;
}

/// The changes of an end, of a joint by its number, or of a span, which is in contact while any of its nodes is.
inline std::vector<const Event*> changes_at(std::span<const Event> all, Where where, std::size_t joint = 0) {
  std::vector<const Event*> changes;
  std::set<std::size_t> closed;
  for (const Event& event : all) {
    if (event.where != where || (joint > 0 && event.node != joint)) continue;
    const bool flew = closed.empty(), closes = event.change == Change::closing;
    if (closes)
      closed.insert(event.node);
    else
      closed.erase(event.node);
    if (closes ? flew : closed.empty()) changes.push_back(&event);
  }
  return changes;
}

}  // namespace viscobar

#include "results/contact_account.hpp"

#include <algorithm>

namespace viscobar {

void ContactAccount::add(double time, double reaction) {
  if (last_)
    impulse_ += 0.5 * (reaction + last_->reaction) * (time - last_->time);
  else if (reaction > 0.0 && !closed_since_)
    closed_since_ = time;
  last_ = {time, reaction};
  max_reaction_ = std::max(max_reaction_, reaction);
}

void ContactAccount::add(const Event& event) {
  if (event.change == Change::closing) {
    ++closings_;
    if (!closed_since_) closed_since_ = event.time;
  } else if (closed_since_) {
    duration_ += event.time - *closed_since_;
    intervals_.add({*closed_since_, event.time});
    closed_since_.reset();
  }
}

std::vector<plot::Interval> ContactAccount::intervals(double now) const {
  std::vector<plot::Interval> all = intervals_.intervals();
  if (closed_since_) all.push_back({*closed_since_, now});
  return all;
}

}  // namespace viscobar

#include <utility>

#include "characteristics/run.hpp"

namespace viscobar::characteristics {

void Run::merge_turns() {
  events_.clear();
  for (const Turn& turn : left_.turns()) events_.push_back({turn.s, Where::left, turn.change, turn.velocity});
  for (const Turn& turn : right_.turns()) events_.push_back({turn.s, Where::right, turn.change, turn.velocity});
  std::ranges::stable_sort(events_, {}, &Told::s);
  told_ = 0;
}

std::optional<PartEnd> Run::tell_passage() {
  told_ = std::exchange(skip_, 0);
  const double end = last() ? times_.back() : std::min(time_at(1.0), times_.back());
  if (k_ == 0 && next_output_ == 0) tell_events(times_.front());
  for (;;) {
    const bool output = next_output_ < times_.size() && times_[next_output_] <= end;
    double stop = output ? times_[next_output_] : end;
    if (const auto due = schedule_.next(); due && *due > t_ && *due < stop) stop = *due;
    const bool at_output = output && stop == times_[next_output_];
    tell_events_before(stop);
    if (at_output) tell_output();
    const bool advanced = stop > t_;
    t_ = stop;
    if (stop == end && !output) tell_events(std::numeric_limits<double>::infinity());
    if (advanced) {
      if (!telling_.progress(t_)) return reached();
      if (t_ < times_.back() && schedule_.due(t_)) return Checkpoint{t_, next_output_, reached(), archived(*this)};
    }
    if (!at_output && stop == end) {
      ++statistics_.steps;
      return std::nullopt;
    }
  }
}

void Run::tell_events_before(double t) {
  while (told_ < events_.size() && time_of(events_[told_]) < t) tell(events_[told_++]);
}

void Run::tell_events(double t) {
  while (told_ < events_.size() && time_of(events_[told_]) <= t) tell(events_[told_++]);
}

void Run::tell(const Told& event) {
  ++statistics_.events;
  if (!observers_.event && !statistics_.account) return;
  const bool left = event.where == Where::left;
  const DrivenEnd& driven = left ? driven_left_ : driven_right_;
  const double t = time_of(event);
  Event told{t, event.where, left ? 0 : mesh_.elements, event.change, event.velocity + driven.velocity(t)};
  if (statistics_.account) {
    Cursor sent(moved(left));
    told.impulse = impedance_ * driven.force_factor() * passage_ * (left ? left_ : right_).impulse_at(event.s, sent);
    statistics_.account->count(told);
  }
  telling_.told(told);
}

Field Run::field(double s, double t) {
  Cursor left(moved(true)), right(moved(false));
  if (load_) load_->look(s);
  return Field({sent_left_, sent_left_before_, sent_right_, sent_right_before_, load_ ? &load_->rightward() : nullptr,
                load_ ? &load_->leftward() : nullptr},
               s, displacement_at(scene_.left, left_.place_at(s, left)) + driven_left_.displacement(t),
               displacement_at(scene_.right, right_.place_at(s, right)) + driven_right_.displacement(t), passage_);
}

void Run::tell_output() {
  const double t = times_[next_output_++];
  if (!observers_.snapshot) return;
  const double s = std::clamp(part_at(t), 0.0, sent_left_.end());
  Field now = field(s, t);
  for (std::size_t j = 0; j < u_.size(); ++j) {
    const double place = mesh_.node(j) / mesh_.length;
    u_[j] = now.displacement(place);
    v_[j] = now.velocity(place);
  }
  Cursor left(moved(true)), right(moved(false));
  u_.front() = displacement_at(scene_.left, left_.place_at(s, left)) + driven_left_.displacement(t);
  u_.back() = displacement_at(scene_.right, right_.place_at(s, right)) + driven_right_.displacement(t);
  v_.front() = left_.velocity_at(s, left) + driven_left_.velocity(t);
  v_.back() = right_.velocity_at(s, right) + driven_right_.velocity(t);
  for (const double u : {u_.front(), u_.back()}) place_scale_ = std::max(place_scale_, std::abs(u));
  Snapshot snapshot{t, u_, v_, impedance_ * driven_left_.force_factor() * left_.force_at(s, left),
                    impedance_ * driven_right_.force_factor() * right_.force_at(s, right)};
  if (observers_.energy) snapshot.energy = energy_at(s, now);
  telling_.snapshot(snapshot);
}

}  // namespace viscobar::characteristics

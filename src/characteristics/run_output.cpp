#include <utility>

#include "characteristics/run.hpp"

namespace viscobar::characteristics {

void Run::merge_turns() {
  events_.clear();
  for (const Turn& turn : left_.now.end.turns()) events_.push_back({turn, Where::left});
  for (const Turn& turn : right_.now.end.turns()) events_.push_back({turn, Where::right});
  std::ranges::stable_sort(events_, {}, [](const Told& event) { return event.turn.s; });
  told_ = 0;
}

std::optional<PartEnd> Run::tell_passage() {
  told_ = std::exchange(skip_, 0);
  const double end = last() ? times_.back() : std::min(time_at(1.0), times_.back());
  if (k_ == 0 && next_output_ == 0) tell_events(times_.front(), true);
  for (;;) {
    const bool output = next_output_ < times_.size() && times_[next_output_] <= end;
    double stop = output ? times_[next_output_] : end;
    if (const auto due = schedule_.next(); due && *due > t_ && *due < stop) stop = *due;
    const bool at_output = output && stop == times_[next_output_];
    tell_events(stop, false);  // an output tells the side before an event
    if (at_output) tell_output();
    const bool advanced = stop > t_;
    t_ = stop;
    if (stop == end && !output) tell_events(std::numeric_limits<double>::infinity(), true);
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

void Run::tell_events(double t, bool and_at) {
  const auto due = [&](double time) { return and_at ? time <= t : time < t; };
  while (told_ < events_.size() && due(time_of(events_[told_]))) tell(events_[told_++]);
}

void Run::tell(const Told& event) {
  ++statistics_.events;
  if (!observers_.event && !statistics_.account) return;
  const bool at_left = event.where == Where::left;
  const BarEnd& end = at_left ? left_ : right_;
  const double t = time_of(event), velocity = event.turn.velocity + end.driven.velocity(t);
  Event told{t, event.where, at_left ? 0 : mesh_.elements, event.turn.change, velocity};
  if (statistics_.account) {
    Cursor along(end.moved());
    told.impulse = impedance_ * end.driven.force_factor() * passage_ * end.now.end.impulse_at(event.turn.s, along);
    statistics_.account->count(told);
  }
  telling_.told(told);
}

Field Run::field(double s, double t) {
  if (load_) load_->look(s);
  return Field({left_.sent, left_.sent_before, right_.sent, right_.sent_before, load_ ? &load_->rightward() : nullptr,
                load_ ? &load_->leftward() : nullptr},
               s, left_.displacement_at(s, t), right_.displacement_at(s, t), passage_);
}

void Run::tell_output() {
  const double t = times_[next_output_++];
  if (!observers_.snapshot) return;
  const double s = std::clamp(part_at(t), 0.0, left_.sent.end());
  Field now = field(s, t);
  for (std::size_t j = 0; j < u_.size(); ++j) {
    const double place = mesh_.node(j) / mesh_.length;
    u_[j] = now.displacement(place);
    v_[j] = now.velocity(place);
  }
  Snapshot snapshot{t, u_, v_};
  const auto tell_end = [&](const BarEnd& end, double& u, double& v, double& reaction) {
    Cursor along(end.moved());
    u = end.displacement_at(s, t);
    v = end.now.end.velocity_at(s, along) + end.driven.velocity(t);
    reaction = impedance_ * end.driven.force_factor() * end.now.end.force_at(s, along);
    now_.place_scale = std::max(now_.place_scale, std::abs(u));
  };
  tell_end(left_, u_.front(), v_.front(), snapshot.reaction_left);
  tell_end(right_, u_.back(), v_.back(), snapshot.reaction_right);
  if (observers_.energy) snapshot.energy = energy_at(s, now);
  telling_.snapshot(snapshot);
}

}  // namespace viscobar::characteristics

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "viscobar/case/recorder.hpp"

namespace viscobar {

void Recording::keep(const Snapshot& s, std::span<const Direction> directions) {
  times.push_back(s.time);
  u.insert(u.end(), s.u.begin(), s.u.end());
  v.insert(v.end(), s.v.begin(), s.v.end());
  reaction_left.push_back(s.reaction_left);
  reaction_right.push_back(s.reaction_right);
  if (s.energy) energy.push_back(*s.energy);
  for (std::size_t k = sensitivities.size(); k < directions.size(); ++k)
    sensitivities.push_back({directions[k].key, {}, {}, {}, {}});
  for (std::size_t k = 0; k < s.sensitivities.size(); ++k) {
    const FieldSensitivity& from = s.sensitivities[k];
    RecordedSensitivity& to = sensitivities[k];
    to.u.insert(to.u.end(), from.u.begin(), from.u.end());
    to.v.insert(to.v.end(), from.v.begin(), from.v.end());
    to.reaction_left.push_back(from.reaction_left);
    to.reaction_right.push_back(from.reaction_right);
  }
}

Observers Recording::filling(const Case& run, std::size_t rows) {
  label = name(run.method);
  mesh = run.mesh();
  for (std::vector<double>* column : {&times, &reaction_left, &reaction_right}) column->reserve(rows);
  for (std::vector<double>* field : {&u, &v}) field->reserve(rows * mesh.nodes());
  Observers observers;
  observers.energy = observers.account = true;
  observers.directions = run.directions;
  observers.snapshot = [this, &run](const Snapshot& s) { keep(s, run.directions); };
  observers.event = [this](const Event& event) { events.push_back(event); };
  return observers;
}

Recording record_setup(const Setup& setup) {
  Recording recording;
  const Observers observers = recording.filling(setup.run, setup.run.output_times().size());
  recording.statistics = simulate(setup, observers);
  return recording;
}

namespace {

bool all_finite(std::span<const double> values) {
  return std::all_of(values.begin(), values.end(), [](double value) { return std::isfinite(value); });
}

}  // namespace

Recorder::Recorder(const Case& run, std::string label) : times_(run.output_times()) {
  recording_.label = std::move(label);
  recording_.mesh = run.mesh();
}

void Recorder::check(double t, std::span<const double> u, std::span<const double> v) const {
  const auto refuse = [&](const std::string& what) {
    throw std::invalid_argument(fmt::format("{}, step to t = {}: {}", recording_.label, t, what));
  };
  if (!latest_ && t != times_.front()) refuse("the first state must be that at t = 0");
  if (latest_ && !(t > latest_->t)) refuse(fmt::format("the times must increase, the last one was {}", latest_->t));
  const std::size_t nodes = recording_.mesh.nodes();
  if (u.size() != v.size() || (u.size() != nodes && u.size() != 2))
    refuse(fmt::format("u has {} values and v {}; {} nodes or 2 ends are meant", u.size(), v.size(), nodes));
  if (latest_ && u.size() != latest_->u.size()) refuse("the number of values must stay the same");
  if (!all_finite(u) || !all_finite(v)) refuse("u or v is not finite");
}

void Recorder::step(double t, std::span<const double> u, std::span<const double> v, double reaction_left,
                    double reaction_right) {
  check(t, u, v);
  if (!latest_ && u.size() == 2) recording_.mesh.elements = 1;
  const Step to{t, {u.begin(), u.end()}, {v.begin(), v.end()}, reaction_left, reaction_right};
  // Steps are often multiples of dt, the output times of another number: equal up to rounding.
  const double rounding = 1e-12 * times_.back();
  for (auto next = this->next(); next && *next <= t + rounding; next = this->next()) keep(to, *next);
  latest_ = to;
  recording_.statistics.reached_time = t;
  if (t > times_.front()) ++recording_.statistics.steps;
}

void Recorder::keep(const Step& to, double t) {
  recording_.times.push_back(t);
  const double dt = latest_ ? to.t - latest_->t : 0.0;
  const double s = latest_ ? std::min((t - latest_->t) / dt, 1.0) : 1.0;
  const auto between = [&](double from, double value) { return from + s * (value - from); };
  for (std::size_t i = 0; i < to.u.size(); ++i) {
    if (s == 1.0) {
      recording_.u.push_back(to.u[i]);
      recording_.v.push_back(to.v[i]);
      continue;
    }
    const double rise = to.u[i] - latest_->u[i], v0 = latest_->v[i], v1 = to.v[i];
    recording_.u.push_back(latest_->u[i] + s * s * (3 - 2 * s) * rise + dt * s * (1 - s) * ((1 - s) * v0 - s * v1));
    recording_.v.push_back(6 * s * (1 - s) * rise / dt + (1 - s) * (1 - 3 * s) * v0 + s * (3 * s - 2) * v1);
  }
  recording_.reaction_left.push_back(s == 1.0 ? to.reaction_left : between(latest_->reaction_left, to.reaction_left));
  recording_.reaction_right.push_back(s == 1.0 ? to.reaction_right
                                               : between(latest_->reaction_right, to.reaction_right));
}

void Recorder::change(const Event& event) {
  recording_.events.push_back(event);
  recording_.statistics.events = recording_.events.size();
}

std::optional<double> Recorder::next() const {
  const std::size_t reached = recording_.times.size();
  return reached < times_.size() ? std::optional(times_[reached]) : std::nullopt;
}

Recording Recorder::recording() {
  if (const auto missing = next())
    throw std::logic_error(fmt::format("{}: the steps end before the output time {}", recording_.label, *missing));
  recording_.statistics.completed = true;
  return recording_;
}

std::optional<std::string> fault(const Recording& recording, const Case& run) {
  const std::vector<double> times = run.output_times();
  if (recording.times != times)
    return fmt::format("its {} times are not the {} output times of the case", recording.times.size(), times.size());
  const std::size_t elements = recording.mesh.elements;
  if (const std::size_t own = run.mesh().elements; elements != own && elements != 1)
    return fmt::format("its mesh has {} elements, that of the case {}", elements, own);
  const std::size_t values = times.size() * recording.mesh.nodes();
  if (recording.u.size() != values)
    return fmt::format("u has {} values, not {} times by {} nodes", recording.u.size(), times.size(),
                       recording.mesh.nodes());
  if (!recording.v.empty() && recording.v.size() != values)
    return fmt::format("v has {} values, u {}", recording.v.size(), values);
  for (const auto* reaction : {&recording.reaction_left, &recording.reaction_right}) {
    if (!reaction->empty() && reaction->size() != times.size())
      return fmt::format("a reaction has {} values for {} times", reaction->size(), times.size());
    if (!all_finite(*reaction)) return "a reaction is not finite";
  }
  for (const Event& event : recording.events)
    if (!(event.time >= times.front() && event.time <= times.back()) || !std::isfinite(event.velocity))
      return fmt::format("a contact change at t = {} with velocity {} is none of a run from {} to {}", event.time,
                         event.velocity, times.front(), times.back());
  if (!all_finite(recording.u) || !all_finite(recording.v)) return "u or v is not finite";
  if (!std::is_sorted(recording.events.begin(), recording.events.end(),
                      [](const Event& a, const Event& b) { return a.time < b.time; }))
    return "its contact changes are not in order of time";
  return std::nullopt;
}

}  // namespace viscobar

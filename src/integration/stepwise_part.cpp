#include "integration/stepwise_part.hpp"

#include <algorithm>
#include <exception>
#include <utility>
#include <variant>

#include "dynamics/energy_terms.hpp"
#include "dynamics/impact.hpp"
#include "dynamics/obstacle_motion.hpp"
#include "integration/sensitivities.hpp"
#include "scene/times.hpp"

namespace viscobar {

StepwisePart::StepwisePart(PenalisedSystem& system, const Layout& layout, LegStepper& stepper, Statistics& statistics,
                           std::span<const double> times, const Observers& observers, double begin,
                           Sensitivities* sensitivities)
    : system_(system),
      contacts_(system.contacts()),
      layout_(layout),
      stepper_(stepper),
      statistics_(statistics),
      times_(times),
      observers_(observers),
      notifier_(observers, statistics),
      schedule_(observers, times, begin),
      search_(system, stepper, layout.size),
      watchdog_(begin, times.back()),
      ends_alone_(!observers.interior && !observers.reactions && !observers.energy && !sensitivities &&
                  !system.bar().frame().moving()),
      snapshot_(system, observers.reactions, !ends_alone_),
      filter_(system.bar()),
      sensitivities_(sensitivities),
      y_(layout.size),
      books_(system, layout_, stepper, statistics, y_, times.back() - times.front()),
      changes_({system, layout_, stepper, search_, watchdog_, books_, ends_, sensitivities, y_, times.back()},
               notifier_, statistics) {}

std::optional<Checkpoint> StepwisePart::operator()(const StartingPoint& start) {
  const double begin = begin_at(start);
  double t = begin;
  while (t < end()) {
    stepper_.before_step();
    const double step_begin = t, reached = stepper_.advance();
    ++statistics_.steps;
    watchdog_.attempt(t, reached);
    if (reached <= t) continue;  // nothing can be interpolated
    if (search_.may_reach_moving(t, reached, end() - times_.front())) return follow(t);
    std::optional<double> change = first_change(t, reached);
    double limit = change.value_or(reached);
    if (schedule_.next() && *schedule_.next() < limit) {
      limit = *schedule_.next();
      change.reset();
    }
    account_for(t, limit, reached);
    t = limit;
    statistics_.reached_time = t;
    watchdog_.step(t, statistics_.events);
    if (!notifier_.progress(t)) return std::nullopt;
    if (change) {
      books_.interpolate(t);
      stepper_.changes_at(y_);
      changes_.switch_at(t, step_begin, reached, load_break_);
      // The rest after a change at the very end is no leg.
      if (end() - t <= rounding_of_times(t, end())) break;
    } else if (t >= leg_end_) {
      books_.interpolate(t);
    }
    if (t > begin && t < end() && schedule_.due(t) && !(change && has_passed_kink(t))) {
      if (!change) books_.interpolate(t);
      return Checkpoint{t, next_output_, {}, archived(*this), frame_of(system_.bar())};
    }
    if (!change && t >= leg_end_) load_break_ = t;
    if (change || (t >= leg_end_ && t < end())) restart(t);
  }
  finish();
  return std::nullopt;
}

void StepwisePart::tell_reached() {
  const double t = statistics_.reached_time;
  if (next_output_ == 0) return;
  try {
    books_.interpolate(t);
    system_.complete_velocity(t, u(), w());
    if (t > times_[next_output_ - 1]) tell_snapshot(t);
    books_.close(t);
  } catch (const std::exception&) {  // the failure of the run may come again here
  }
}

double StepwisePart::begin_at(const StartingPoint& start) {
  const auto* checkpoint = std::get_if<Checkpoint>(&start);
  if (checkpoint) restore(*this, *checkpoint, times_, observers_);
  std::vector<std::size_t> entries = search_.sampled_entries();
  if (observers_.account) {
    if (!checkpoint) statistics_.account.emplace();
    ends_.emplace(system_, *statistics_.account, observers_.extremes, !search_.selects());
    ends_->ask_for(entries);
  }
  search_.share(entries.size());
  selected_.reserve(entries.size());
  stepper_.begin_run(std::move(entries));
  if (sensitivities_) {
    if (!checkpoint) statistics_.sensitivity.emplace();
    sensitivities_->attach(layout_, *statistics_.sensitivity, stepper_.weights());
  }
  if (checkpoint) return resume(*checkpoint);
  begin(times_.front(), std::get<State>(start));
  return times_.front();
}

void StepwisePart::begin(double t, const State& start) {
  system_.load().begin_leg(t, end());
  std::ranges::copy(start.u, u().begin());
  std::ranges::copy(start.v, w().begin());
  system_.complete_displacement(t, u());
  system_.complete_velocity(t, u(), w());
  const std::vector<double> approach(w().begin(), w().end());
  if (sensitivities_) sensitivities_->begin(t, end(), y_);
  system_.settle(t, u(), w());
  if (observers_.energy) books_.open(t);
  starts_in_contact_ = changes_.start(t, start, approach);
  statistics_.reached_time = t;
  tell_snapshot(t);
  next_output_ = 1;
  restart(t, Leg::first);
}

double StepwisePart::resume(const Checkpoint& checkpoint) {
  const double t = checkpoint.time;
  next_output_ = checkpoint.outputs;
  changes_.resume();
  load_break_ = t;
  const bool entered = checkpoint.frame == Checkpoint::Frame::entered;
  if (entered && sensitivities_) {
    leg_end_ = system_.load().begin_leg(t, end());
    sensitivities_->begin_leg(t, end(), y_);
    sensitivities_->enter_frame(t, y_);
  }
  restart(t, entered ? Leg::same : Leg::next);
  return t;
}

std::optional<double> StepwisePart::first_change(double from, double to) {
  if (contacts_.size() == 0) return std::nullopt;
  ++statistics_.event_evaluations;
  form_samples_ = stepper_.form_samples(from, to);
  const std::optional<double> change = search_.first_change(from, to, ends_, form_samples_);
  statistics_.max_penetration = std::max(statistics_.max_penetration, search_.max_penetration());
  return change;
}

// Ends, outputs and energy of a step from `from` to `to` that counts up to `limit`.
void StepwisePart::account_for(double from, double limit, double to) {
  if (ends_ && !ends_->idle()) {
    if (!forms_.empty() && limit > from)
      ends_->add_joints(from, limit, stepper_.order(),
                        limit == to ? form_samples_ : stepper_.form_samples(from, limit));
    const bool searched = contacts_.size() > 0 && !search_.selects() && limit == to;
    if (searched && search_.quiet())
      ends_->pass(to, search_.last());
    else
      watch_ends(from, limit, searched);
    ends_->integrate(from, limit, stepper_.order(), [&](double at) { return stepper_.sample(at, 0); });
  }
  books_.enter_step(from, to);
  outputs_until(limit);
  books_.leave_step(limit);
  if (statistics_.energy) books_.notice(limit);
}

// `looked` says that the search has sampled what the ends need.
void StepwisePart::watch_ends(double from, double to, bool looked) {
  // A step is short against the time in which a velocity doubles.
  if (!looked && !ends_->concerned(to, 2.0 * stepper_.weights().largest_velocity())) return;
  if (!looked) {
    if (search_.selects()) select(false);
    const auto sample = [&](int derivative) {
      return [&, derivative](std::size_t, double t) { return stepper_.sample(t, derivative); };
    };
    ends_->look_at(from, to, stepper_.order(), sample(0), sample(1));
  }
  ends_->add();
}

void StepwisePart::outputs_until(double limit) {
  for (; next_output_ < times_.size() && times_[next_output_] <= limit; ++next_output_) {
    if (!observers_.snapshot) continue;
    const double t = times_[next_output_];
    if (ends_alone_)
      stepper_.interpolate_ends(t, y_);
    else
      books_.interpolate(t);
    system_.complete_velocity(t, u(), w());
    tell_snapshot(t);
  }
}

void StepwisePart::finish() {
  statistics_.reached_time = end();
  // A change within rounding of the end leaves the last output to be told.
  for (; next_output_ < times_.size(); ++next_output_) tell_snapshot(times_[next_output_]);
  system_.complete_velocity(end(), u(), w());
  if (ends_) ends_->begin(end(), u(), w());
  if (sensitivities_) sensitivities_->sum_up(end(), y_);
  books_.close(end());
  statistics_.completed = true;
}

// The bar may come to an obstacle that moves within the step that begins at t: from there on the frame follows it. A
// kink at t has been passed.
Checkpoint StepwisePart::follow(double t) {
  books_.interpolate(t);
  system_.complete_velocity(t, u(), w());
  const double after = t + rounding_of_times(t, end());
  if (sensitivities_) sensitivities_->leave_frame(t, after, y_);
  books_.enter_frame(change_frame(system_, system_.bar().following(), after, u(), w()));
  return {t, next_output_, {}, archived(*this), Checkpoint::Frame::entered};
}

void StepwisePart::restart(double t, Leg leg) {
  books_.begin_leg();
  for (std::size_t i = 0; i < contacts_.size(); ++i)
    if (contacts_.closed(i)) contacts_.measure(i, u());
  leg_end_ = system_.load().begin_leg(t, end());
  if (leg != Leg::same && !has_passed_kink(t)) pass_kink(t);
  follow_load(t);
  system_.complete_velocity(t, u(), w());
  if (filter_.acts()) {
    if (leg == Leg::first) begin_ends(t);  // the data are of the range of an end
    if (leg != Leg::same && !(leg == Leg::first && starts_in_contact_)) filter_jump(t, leg);
  }
  if (sensitivities_) sensitivities_->begin_leg(t, end(), y_);
  begin_ends(t);
  if (ends_) ends_->take_first_forces(t, u(), w());
  take_forms();
  if (!search_.selects()) select(true);
  stepper_.restart(t, leg_end_, y_);
}

void StepwisePart::begin_ends(double t) {
  if (!ends_) return;
  ends_->measure_from(contacts_.origin().values());
  ends_->begin(t, u(), w());
}

// A wall or an obstacle changes its velocity at once.
void StepwisePart::pass_kink(double t) {
  const auto jump = system_.bar().frame().kink(t, end());
  if (sensitivities_) sensitivities_->pass_kink(t, end(), jump ? &*jump : nullptr, y_);
  if (!jump) return;
  kink_ = t;
  books_.as_work([&] {
    system_.bar().frame().pass_kink(*jump, u(), w());
    tie_joints(contacts_, w());
    if (jump->displaces()) changes_.leave_obstacles(t, *jump);
  });
  changes_.strike_by_kink(t, *jump);
}

// Undamped nodes without mass follow their row at once. Where a load jumps, or opens or closes their contact by that,
// the energy that it gives them is its work: that of a force which grows there as fast as one likes.
void StepwisePart::follow_load(double t) {
  const auto complete = [&] { system_.complete_displacement(t, u()); };
  if (t == load_break_ && system_.bar().inertia().has_massless() && !system_.bar().bar().damped())
    books_.as_work(complete);
  else
    complete();
}

// Jumps of the load or of the data shake the high modes of the mesh at an end (see JumpFilter).
void StepwisePart::filter_jump(double t, Leg leg) {
  const ErrorWeights& weights = stepper_.weights();
  const auto start = [&] {
    books_.take(filter_.begin(system_, t, {weights.displacement_tolerance(), weights.velocity_tolerance()}, u(), w()));
  };
  const auto pass_break = [&] { books_.take(filter_.pass_break(system_, t, end(), u(), w())); };
  if (leg == Leg::first)
    sensitivities_ ? sensitivities_->pass_start(filter_, t, y_, start) : start();
  else
    sensitivities_ ? sensitivities_->pass_break(filter_, t, end(), y_, pass_break) : pass_break();
}

// The stepper samples what the ends need from now on, and where asked for the search, each entry once.
void StepwisePart::select(bool for_search) {
  selected_.clear();
  if (for_search) search_.select(selected_);
  if (ends_) ends_->select(selected_);
  std::ranges::sort(selected_);
  selected_.erase(std::ranges::unique(selected_).begin(), selected_.end());
  stepper_.select(selected_);
  search_.selected(selected_, ends_);
}

void StepwisePart::take_forms() {
  forms_.clear();
  search_.ask_for(forms_);
  if (ends_) ends_->ask_for(forms_);
  stepper_.take_forms(forms_);
}

void StepwisePart::tell_snapshot(double t) {
  if (!observers_.snapshot) return;
  Snapshot now = snapshot_(t, u(), w());
  if (sensitivities_) now.sensitivities = sensitivities_->fields(t, y_, now);
  if (observers_.energy) now.energy = books_.at(now, snapshot_);
  notifier_.snapshot(now);
}

}  // namespace viscobar

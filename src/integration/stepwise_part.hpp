#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "dynamics/energy_terms.hpp"
#include "dynamics/impact.hpp"
#include "dynamics/jumps/jump_filter.hpp"
#include "dynamics/obstacle_motion.hpp"
#include "dynamics/penalised_system.hpp"
#include "integration/contact_watch.hpp"
#include "integration/energy_flow.hpp"
#include "integration/event_search.hpp"
#include "integration/late_opening.hpp"
#include "integration/layout.hpp"
#include "integration/sensitivities.hpp"
#include "integration/snapshot.hpp"
#include "integration/stepper.hpp"
#include "run/contact_states.hpp"
#include "run/notifier.hpp"
#include "run/parts.hpp"
#include "run/watchdog.hpp"
#include "scene/times.hpp"
#include "viscobar/dynamics/bar_system.hpp"
#include "viscobar/run/run.hpp"

namespace viscobar {

/// A run up to its next checkpoint, or to its end. It goes leg by leg. On a leg no contact changes, and the load is
/// smooth. A leg ends where a contact changes, where the load breaks, or at a checkpoint. The stepper makes the steps.
/// This class finds the contact changes within them, tells the output, and keeps the accounts.
class StepwisePart {
 public:
  StepwisePart(PenalisedSystem& system, const Layout& layout, LegStepper& stepper, Statistics& statistics,
               std::span<const double> times, const Observers& observers, double begin, Sensitivities* sensitivities)
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
        y_(layout.size),
        inner_(layout.size),
        sensitivities_(sensitivities) {}

  /// Up to the next checkpoint, which is returned, to where an observer stops it, or to the end.
  std::optional<Checkpoint> operator()(const StartingPoint& start) {
    const double end = times_.back();
    const double begin = begin_at(start);
    double t = begin;
    while (t < end) {
      stepper_.before_step();
      const double step_begin = t, reached = stepper_.advance();
      ++statistics_.steps;
      watchdog_.attempt(t, reached);
      if (reached <= t) continue;  // nothing can be interpolated
      if (search_.may_reach_moving(t, reached, end - times_.front())) return follow(t);
      std::optional<double> change;
      if (contacts_.size() > 0) {
        ++statistics_.event_evaluations;
        change = search_.first_change(t, reached, ends_);
        statistics_.max_penetration = std::max(statistics_.max_penetration, search_.max_penetration());
      }
      double limit = change.value_or(reached);
      if (schedule_.next() && *schedule_.next() < limit) {
        limit = *schedule_.next();
        change.reset();
      }
      if (ends_ && !ends_->idle()) {
        const bool searched = contacts_.size() > 0 && !search_.selects() && limit == reached;
        if (searched && search_.quiet())
          ends_->pass(reached, search_.last());
        else
          watch_ends(t, limit, searched);
        ends_->integrate(t, limit, stepper_.order(), [&](double at) { return stepper_.sample(at, 0); });
      }
      if (layout_.account() > 0 && account_doubtful(t, reached)) {
        outputs_until(limit, [&](double at) { return corrected_account(t, at); });
        account_shift_ = corrected_account(t, limit);
      } else {
        outputs_until(limit, [&](double) { return account_shift_; });
      }
      if (statistics_.energy) notice(limit);
      t = limit;
      statistics_.reached_time = t;
      watchdog_.step(t, statistics_.events);
      if (!notifier_.progress(t)) return std::nullopt;
      if (change) {
        reach(t);
        stepper_.changes_at(y_);
        switch_contacts(t, step_begin, reached);
        // The rest after a change at the very end is no leg.
        if (end - t <= rounding_of_times(t, end)) break;
      } else if (t >= leg_end_) {
        reach(t);
      }
      if (t > begin && t < end && schedule_.due(t) && !(change && has_passed_kink(t))) {
        if (!change) reach(t);
        return Checkpoint{t, next_output_, {}, archived(*this), frame_of(system_.bar())};
      }
      if (!change && t >= leg_end_) load_break_ = t;
      if (change || (t >= leg_end_ && t < end)) restart(t);
    }
    statistics_.reached_time = end;
    finish(end);
    return std::nullopt;
  }

  /// Content of a checkpoint.
  static void members(auto& run, auto&& each) {
    each(std::span(run.y_), ContactStates{run.contacts_}, run.stepper_.weights(), run.watchdog_);
  }

  void count_seconds() { notifier_.count_seconds(); }

  /// Tells the state of a run that could not go on, and its energy: one more snapshot, at the time reached, where none
  /// was told yet.
  void tell_reached() {
    const double t = statistics_.reached_time;
    if (next_output_ == 0) return;
    try {
      reach(t);
      system_.complete_velocity(t, u(), w());
      if (t > times_[next_output_ - 1]) tell_snapshot(t);
      sum_up_energy(t);
    } catch (const std::exception&) {  // the failure of the run may come again here
    }
  }

 private:
  std::span<double> u() { return layout_.u(y_); }
  std::span<double> w() { return layout_.w(y_); }

  double begin_at(const StartingPoint& start) {
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
    if (checkpoint) {
      next_output_ = checkpoint->outputs;
      distrust_toggling();
      load_break_ = checkpoint->time;
      const bool entered = checkpoint->frame == Checkpoint::Frame::entered;
      if (entered && sensitivities_) {
        leg_end_ = system_.load().begin_leg(checkpoint->time, times_.back());
        sensitivities_->begin_leg(checkpoint->time, times_.back(), y_);
        sensitivities_->enter_frame(checkpoint->time, y_);
      }
      restart(checkpoint->time, entered ? Leg::same : Leg::next);
      return checkpoint->time;
    }
    begin(times_.front(), std::get<State>(start));
    return times_.front();
  }

  void begin(double t, const State& start) {
    system_.load().begin_leg(t, times_.back());
    std::ranges::copy(start.u, u().begin());
    std::ranges::copy(start.v, w().begin());
    system_.complete_displacement(t, u());
    system_.complete_velocity(t, u(), w());
    const std::vector<double> approach(w().begin(), w().end());
    if (sensitivities_) sensitivities_->begin(t, times_.back(), y_);
    system_.settle(t, u(), w());
    if (observers_.energy) {
      const double of_frame = frame_energy(system_, t, u(), w());
      statistics_.energy = EnergyAccount{.initial = energy(contacts_, u(), w()) + of_frame};
      if (layout_.work) y_[*layout_.work] = -of_frame;
    }
    // Rigid contacts strike one after the other: those to come are open, and one that has moved apart by then stays so.
    std::vector<std::size_t> settled;
    for (std::size_t i = 0; i < contacts_.size(); ++i) {
      if (!contacts_.closed(i)) continue;
      settled.push_back(i);
      if (contacts_[i].collides) contacts_.set_closed(i, false);
    }
    bool struck = false;
    for (const std::size_t i : settled) {
      if (contacts_[i].collides && contacts_[i].sign * contacts_[i].of(w()) > 0.0) continue;
      starts_in_contact_ = true;
      differentiate_closing(t, i, start, approach);
      const double velocity = struck ? contacts_[i].of(w()) : contacts_[i].of(approach);
      struck = struck || contacts_[i].collides;
      if (contacts_[i].collides)
        strike(t, i, velocity);
      else
        tell_event(t, i, Change::closing, velocity);
      if (sensitivities_) sensitivities_->after(t, i, y_);
    }
    statistics_.reached_time = t;
    tell_snapshot(t);
    next_output_ = 1;
    restart(t, Leg::first);
  }

  // The contact is closed from the start on: the bar comes to it with the velocities that it is given.
  void differentiate_closing(double t, std::size_t i, const State& start, const std::vector<double>& approach) {
    if (!sensitivities_) return;
    if (contacts_[i].collides) {  // after those that have struck before it
      changes_ = sensitivities_->before(t, t, i, false, y_);
      return;
    }
    const bool closed = contacts_.closed(i);
    const std::vector<double> settled = y_;
    contacts_.set_closed(i, false);
    std::ranges::copy(start.u, u().begin());
    std::ranges::copy(approach, w().begin());
    system_.complete_displacement(t, u());
    changes_ = sensitivities_->before(t, t, i, false, y_);
    std::copy_n(settled.begin(), 2 * layout_.nodes, y_.begin());
    contacts_.set_closed(i, closed);
  }

  // The bar may come to an obstacle that moves within the step that begins at t: from there on the frame follows it. A
  // kink at t has been passed.
  Checkpoint follow(double t) {
    reach(t);
    system_.complete_velocity(t, u(), w());
    const double after = t + rounding_of_times(t, times_.back());
    if (sensitivities_) sensitivities_->leave_frame(t, after, y_);
    const double gained = change_frame(system_, system_.bar().following(), after, u(), w());
    if (layout_.work)
      y_[*layout_.work] -= gained;
    else if (observers_.energy)  // the other frame has a load
      y_.insert(y_.begin() + static_cast<std::ptrdiff_t>(2 * layout_.nodes + (layout_.dissipated ? 1 : 0)), -gained);
    return {t, next_output_, {}, archived(*this), Checkpoint::Frame::entered};
  }

  // The state where the run is.
  void reach(double t) { interpolate(t, account_shift_); }

  void interpolate(double t, const std::array<double, 3>& shift) {
    stepper_.interpolate(t, y_);
    for (std::size_t k = 0; k < layout_.account(); ++k) y_[2 * layout_.nodes + k] += shift[k];
  }

  // Over a step; `looked` says that the search has sampled what they need.
  void watch_ends(double from, double to, bool looked) {
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

  // At the end of the last step. In a frame that moves its energy is not known there; the bar's is of that size.
  void notice(double t) {
    const std::span<const double> account = stepper_.account();
    const auto entry = [&](std::optional<std::size_t> at) { return at ? account[*at - 2 * layout_.nodes] : 0.0; };
    EnergyAccount& energy = *statistics_.energy;
    energy.notice(entry(layout_.dissipated) + entry(layout_.end_inertia) + energy.end_inertia, entry(layout_.work));
    const Bar& bar = system_.bar().bar();
    if (!system_.bar().frame().moving()) return;
    const Lift rate = system_.load().lift(t, 1);
    energy.largest = std::max({energy.largest, 0.5 * bar.density * bar.length * rate.left * rate.left,
                               0.5 * bar.density * bar.length * rate.right * rate.right});
  }

  // True if the step may spoil the account by more than its share of what the motion's own error does. The correction
  // is several times the error, which is a fraction of it that falls with the order.
  bool account_doubtful(double from, double to) {
    const double share = (to - from) / (times_.back() - times_.front());
    return stepper_.account_correction() > share * stepper_.weights().promised_energy();
  }

  // The power of a motion of frequency omega has one of 2 omega: where the formulas just resolve omega at a high order,
  // their account of the power may be a thousand times worse. Gauss' formula integrates it over the step instead.
  std::array<double, 3> corrected_account(double from, double to) {
    const std::size_t first = 2 * layout_.nodes, count = layout_.account();
    std::array<double, 3> shift = account_shift_;
    for (const auto& [at, sign] : {std::pair{to, -1.0}, {from, 1.0}}) {
      stepper_.interpolate(at, inner_);
      for (std::size_t k = 0; k < count; ++k) shift[k] += sign * inner_[first + k];
    }
    add_energy_flow<5>(
        system_, layout_, from, to, [&](double t, std::span<double> y) { stepper_.interpolate(t, y); },
        [&](double t) { return stepper_.accelerations(t); }, inner_, shift);
    return shift;
  }

  // How a leg begins: at the start of the run, behind a break or a change, or in another frame at the same time.
  enum class Leg { first, next, same };

  void restart(double t, Leg leg = Leg::next) {
    account_shift_ = {};
    for (std::size_t i = 0; i < contacts_.size(); ++i)
      if (contacts_.closed(i)) contacts_.measure(i, u());
    leg_end_ = system_.load().begin_leg(t, times_.back());
    if (leg != Leg::same && !has_passed_kink(t)) pass_kink(t);
    follow_load(t);
    system_.complete_velocity(t, u(), w());
    if (ends_ && leg == Leg::first && filter_.acts()) {  // the data are of the range of an end
      ends_->measure_from(contacts_.origin().values());
      ends_->begin(t, u(), w());
    }
    if (filter_.acts() && leg != Leg::same && !(leg == Leg::first && starts_in_contact_)) {
      const ErrorWeights& weights = stepper_.weights();
      const auto start = [&] {
        take(filter_.begin(system_, t, {weights.displacement_tolerance(), weights.velocity_tolerance()}, u(), w()));
      };
      const auto pass_break = [&] { take(filter_.pass_break(system_, t, times_.back(), u(), w())); };
      if (leg == Leg::first)
        sensitivities_ ? sensitivities_->pass_start(filter_, t, y_, start) : start();
      else
        sensitivities_ ? sensitivities_->pass_break(filter_, t, times_.back(), y_, pass_break) : pass_break();
    }
    if (sensitivities_) sensitivities_->begin_leg(t, times_.back(), y_);
    if (ends_) {
      ends_->measure_from(contacts_.origin().values());
      ends_->begin(t, u(), w());
    }
    if (!search_.selects()) select(true);
    stepper_.restart(t, leg_end_, y_);
  }

  // Undamped nodes without mass follow their row at once. Where a load jumps, or opens or closes their contact by that,
  // the energy that it gives them is its work: that of a force which grows there as fast as one likes.
  void follow_load(double t) {
    const bool works =
        layout_.work && t == load_break_ && system_.bar().inertia().has_massless() && !system_.bar().bar().damped();
    const double before = works ? energy(contacts_, u(), w()) : 0.0;
    system_.complete_displacement(t, u());
    if (works) y_[*layout_.work] += energy(contacts_, u(), w()) - before;
  }

  // The stepper samples what the ends need from now on, and where asked for the search, each entry once.
  void select(bool for_search) {
    selected_.clear();
    if (for_search) search_.select(selected_);
    if (ends_) ends_->select(selected_);
    std::ranges::sort(selected_);
    selected_.erase(std::ranges::unique(selected_).begin(), selected_.end());
    stepper_.select(selected_);
    search_.selected(selected_);
  }

  // A wall or an obstacle changes its velocity at once. A rigid contact that is closed then has an impact, or
  // opens. So does one whose obstacle jumps away; what its penalty has stored is lost, as work of the obstacle.
  void pass_kink(double t) {
    const auto jump = system_.bar().frame().kink(t, times_.back());
    if (sensitivities_) sensitivities_->pass_kink(t, times_.back(), jump ? &*jump : nullptr, y_);
    if (!jump) return;
    kink_ = t;
    const double before = layout_.work ? energy(contacts_, u(), w()) : 0.0;
    system_.bar().frame().pass_kink(*jump, u(), w());
    tie_joints(contacts_, w());
    if (jump->displaces()) leave_obstacles(t, *jump);
    if (layout_.work) y_[*layout_.work] += energy(contacts_, u(), w()) - before;
    for (std::size_t i = 0; i < contacts_.size(); ++i) {
      const std::size_t node = contacts_[i].unknown;
      if (!contacts_.holds_mass(i) || contacts_[i].joint > 0) continue;
      // A kink of the other end's motion leaves a rounding.
      if (jump->velocity.at(system_.bar().frame().share(node)) == 0.0) w()[node] = 0.0;
      if (w()[node] == 0.0) continue;
      contacts_.set_closed(i, false);
      if (sensitivities_) changes_ = sensitivities_->at_break(t, times_.back(), i, y_);
      if (contacts_[i].sign * w()[node] < 0.0)
        strike(t, i, std::nullopt);
      else
        tell_event(t, i, Change::opening, w()[node]);
    }
  }

  // A contact may change where its obstacle has a kink, and a leg begin there once more.
  bool has_passed_kink(double t) const { return t - kink_ <= 2.0 * rounding_of_times(t, times_.back()); }

  void leave_obstacles(double t, const FrameJump& jump) {
    const double largest = stepper_.weights().largest_displacement();
    for (const std::size_t i : left_by_jump(contacts_, jump, t, u(), largest)) {
      contacts_.set_closed(i, false);
      system_.complete_velocity(t, u(), w());
      if (sensitivities_) changes_ = sensitivities_->at_break(t, times_.back(), i, y_);
      tell_event(t, i, Change::opening, w()[contacts_[i].unknown]);
    }
  }

  // Books the loss of the high modes of the mesh at a jump.
  void take(const JumpFilter::Taken& taken) {
    if (!statistics_.energy) return;
    statistics_.energy->end_inertia += taken.energy;
    if (layout_.work) y_[*layout_.work] += taken.work;
  }

  // `shift_at` gives what the account of the leg is shifted by at a time of the step.
  template <class ShiftAt>
  void outputs_until(double limit, ShiftAt&& shift_at) {
    for (; next_output_ < times_.size() && times_[next_output_] <= limit; ++next_output_) {
      if (!observers_.snapshot) continue;
      if (ends_alone_)
        stepper_.interpolate_ends(times_[next_output_], y_);
      else
        interpolate(times_[next_output_], shift_at(times_[next_output_]));
      system_.complete_velocity(times_[next_output_], u(), w());
      tell_snapshot(times_[next_output_]);
    }
  }

  void finish(double end) {
    // A change within rounding of the end leaves the last output to be told.
    for (; next_output_ < times_.size(); ++next_output_) tell_snapshot(times_[next_output_]);
    system_.complete_velocity(end, u(), w());
    if (ends_) ends_->begin(end, u(), w());
    if (sensitivities_) sensitivities_->sum_up(end, y_);
    sum_up_energy(end);
    statistics_.completed = true;
  }

  // The account of the run, where it ends or stops.
  void sum_up_energy(double t) {
    if (!statistics_.energy) return;
    const double of_frame = frame_energy(system_, t, u(), w());
    statistics_.energy->final = energy(contacts_, u(), w()) + of_frame;
    if (layout_.dissipated) statistics_.energy->dissipated = y_[*layout_.dissipated];
    if (layout_.work) statistics_.energy->work = y_[*layout_.work] + of_frame;
    if (layout_.end_inertia) statistics_.energy->end_inertia += y_[*layout_.end_inertia];
    statistics_.energy->dissipated += statistics_.energy->end_inertia;
  }

  // In the step from `begin` to `end`.
  void switch_contacts(double t, double begin, double end) {
    system_.complete_velocity(t, u(), w());
    const auto switch_one = [&](std::size_t i) {
      const bool opens = contacts_.closed(i);
      const std::size_t node = contacts_[i].unknown;
      const auto velocity = [&] { return contacts_[i].of(w()); };
      const bool pulled = opens && i == search_.first_contact();
      const double told = pulled ? std::max(search_.pulled_since(t), watchdog_.last_change()) : t;
      const bool by_push = i == search_.first_contact() && search_.by_push();
      if (sensitivities_)
        changes_ = (opens || by_push) && t == load_break_ ? sensitivities_->at_break(t, times_.back(), i, y_)
                                                          : sensitivities_->before(t, told, i, by_push, y_);
      if (by_push && layout_.dissipated)
        y_[*layout_.dissipated] += (opens ? 1.0 : -1.0) * contacts_[i].law.stop()->energy(-contacts_.clearance(i, u()));
      if (!opens) close(t, i, velocity());
      // A node that follows its neighbour at once is put where the new state has it as the next leg begins.
      if (!by_push && (!system_.bar().inertia().massless(node) || system_.bar().bar().damped()))
        contacts_.place(i, u());
      if (opens) {
        contacts_.set_closed(i, false);
        if (pulled) give_back(contacts_[i].sign * search_.held_back());
        // A rounding of its penetration is a velocity of a node without mass.
        if (contacts_[i].changes_by_row) system_.complete_velocity(t, u(), w());
        tell_event(told, i, Change::opening, velocity());
        if (!contacts_[i].law.stop() &&
            (contacts_[i].is_passed_over(end - begin) || contacts_[i].has_come_to_rest(t - watchdog_.last_change())))
          weigh_opening({system_, layout_, stepper_}, i, {t, begin, end, watchdog_.last_change(), load_break_}, inner_,
                        statistics_.late_opening);
      }
      if (sensitivities_) sensitivities_->after(t, i, y_);
    };
    search_.look_at(begin, t);
    const std::size_t first = search_.first_contact();
    switch_one(first);  // it may be told of a time before t
    for (std::size_t i = 0; i < contacts_.size(); ++i)
      if (i != first && search_.changes(i, t, y_)) switch_one(i);
    watchdog_.change(t, search_.first_contact());
    distrust_toggling();
  }

  // The velocity that the pull of a contact has taken from the bar before it opened, and the heat that made of it.
  void give_back(double velocity) {
    if (velocity == 0.0) return;
    const auto kinetic = [&] { return 0.5 * system_.bar().inertia().matrix().quadratic_form(w()); };
    const double before = kinetic();
    for (std::size_t i = 0; i < layout_.nodes; ++i)
      if (!contacts_.held(i)) w()[i] += velocity;
    if (layout_.dissipated) y_[*layout_.dissipated] -= kinetic() - before;
  }

  // Its node is at the obstacle, or there to rounding. Bounces lower than what a step may be wrong by are not resolved.
  void close(double t, std::size_t i, double velocity) {
    if (contacts_[i].collides) return strike(t, i, velocity);
    tell_event(t, i, Change::closing, velocity);
    contacts_.set_closed(i, true);
    watchdog_.close(t, contacts_[i].unknown + system_.bar().unknowns().first_node(), contacts_[i].rate);
  }

  // The impact of a rigid contact. `closing` is the velocity that its closing is told with, absent where that has been
  // told. One that neither rests nor rebounds, because the bar pulls its node away at once, is an error of the mesh: it
  // is no contact, unless the wave that it sends brings the node back (see tell_closing()). Where a mass of the scene
  // strikes, or an obstacle moves in by more than half of that velocity and turns back, it is one.
  void strike(double t, std::size_t i, std::optional<double> closing) {
    ErrorWeights& weights = stepper_.weights();
    const double h = system_.bar().elements().stretch_beside(contacts_[i].unknown);
    std::vector<double> change(w().begin(), w().end());
    const Collision collision =
        collide(system_, i, t, u(), w(),
                {weights.negligible_bounce(i), weights.negligible_reaction(h), weights.promised_velocity()});
    weights.bounce(i, collision.height);
    if (layout_.dissipated) y_[*layout_.dissipated] += collision.dissipated;
    if (layout_.end_inertia) y_[*layout_.end_inertia] += collision.end_inertia;
    const double leaves = contacts_[i].of(w());
    const bool of_scene = mass_at(contacts_[i]) > 0.0 || (contacts_[i].joint > 0 && !contacts_[i].of_bar) ||
                          2.0 * contacts_[i].sign * frame_velocity(t, i) > std::abs(closing.value_or(0.0));
    const bool counts =
        collision.rests || leaves != 0.0 || !closing || (std::abs(*closing) > weights.promised_velocity() && of_scene);
    if (closing && counts)
      tell_closing(t, i, *closing);
    else if (closing && std::abs(*closing) > weights.promised_velocity())
      withhold_closing(t, i, *closing);
    for (std::size_t j = 0; j < change.size(); ++j) change[j] = w()[j] - change[j];
    if (ends_) ends_->strike(i, collision.impulse, change);
    if (sensitivities_) sensitivities_->rebound(i, changes_);
    for (const std::size_t k : collision.released) {
      if (sensitivities_) sensitivities_->lose(t, "an impact opens another contact", y_);
      // They are at the time of the impact, each with a velocity of its own.
      for (ChangeSensitivity& told : changes_) told.velocity = std::numeric_limits<double>::quiet_NaN();
      tell_event(t, k, Change::opening, contacts_[k].of(w()));
    }
    if (collision.rests)
      contacts_.set_closed(i, true);
    else if (counts)
      tell_event(t, i, Change::opening, leaves);
  }

  // A step across a jump of the load may leave the surface by less than its error, to either side, and a bar that has
  // stood at the origin has no rounding to speak of: what toggles is more and more of the tolerance uncertain.
  void distrust_toggling() {
    const std::size_t toggles = watchdog_.toggles();
    const double share = std::pow(10.0, std::min(static_cast<double>(toggles) - 10.0, 0.0));
    search_.distrust(watchdog_.last_contact(), toggles > 0 ? share : 0.0);
  }

  // The velocity of the frame at a contact is that of its obstacle, at a kink on the side of the leg.
  double frame_velocity(double t, std::size_t i) const {
    const BarSystem& bar = system_.bar();
    return bar.frame().moving() ? bar.frame().lift_at(contacts_[i], system_.load().lift(t, 1)) : 0.0;
  }

  // A closing that is not told yet, and when its node struck last.
  struct Withheld {
    std::size_t contact;
    double last, time, velocity;
    std::vector<ChangeSensitivity> sensitivities;
  };

  // True if the node is back before a wave has crossed the element behind it: no mesh tells these strikes apart.
  bool goes_on(double t, std::size_t i) const {
    if (!withheld_ || withheld_->contact != i) return false;
    const Mesh& mesh = system_.bar().mesh();
    const Bar& bar = system_.bar().bar();
    const Contact& contact = contacts_[i];
    const double h = mesh.element(contact.joint > 0              ? system_.bar().elements().beside(contact.unknown)
                                  : contact.where == Where::left ? 0
                                                                 : mesh.elements - 1);
    return t - withheld_->last < h * bar.slowness();
  }

  void withhold_closing(double t, std::size_t i, double velocity) {
    if (goes_on(t, i))
      withheld_->last = t;
    else
      withheld_ = {i, t, t, velocity + frame_velocity(t, i), sensitivities_at(t, i)};
  }

  // A contact begins with the first of the strikes that are one.
  void tell_closing(double t, std::size_t i, double velocity) {
    if (!goes_on(t, i)) return tell_event(t, i, Change::closing, velocity);
    const Withheld first = *std::exchange(withheld_, std::nullopt);
    notifier_.event(first.time, system_.bar().unknowns(), contacts_[i], Change::closing, first.velocity,
                    first.sensitivities);
  }

  void tell_event(double t, std::size_t i, Change change, double velocity) {
    withheld_.reset();  // events are told in their order
    notifier_.event(t, system_.bar().unknowns(), contacts_[i], change, velocity + frame_velocity(t, i),
                    sensitivities_at(t, i));
  }

  std::vector<ChangeSensitivity> sensitivities_at(double t, std::size_t i) const {
    std::vector<ChangeSensitivity> of_bar = changes_;
    if (sensitivities_) sensitivities_->add_frame(t, i, of_bar);
    return of_bar;
  }

  void tell_snapshot(double t) {
    if (!observers_.snapshot) return;
    Snapshot now = snapshot_(t, u(), w());
    if (sensitivities_) now.sensitivities = sensitivities_->fields(t, y_, now);
    if (observers_.energy) {
      const auto entry = [&](std::optional<std::size_t> at) { return at ? y_[*at] : 0.0; };
      now.energy = snapshot_.energy(now, u());
      now.energy->end_inertia = statistics_.energy->end_inertia + entry(layout_.end_inertia);
      now.energy->dissipated = entry(layout_.dissipated) + now.energy->end_inertia;
      now.energy->work = entry(layout_.work) + frame_energy(system_, t, u(), w());
    }
    notifier_.snapshot(now);
  }

  PenalisedSystem& system_;
  Contacts& contacts_;
  Layout layout_;
  LegStepper& stepper_;
  Statistics& statistics_;
  std::span<const double> times_;
  const Observers& observers_;
  Notifier notifier_;
  CheckpointSchedule schedule_;
  EventSearch search_;
  std::optional<ContactWatch> ends_;
  Watchdog watchdog_;
  bool ends_alone_;  // snapshots have no other nodes
  SnapshotBuilder snapshot_;
  JumpFilter filter_;
  std::vector<double> y_, inner_;          // the state where the run is, and within a step
  std::vector<std::size_t> selected_;      // positions of sampled entries
  std::array<double, 3> account_shift_{};  // of the account of this leg
  double leg_end_ = 0.0, load_break_ = -std::numeric_limits<double>::infinity();
  double kink_ = load_break_;  // the last one that has been passed
  std::size_t next_output_ = 0;
  std::optional<Withheld> withheld_;
  bool starts_in_contact_ = false;  // the filter keeps the motion after an impact
  Sensitivities* sensitivities_;
  std::vector<ChangeSensitivity> changes_;  // of the contact change under way
};

}  // namespace viscobar

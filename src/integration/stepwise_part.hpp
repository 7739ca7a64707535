#pragma once

#include <limits>
#include <optional>
#include <span>
#include <vector>

#include "dynamics/jumps/jump_filter.hpp"
#include "integration/accounts/contact_watch.hpp"
#include "integration/accounts/energy_books.hpp"
#include "integration/events/contact_changes.hpp"
#include "integration/events/event_search.hpp"
#include "integration/snapshot.hpp"
#include "integration/stepper.hpp"
#include "run/framed_parts.hpp"
#include "run/notifier.hpp"
#include "run/watchdog.hpp"

namespace viscobar {

/// A run up to its next checkpoint, or to its end. It goes leg by leg. On a leg no contact changes, and the load is
/// smooth. A leg ends where a contact changes, where the load breaks, or at a checkpoint. The stepper makes the steps.
/// This class finds the contact changes within them, tells the output, and has the accounts kept.
class StepwisePart {
 public:
  StepwisePart(PenalisedSystem& system, const Layout& layout, LegStepper& stepper, Statistics& statistics,
               std::span<const double> times, const Observers& observers, double begin, Sensitivities* sensitivities);

  /// Up to the next checkpoint, which is returned, to where an observer stops it, or to the end.
  std::optional<Checkpoint> operator()(const StartingPoint& start);

  /// Content of a checkpoint.
  static void members(auto& run, auto&& each) {
    each(std::span(run.y_), run.contacts_, run.stepper_.weights(), run.watchdog_);
  }

  void count_seconds() { notifier_.count_seconds(); }

  /// Tells the state of a run that could not go on, and its energy: one more snapshot, at the time reached, where none
  /// was told yet.
  void tell_reached();

 private:
  // How a leg begins: at the start of the run, behind a break or a change, or in another frame at the same time.
  enum class Leg { first, next, same };

  std::span<double> u() { return layout_.u(y_); }
  std::span<double> w() { return layout_.w(y_); }
  double end() const { return times_.back(); }

  double begin_at(const StartingPoint& start);
  void begin(double t, const State& start);
  double resume(const Checkpoint& checkpoint);
  std::optional<double> first_change(double from, double to);
  void account_for(double from, double limit, double to);
  void watch_ends(double from, double to, bool looked);
  void outputs_until(double limit);
  void finish();
  Checkpoint follow(double t);
  void restart(double t, Leg leg = Leg::next);
  void pass_kink(double t);
  void follow_load(double t);
  void filter_jump(double t, Leg leg);
  void begin_ends(double t);
  // A contact may change where its obstacle has a kink, and a leg begin there once more.
  bool has_passed_kink(double t) const { return t - kink_ <= 2.0 * rounding_of_times(t, end()); }
  void select(bool for_search);
  void take_forms();
  void tell_snapshot(double t);

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
  Sensitivities* sensitivities_;
  std::vector<double> y_;  // the state where the run is
  EnergyBooks books_;
  ContactChanges changes_;
  std::vector<std::size_t> selected_;  // positions of sampled entries
  std::vector<LinearForm> forms_;
  std::span<const PointValues> form_samples_;  // of the last step
  double leg_end_ = 0.0, load_break_ = -std::numeric_limits<double>::infinity();
  double kink_ = load_break_;  // the last one that has been passed
  std::size_t next_output_ = 0;
  bool starts_in_contact_ = false;  // the filter keeps the motion after an impact
};

}  // namespace viscobar

#pragma once

#include "run/parts.hpp"
#include "run/stopwatch.hpp"
#include "viscobar/run/run.hpp"

namespace viscobar {

/// Tells the observers of a part of a run, its clock stopped meanwhile if they ask for it, and counts on the way.
class Notifier {
 public:
  /// `statistics` are those of the parts before; both outlive it.
  Notifier(const Observers& observers, Statistics& statistics)
      : observers_(observers), statistics_(statistics), seconds_before_(statistics.integration_seconds) {}

  void snapshot(const Snapshot& now) {
    if (observers_.snapshot) timed([&] { observers_.snapshot(now); });
  }
  /// Counts it, too. `first_node` is the mesh node of unknown 0, `impulse` that of one that began before; absent: so
  /// far.
  void event(double t, std::size_t first_node, const Contact& contact, Change change, double velocity,
             const std::vector<ChangeSensitivity>& sensitivities = {}, std::optional<double> impulse = std::nullopt) {
    const std::size_t node = contact.joint > 0 ? contact.joint : contact.unknown + first_node;
    Event event{t, contact.where, node, change, velocity, std::nullopt, sensitivities};
    count_change(statistics_, event);
    if (impulse) event.impulse = impulse;
    told(event);
  }
  /// One that has been counted.
  void told(const Event& event) {
    if (observers_.event) timed([&] { observers_.event(event); });
  }
  /// After a step: whether the run goes on. On the clock, which would take longer than a look at the time reached.
  bool progress(double t) { return !observers_.progress || observers_.progress(t) == RunControl::go_on; }
  /// After a checkpoint likewise, by a method whose run goes on as it is.
  bool checkpoint(const Checkpoint& now) {
    RunControl verdict = RunControl::go_on;
    if (observers_.checkpoints->take) timed([&] { verdict = observers_.checkpoints->take(now); });
    return verdict == RunControl::go_on;
  }

  /// Seconds of all parts.
  void count_seconds() { statistics_.integration_seconds = seconds_before_ + watch_.seconds(); }

 private:
  void timed(auto&& call) {
    if (observers_.off_the_clock)
      watch_.outside(call);
    else
      call();
  }

  const Observers& observers_;
  Statistics& statistics_;
  double seconds_before_;
  Stopwatch watch_;
};

}  // namespace viscobar

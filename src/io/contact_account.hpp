#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "io/plot/thinning.hpp"
#include "viscobar/dynamics/run.hpp"

namespace viscobar {

/// Contact of one end over a run, from its events (times) and its reaction at the output times (force).
///
///     impulse = int R dt by the trapezoidal rule,  max_reaction = max R,  both over the output times.
///
/// Contact times are those of the events; an end that presses at the first output time has been closed from there.
class ContactAccount {
 public:
  void add(double time, double reaction);
  void add(const Event& event);
  /// Impulse and greatest reaction from a method that knows them.
  void know(const EndTotals& totals) { impulse_ = totals.impulse, max_reaction_ = totals.max_reaction; }

  std::size_t closings() const { return closings_; }
  /// Time in contact up to `now`.
  double duration(double now) const { return duration_ + (closed_since_ ? now - *closed_since_ : 0.0); }
  double impulse() const { return impulse_; }
  double max_reaction() const { return max_reaction_; }
  /// Times in contact up to `now`, as far as a picture shows them.
  std::vector<plot::Interval> intervals(double now) const;

  static void members(auto& account, auto&& each) {
    each(account.closings_, account.duration_, account.impulse_, account.max_reaction_, account.intervals_,
         account.closed_since_, account.last_);
  }

 private:
  std::size_t closings_ = 0;
  double duration_ = 0.0, impulse_ = 0.0, max_reaction_ = 0.0;
  plot::ThinnedIntervals intervals_;
  std::optional<double> closed_since_;
  struct Sample {
    double time, reaction;
    static void members(auto& sample, auto&& each) { each(sample.time, sample.reaction); }
  };
  std::optional<Sample> last_;
};

}  // namespace viscobar

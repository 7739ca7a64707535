#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <limits>
#include <optional>
#include <span>
#include <vector>

#include "dynamics/indicator.hpp"
#include "integration/accounts/contact_watch.hpp"
#include "integration/bernstein.hpp"
#include "integration/events/agreement.hpp"
#include "integration/stepper.hpp"

namespace viscobar {

/// Finds the contact changes inside one step of a stepper on the step's own interpolant.
///
/// An open contact changes when its indicator p (see Indicators) becomes negative, a closed one when it becomes
/// positive: both are the descent of an oriented indicator through zero. On a step it is a polynomial of the method's
/// order (so the load is interpolated that an undamped massless node adds), taken in Bernstein form, so that no
/// crossing is missed: neither two within a step nor a touch. A descent counts once it passes the uncertainty of the
/// indicator, and its time is that of p = 0, or of the number next to it: a rounding of the time is one of p by the
/// speed of the contact, in a long run more than that of p itself.
///
/// A contact changes only where the motion agrees (see Agreement).
///
/// A stop that lets go (see push_weights()) pushes where its push condition q is negative, too. Closed,
/// it opens at the first descent of -p or -q. Open, it may have been let go inside, p < 0 < q: there it closes where q
/// descends, unless the node has left before, and then where p descends again.
class EventSearch {
 public:
  /// Both outlive it; `size` is that of the state.
  EventSearch(PenalisedSystem& system, LegStepper& stepper, std::size_t size);

  /// Entries of (u, w) that the search samples.
  const std::vector<std::size_t>& sampled_entries() const { return entries_; }
  /// Appends the positions of those that it needs as long as the contacts are as they are.
  void select(std::vector<std::size_t>& positions);
  /// The stepper samples these as long as they are, unless the search selects, and `ends` looks at the samples, too.
  /// They outlive it.
  void selected(std::span<const std::size_t> positions, const std::optional<ContactWatch>& ends) {
    selected_ = positions;
    if (ends && !selects() && !ends->idle()) ends->select_rates(rated_);
  }
  /// Appends the forms whose samples tell what contacts at joints do, as long as these are as they are.
  void ask_for(std::vector<LinearForm>& forms);
  /// The stepper samples so many entries, those of the search the first of them.
  void share(std::size_t sampled);
  /// True if the search selects what the stepper samples.
  bool selects() const { return count_ > few; }

  /// Time of the first change in [begin, end], the step that the stepper has made last. Absent: no contact changes.
  /// Unless the search selects, `ends` looks at the samples, too.
  /// `forms`: the samples of all forms.
  std::optional<double> first_change(double begin, double end, std::optional<ContactWatch>& ends,
                                     std::span<const PointValues> forms);

  /// True if the bar may come to an obstacle that moves in that step, of a run of length `whole`.
  bool may_reach_moving(double begin, double end, double whole);

  /// True if the step's bounds have shown that no contact changes in it, nor an end leaves its range but at the end
  /// of the step: `ends` has not looked at it.
  bool quiet() const { return quiet_; }
  /// Sampled entries at the end of a quiet step.
  std::span<const double> last() const { return last_; }

  /// The contact that changes first.
  std::size_t first_contact() const { return which_; }
  /// True if it does by its push condition: its node is not on the surface.
  bool by_push() const { return by_push_; }
  /// The motion's agreement to its change.
  Agreement& agreement() { return agreement_; }

  /// To be called before changes(): the rates of all contacts at the event, within the step made last.
  void look_at(double begin, double t);

  /// True if contact i changes at the event too: its oriented indicator is used up and falls.
  bool changes(std::size_t i, double t, std::span<const double> y);

  double max_penetration() const { return max_penetration_; }

 private:
  // So few contacts are sooner sampled than bounded. More are those of a span obstacle, whose nodes have mass: each has
  // one entry, its displacement, but for stops at the ends that let go, and for those of joints, which have those of
  // both nodes.
  static constexpr std::size_t few = 4;
  static constexpr std::size_t none = std::numeric_limits<std::size_t>::max();

  // Values of all sampled entries, and their rates where an indicator asks for them.
  struct Sample {
    std::span<const double> values, rates;
  };

  bool proved_quiet(const std::optional<ContactWatch>& ends);
  bool look_at_the_near(std::span<const PointValues> forms);
  bool by_form(std::size_t i) const { return form_of_[i] != none; }
  void find_rated();
  void take_loads(double begin, double end);
  bool lets_go(std::size_t i) const { return lets_go_ && pushes_[i]; }
  void look_up(std::size_t i);  // its weights, as the contacts are
  // Behind the entries of contact i that are needed.
  std::size_t end_of_needed(std::size_t i) const {
    return weights_[i].alone && !lets_go(i) ? first_[i] + 1 : first_[i + 1];
  }
  void select_entries(const std::vector<std::size_t>& contacts);
  bool far(std::size_t i) const;
  bool far(std::size_t i, const PointValues& form);
  // Where a stop changes that lets go, as a part of the step, whether by its push condition, and whether later than
  // that or its indicator says. `values` are those of its oriented indicator, of which `level` is uncertain.
  struct StopChange {
    double s;
    bool by_push, later;
  };
  std::optional<StopChange> change_of_stop(std::size_t i, double begin, double end, std::span<const double> values,
                                           double level);
  std::span<const double> part(std::size_t i, std::span<const double> sampled) const {
    return sampled.subspan(first_[i], first_[i + 1] - first_[i]);
  }
  // At a time of the step.
  Sample at(double t);
  double oriented(std::size_t i, double t, const Sample& sample) const;
  double oriented(std::size_t i, double t, const IndicatorWeights& weights, std::span<const double> values,
                  std::span<const double> rates = {}) const;
  // The same at all points of a step.
  void orient(std::size_t i, const IndicatorWeights& weights, std::span<const PointValues> values,
              std::span<const PointValues> rates, PointValues& out) const;
  double rate(std::size_t i, double begin, double t, double now);
  double polished(double begin, double end, double t, std::size_t i);

  PenalisedSystem& system_;
  const Contacts& contacts_;
  Indicators indicators_;
  LegStepper& stepper_;
  std::size_t count_;
  Agreement agreement_;
  std::vector<std::size_t> entries_, first_;  // entries of contact i: [first_[i], first_[i + 1])
  std::vector<std::size_t> all_, looked_at_;  // contacts, and those that are sampled in this step
  std::vector<std::size_t> near_, rated_;     // entries of the latter, and those whose rates count
  std::span<const std::size_t> selected_;     // positions that the stepper samples, unless the search selects
  std::vector<std::size_t> own_;              // entries of one contact
  std::vector<std::optional<IndicatorWeights>> pushes_;  // of stops that let go
  std::vector<std::size_t> moving_;                      // those whose obstacle moves, and is not looked for so
  std::vector<std::size_t> form_of_;                     // the place of each contact's form, or none
  std::vector<std::size_t> by_entries_;                  // contacts without
  std::vector<double> lowest_, highest_, last_;          // bounds of the entries over the step, and at its end
  std::vector<IndicatorWeights> weights_;                // of those
  std::vector<PointValues> samples_, push_samples_;      // of the oriented indicators of a step
  std::vector<PointValues> loads_;                       // of what these have of the load
  std::vector<double> rates_, present_;  // of the oriented indicators, and those that have accelerations, at an event
  std::vector<double> values_;           // of a sample with rates
  bool with_rates_ = false;              // an indicator asks for them
  bool bounded_ = false;                 // the indicators are those of bounded entries, as long as no contact changes
  bool quiet_ = false;
  bool lets_go_ = false;  // a stop may
  bool by_push_ = false;
  std::size_t which_ = 0;
  double max_penetration_ = 0.0;
};

}  // namespace viscobar

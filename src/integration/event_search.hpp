#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numeric>
#include <optional>
#include <span>
#include <vector>

#include "dynamics/penalised_system.hpp"
#include "integration/bernstein.hpp"

namespace viscobar {

/// Finds the contact changes inside one step of a multistep method on the step's own interpolant.
///
/// An open contact changes when its indicator p (see PenalisedSystem) becomes negative, a closed one when it becomes
/// positive: both are the descent of an oriented indicator through zero. On a step it is a polynomial of the method's
/// order, taken in Bernstein form, so that no crossing is missed: neither two within a step nor a touch. A descent
/// counts once it passes the uncertainty of the indicator, and its time is that of p = 0, or of the number next to it:
/// a rounding of the time is one of p by the speed of the contact, in a long run more than that of p itself. (Only for
/// an undamped massless node under a load that varies in time is p more than a polynomial; the load is then
/// interpolated at the order of the method.)
class EventSearch {
 public:
  explicit EventSearch(PenalisedSystem& system)
      : system_(system), count_(system.contact_count()), samples_(count_ * (Bernstein::max_degree + 1)) {
    for (std::size_t i = 0; i < count_; ++i) {
      first_.push_back(entries_.size());
      for (const std::size_t entry : system.indicator_entries(i)) entries_.push_back(entry);
    }
    all_.resize(count_);
    std::iota(all_.begin(), all_.end(), std::size_t{0});
    looked_at_ = all_;
    first_.push_back(entries_.size());
  }

  /// Entries of (u, w) that the search samples.
  const std::vector<std::size_t>& sampled_entries() const { return entries_; }
  /// The stepper samples so many entries, those of the search the first of them.
  void share(std::size_t sampled) {
    lowest_.resize(sampled);
    highest_.resize(sampled);
    if (system_.collides()) values_.resize(sampled);
  }
  /// Whether the search selects what the stepper samples.
  bool selects() const { return count_ > few; }

  /// Time of the first change in [begin, end], the step that the stepper (see StepwiseRun) has made last.
  /// `uncertainty(i)` is what the indicator of contact i may be wrong by; `sampled(j, t, y)` is told each sample.
  /// Absent: no contact changes.
  template <class Stepper, class Uncertainty, class Sampled>
  std::optional<double> first_change(double begin, double end, Stepper& stepper, Uncertainty&& uncertainty,
                                     Sampled&& sampled) {
    if (selects() && !look_at_the_near(stepper)) return std::nullopt;
    const std::size_t order = stepper.order();
    for (std::size_t j = 0; j <= order; ++j) {
      const double t = j == order ? end : begin + (end - begin) * static_cast<double>(j) / static_cast<double>(order);
      const Sample sample = at(t, stepper);
      for (const std::size_t i : looked_at_) samples_[i * (order + 1) + j] = oriented(i, t, sample);
      sampled(j, t, sample.values);
    }
    double first = 2.0;
    for (const std::size_t i : looked_at_) {
      const std::span<const double> values(samples_.data() + i * (order + 1), order + 1);
      if (system_.closed(i))
        for (double value : values) max_penetration_ = std::max(max_penetration_, system_.penetration_share(i) * value);
      const auto [lowest, highest] = std::ranges::minmax(values);
      const double speed = end > begin ? (highest - lowest) / (end - begin) : 0.0;
      const double of_time = time_rounding(std::max(std::abs(begin), std::abs(end)), speed);
      const auto s = Bernstein::through(values).first_descent(-uncertainty(i) - of_time);
      if (s && *s < first) first = *s, which_ = i;
    }
    if (first > 1.0) return std::nullopt;
    return polished(begin, end, begin + first * (end - begin), which_, stepper);
  }

  /// The contact that changes first.
  std::size_t first_contact() const { return which_; }

  /// To be called before changes(): the rates of all contacts at the event, within the step made last.
  template <class Stepper>
  void look_at(double begin, double t, Stepper& stepper) {
    if (selects()) stepper.select(all_);
    rates_.resize(count_), present_.resize(count_);
    if (!system_.collides()) {
      const std::span<const double> rates = stepper.sample(t, 1);
      for (std::size_t i = 0; i < count_; ++i) rates_[i] = sign(i) * system_.indicator_linear(i, part(i, rates), {});
      return;
    }
    for (std::size_t i = 0; i < count_; ++i) rates_[i] = rate(i, begin, t, stepper);
    const Sample sample = at(t, stepper);
    for (std::size_t i = 0; i < count_; ++i) present_[i] = oriented(i, t, sample);
  }

  /// Whether contact i changes at the event too: its oriented indicator is used up and falls.
  bool changes(std::size_t i, double t, std::span<const double> y, double uncertainty) {
    std::array<double, 4> values{};
    for (std::size_t k = first_[i]; k < first_[i + 1]; ++k) values[k - first_[i]] = y[entries_[k]];
    const std::span<const double> entries = std::span(values).first(first_[i + 1] - first_[i]);
    const double p = system_.indicator_needs_rates(i)
                         ? present_[i]
                         : sign(i) * (system_.indicator_linear(i, entries, {}) + system_.indicator_offset(i, t));
    // Half of it: what is switched here must not be found on the wrong side of the whole a rounding later.
    return rates_[i] < 0.0 && p <= 0.5 * (uncertainty + time_rounding(t, -rates_[i]));
  }

  double max_penetration() const { return max_penetration_; }

 private:
  // So few contacts are sooner sampled than bounded. More are those of a span obstacle, whose nodes have mass: contact
  // i has the one entry i, its displacement.
  static constexpr std::size_t few = 4;

  // Under a span obstacle most nodes are far from a change: their hull over the step proves it, and only the others are
  // sampled. A closed contact is near, too, where it may be deeper than any before. False: none is near.
  template <class Stepper>
  bool look_at_the_near(Stepper& stepper) {
    stepper.select(all_);
    stepper.hull(lowest_, highest_);
    looked_at_.clear();
    for (std::size_t i = 0; i < count_; ++i)
      if (!far(i)) looked_at_.push_back(i);
    if (looked_at_.empty()) return false;
    stepper.select(looked_at_);
    return true;
  }

  bool far(std::size_t i) const {
    const double offset = system_.indicator_offset(i, 0.0);  // a span contact's does not depend on t
    const bool below = system_.contact(i).sign > 0.0;
    const double low = (below ? lowest_[i] : -highest_[i]) + offset,
                 high = (below ? highest_[i] : -lowest_[i]) + offset;
    return system_.closed(i) ? high < 0.0 && -low <= max_penetration_ : low > 0.0;
  }

  std::span<const double> part(std::size_t i, std::span<const double> sampled) const {
    return sampled.subspan(first_[i], first_[i + 1] - first_[i]);
  }
  static double time_rounding(double t, double speed) {
    return 2.0 * std::numeric_limits<double>::epsilon() * std::abs(t) * speed;
  }
  double sign(std::size_t i) const { return system_.closed(i) ? -1.0 : 1.0; }

  // Of all sampled entries: their values, and their rates where an indicator asks for them.
  struct Sample {
    std::span<const double> values, rates;
  };
  template <class Stepper>
  Sample at(double t, Stepper& stepper) {
    const std::span<const double> values = stepper.sample(t, 0);
    if (values_.empty()) return {values, {}};
    std::ranges::copy(values, values_.begin());
    return {values_, stepper.sample(t, 1)};
  }
  double oriented(std::size_t i, double t, const Sample& sample) {
    const auto rates = sample.rates.empty() ? sample.rates : part(i, sample.rates);
    return sign(i) * (system_.indicator_linear(i, part(i, sample.values), rates) + system_.indicator_offset(i, t));
  }

  // Of the oriented indicator. Where that has accelerations their rate is a difference over a part of the step.
  template <class Stepper>
  double rate(std::size_t i, double begin, double t, Stepper& stepper) {
    if (!system_.indicator_needs_rates(i)) {
      const std::span<const double> rates = stepper.sample(t, 1);
      return sign(i) * system_.indicator_linear(i, part(i, rates), {});
    }
    const double before = t - 1e-3 * (t - begin);
    if (before >= t) return 0.0;
    const double now = oriented(i, t, at(t, stepper));
    return (now - oriented(i, before, at(before, stepper))) / (t - before);
  }

  // The descent through the uncertainty is late; Newton's method leads back to the zero.
  template <class Stepper>
  double polished(double begin, double end, double t, std::size_t i, Stepper& stepper) {
    for (int iteration = 0; iteration < 4; ++iteration) {
      const double value = oriented(i, t, at(t, stepper)), slope = rate(i, begin, t, stepper);
      if (!(slope < 0.0)) break;
      const double next = std::clamp(t - value / slope, begin, end);
      if (std::abs(next - t) > 1e-3 * (end - begin) || next == t) break;  // a graze: the descent itself is the event
      t = next;
    }
    return t;
  }

  PenalisedSystem& system_;
  std::size_t count_;
  std::vector<std::size_t> entries_, first_;  // entries of contact i: [first_[i], first_[i + 1])
  std::vector<std::size_t> all_, looked_at_;  // contacts, and those that are sampled in this step
  std::vector<double> lowest_, highest_;      // bounds of the entries over the step
  std::vector<double> samples_;
  std::vector<double> rates_, present_;  // of the oriented indicators, and those that have accelerations, at an event
  std::vector<double> values_;           // of a sample with rates
  std::size_t which_ = 0;
  double max_penetration_ = 0.0;
};

}  // namespace viscobar

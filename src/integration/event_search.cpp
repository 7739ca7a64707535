#include "integration/event_search.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <limits>
#include <numeric>
#include <optional>
#include <span>

#include "integration/approach.hpp"

namespace viscobar {

namespace {

double time_rounding(double t, double speed) {
  return 2.0 * std::numeric_limits<double>::epsilon() * std::abs(t) * speed;
}

}  // namespace

EventSearch::EventSearch(PenalisedSystem& system, LegStepper& stepper)
    : system_(system),
      stepper_(stepper),
      count_(system.contact_count()),
      samples_(count_ * (Bernstein::max_degree + 1)) {
  for (std::size_t i = 0; i < count_; ++i) {
    first_.push_back(entries_.size());
    for (const std::size_t entry : system.indicator_entries(i)) entries_.push_back(entry);
  }
  first_.push_back(entries_.size());
  weights_.resize(count_);
  all_.resize(count_);
  std::iota(all_.begin(), all_.end(), std::size_t{0});
  looked_at_ = all_;
  std::ranges::copy_if(all_, std::back_inserter(moving_), [&](std::size_t i) { return system.moves(i); });
}

void EventSearch::select(std::vector<std::size_t>& positions) {
  bounded_ = true;
  for (std::size_t i = 0; i < count_; ++i) {
    weights_[i] = system_.indicator_weights(i);
    bounded_ &= weights_[i].alone && weights_[i].offset;
    const std::size_t end = weights_[i].alone ? first_[i] + 1 : first_[i + 1];
    for (std::size_t position = first_[i]; position < end; ++position) positions.push_back(position);
  }
}

void EventSearch::share(std::size_t sampled) {
  lowest_.resize(sampled);
  highest_.resize(sampled);
  last_.resize(sampled);
  if (system_.collides()) values_.resize(sampled);
}

std::optional<double> EventSearch::first_change(double begin, double end, std::optional<ContactWatch>& ends) {
  quiet_ = !selects() && proved_quiet(ends);
  if (quiet_ || (selects() && !look_at_the_near())) return std::nullopt;
  with_rates_ = std::ranges::any_of(looked_at_, [&](std::size_t i) { return system_.indicator_needs_rates(i); });
  const std::size_t order = stepper_.order();
  const bool looking = ends && !selects() && !ends->idle();
  if (looking) ends->begin_look(begin, end, order);
  for (std::size_t j = 0; j <= order; ++j) {
    const double t = j == order ? end : begin + (end - begin) * static_cast<double>(j) / static_cast<double>(order);
    const Sample sample = at(t, j);
    for (const std::size_t i : looked_at_) samples_[i * (order + 1) + j] = oriented(i, t, sample);
    if (looking) ends->look_at(j, t, sample.values);
  }
  double first = 2.0;
  for (const std::size_t i : looked_at_) {
    if (system_.moves(i)) continue;
    const std::span<const double> values(samples_.data() + i * (order + 1), order + 1);
    if (system_.closed(i))
      for (double value : values) max_penetration_ = std::max(max_penetration_, system_.penetration_share(i) * value);
    const auto [lowest, highest] = std::ranges::minmax(values);
    if (system_.collides(i) && !system_.closed(i)) stepper_.weights().widen(i, highest);
    const double speed = end > begin ? (highest - lowest) / (end - begin) : 0.0;
    const double of_time = time_rounding(std::max(std::abs(begin), std::abs(end)), speed);
    const auto s = Bernstein::through(values).first_descent(-uncertainty(i) - of_time, 0x1p-52, first);
    if (s && *s < first) first = *s, which_ = i;
  }
  if (first > 1.0) return std::nullopt;
  return polished(begin, end, begin + first * (end - begin), which_);
}

bool EventSearch::may_reach_moving(double begin, double end, double whole) {
  with_rates_ = false;
  for (const std::size_t i : moving_) {
    const Contact& contact = system_.contact(i);
    const auto clearance = [&](double t) {
      return oriented(i, t, at(t)) + (system_.bar().gap(contact, t) - contact.gap);
    };
    const double rounding = system_.clearance_rounding(i, stepper_.weights().largest_displacement());
    if (may_reach_within(whole, clearance, rounding, begin, end)) return true;
  }
  return false;
}

void EventSearch::look_at(double begin, double t) {
  if (selects()) stepper_.select(all_);
  rates_.resize(count_), present_.resize(count_);
  if (!system_.collides()) {
    const std::span<const double> rates = stepper_.sample(t, 1);
    for (std::size_t i = 0; i < count_; ++i) rates_[i] = sign(i) * system_.indicator_weights(i)(part(i, rates));
    return;
  }
  for (std::size_t i = 0; i < count_; ++i) rates_[i] = rate(i, begin, t);
  const Sample sample = at(t);
  for (std::size_t i = 0; i < count_; ++i) present_[i] = oriented(i, t, sample);
}

bool EventSearch::changes(std::size_t i, double t, std::span<const double> y) const {
  if (system_.moves(i)) return false;
  std::array<double, 4> values{};
  for (std::size_t k = first_[i]; k < first_[i + 1]; ++k) values[k - first_[i]] = y[entries_[k]];
  const std::span<const double> entries = std::span(values).first(first_[i + 1] - first_[i]);
  const double p =
      system_.indicator_needs_rates(i) ? present_[i] : oriented(i, t, system_.indicator_weights(i), entries);
  // Half the tolerance, so that a contact switched now is not found on the wrong side by the next check.
  return rates_[i] < 0.0 && p <= 0.5 * (uncertainty(i) + time_rounding(t, -rates_[i]));
}

// A spring answers to its own clearance, which is known to rounding. The pull on a rigid contact opens it as soon as it
// has an effect. On a fine mesh the error of a step shows in the reaction as more than that, and a bar that comes to
// rest may toggle: then, and for that contact alone, the reaction counts as uncertain by a share of that error.
inline double EventSearch::uncertainty(std::size_t i) const {
  const ErrorWeights& weights = stepper_.weights();
  if (system_.holds(i)) {
    if (!system_.closed(i)) return system_.collides(i) ? weights.tolerance_at(i) : weights.displacement_tolerance();
    const double least = weights.negligible_reaction(system_.bar().spacing_at(system_.contact(i).unknown));
    if (i != distrusted_) return least;
    return least + share_ * (system_.collides(i) ? ErrorWeights::inertial_share : 1.0) * weights.reaction_tolerance();
  }
  double rounding = system_.indicator_rounding(i, weights.largest_displacement());
  if (system_.relaxes(i)) rounding += weights.reaction_tolerance() / (1.0 + system_.relative_stiffness(i));
  return i == distrusted_ ? rounding + weights.displacement_tolerance() * share_ : rounding;
}

// Mostly the bounds of a step prove that nothing happens in it, and take a part of what samples do.
bool EventSearch::proved_quiet(const std::optional<ContactWatch>& ends) {
  const bool watched = ends && !ends->idle();
  if (!bounded_ || (watched && !ends->springs())) return false;
  if (!stepper_.hull(lowest_, highest_, last_)) return false;
  for (std::size_t i = 0; i < count_; ++i)
    if (!far(i)) return false;
  for (std::size_t i = 0; i < count_; ++i)
    if (system_.collides(i) && !system_.closed(i))
      stepper_.weights().widen(i, system_.contact(i).sign * last_[first_[i]] + system_.indicator_offset(i, 0.0));
  return !watched || ends->within(lowest_, highest_, last_);
}

// Under a span obstacle most nodes are far from a change: their hull over the step proves it, and only the others are
// sampled. A closed contact is near, too, where it may be deeper than any before. False: none is near.
bool EventSearch::look_at_the_near() {
  stepper_.select(all_);
  stepper_.hull(lowest_, highest_, last_);
  looked_at_.clear();
  for (std::size_t i = 0; i < count_; ++i)
    if (!far(i)) looked_at_.push_back(i);
  if (looked_at_.empty()) return false;
  for (const std::size_t i : looked_at_) weights_[i] = system_.indicator_weights(i);
  stepper_.select(looked_at_);
  return true;
}

bool EventSearch::far(std::size_t i) const {
  if (system_.moves(i)) return true;
  const double offset = system_.indicator_offset(i, 0.0);  // which does not depend on t
  const double lowest = lowest_[first_[i]], highest = highest_[first_[i]];
  const bool below = system_.contact(i).sign > 0.0;
  const double low = (below ? lowest : -highest) + offset, high = (below ? highest : -lowest) + offset;
  return system_.closed(i) ? high < 0.0 && -low <= max_penetration_ : low > 0.0;
}

inline EventSearch::Sample EventSearch::at(double t, std::optional<std::size_t> point) {
  const auto sample = [&](int derivative) {
    return point ? stepper_.sample_point(*point, t, derivative) : stepper_.sample(t, derivative);
  };
  const std::span<const double> values = sample(0);
  if (!with_rates_) return {values, {}};
  std::ranges::copy(values, values_.begin());
  return {values_, sample(1)};
}

inline double EventSearch::oriented(std::size_t i, double t, const Sample& sample) const {
  const auto rates = sample.rates.empty() ? sample.rates : part(i, sample.rates);
  return oriented(i, t, weights_[i], part(i, sample.values), rates);
}

inline double EventSearch::oriented(std::size_t i, double t, const PenalisedSystem::IndicatorWeights& weights,
                                    std::span<const double> values, std::span<const double> rates) const {
  return sign(i) * (weights(values, rates) + (weights.offset ? *weights.offset : system_.indicator_offset(i, t)));
}

// Of the oriented indicator. Where that has accelerations their rate is a difference over a part of the step.
double EventSearch::rate(std::size_t i, double begin, double t) {
  if (!system_.indicator_needs_rates(i)) {
    const std::span<const double> rates = stepper_.sample(t, 1);
    return sign(i) * weights_[i](part(i, rates));
  }
  const double before = t - 1e-3 * (t - begin);
  if (before >= t) return 0.0;
  const double now = oriented(i, t, at(t));
  return (now - oriented(i, before, at(before))) / (t - before);
}

// The descent through the uncertainty is late; Newton's method leads back to the zero, unless the indicator grazes it:
// then it is no line on the way there, and the descent itself is the event.
double EventSearch::polished(double begin, double end, double t, std::size_t i) {
  double value = oriented(i, t, at(t)), slope = rate(i, begin, t);
  for (int iteration = 0; iteration < 4 && slope < 0.0; ++iteration) {
    const double next = std::clamp(t - value / slope, begin, end);
    if (next == t) break;
    const double left = oriented(i, next, at(next)), steepness = rate(i, begin, next) / slope;
    if (steepness < 0.5 || steepness > 2.0 || std::abs(left) > 0.5 * std::abs(value)) break;
    t = next, value = left, slope *= steepness;
  }
  return t;
}

}  // namespace viscobar

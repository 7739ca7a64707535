#include "integration/events/event_search.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <iterator>
#include <limits>
#include <numeric>
#include <optional>
#include <span>

#include "dynamics/obstacle_motion.hpp"
#include "integration/events/approach.hpp"

namespace viscobar {

namespace {

double time_rounding(double t, double speed) {
  return 2.0 * std::numeric_limits<double>::epsilon() * std::abs(t) * speed;
}

}  // namespace

EventSearch::EventSearch(PenalisedSystem& system, LegStepper& stepper, std::size_t size)
    : system_(system),
      contacts_(system.contacts()),
      indicators_(contacts_, system.load()),
      stepper_(stepper),
      count_(system.contacts().size()),
      agreement_(system, stepper, size, [this](std::size_t i, double t) { return oriented(i, t, at(t)); }),
      form_of_(count_, none),
      samples_(count_) {
  first_.reserve(count_ + 1);
  entries_.reserve(4 * count_);  // of an end
  for (std::size_t i = 0; i < count_; ++i) {
    first_.push_back(entries_.size());
    for (const std::size_t entry : indicators_.entries(i)) entries_.push_back(entry);
  }
  first_.push_back(entries_.size());
  for (std::size_t i = 0; i < count_ && system.contacts().has_stops(); ++i)
    pushes_.push_back(push_weights(system.contacts(), i));
  lets_go_ = std::ranges::any_of(pushes_, [](const auto& push) { return push.has_value(); });
  if (lets_go_) push_samples_.resize(samples_.size());
  weights_.resize(count_);
  all_.resize(count_);
  std::iota(all_.begin(), all_.end(), std::size_t{0});
  looked_at_ = all_;
  std::ranges::copy_if(all_, std::back_inserter(moving_), [&](std::size_t i) { return contacts_[i].moves; });
}

void EventSearch::select(std::vector<std::size_t>& positions) {
  bounded_ = true;
  for (std::size_t i = 0; i < count_; ++i) {
    look_up(i);
    const bool of_joint = contacts_[i].joint > 0 && !contacts_.closed(i);
    bounded_ &= (weights_[i].alone || of_joint) && weights_[i].offset;
    for (std::size_t k = first_[i], behind = end_of_needed(i); k < behind; ++k) positions.push_back(k);
  }
  find_rated();
}

void EventSearch::ask_for(std::vector<LinearForm>& forms) {
  by_entries_.clear();
  if (selects()) near_.clear();
  for (std::size_t i = 0; i < count_ && selects(); ++i) {
    look_up(i);
    form_of_[i] = none;
    if (contacts_[i].joint == 0 || !weights_[i].offset || contacts_.holds_mass(i) || lets_go(i)) {
      by_entries_.push_back(i);
      continue;
    }
    form_of_[i] = forms.size();
    LinearForm& form = forms.emplace_back();
    for (const std::size_t k : {1, 2}) form.add(entries_[first_[i] + k], weights_[i].values[k]);
  }
}

void EventSearch::share(std::size_t sampled) {
  lowest_.resize(sampled);
  highest_.resize(sampled);
  last_.resize(sampled);
  near_.resize(sampled);
  rated_.reserve(sampled);
  own_.reserve(sampled);
  std::iota(near_.begin(), near_.end(), std::size_t{0});
  if (contacts_.collides()) values_.resize(sampled);
}

std::optional<double> EventSearch::first_change(double begin, double end, std::optional<ContactWatch>& ends,
                                                std::span<const PointValues> forms) {
  quiet_ = !selects() && proved_quiet(ends);
  if (quiet_ || (selects() && !look_at_the_near(forms))) return std::nullopt;
  const std::size_t order = stepper_.order();
  const std::span<const PointValues> points =
      near_.empty() ? std::span<const PointValues>() : stepper_.samples(begin, end, 0, near_);
  std::span<const PointValues> rates;
  if (!rated_.empty()) rates = stepper_.samples(begin, end, 1, rated_);
  take_loads(begin, end);
  for (const std::size_t i : looked_at_) {
    if (by_form(i)) continue;
    orient(i, weights_[i], points, rates, samples_[i]);
    if (lets_go(i)) orient(i, *pushes_[i], points, {}, push_samples_[i]);
  }
  if (ends && !selects() && !ends->idle()) ends->look_at(begin, end, order, points, rates);
  double first = 2.0;
  bool later = false, narrowed = false;
  // Where a contact changes is looked for by its own entries.
  const auto narrow = [&](std::size_t i) {
    own_.clear();
    for (std::size_t k = first_[i], behind = end_of_needed(i); k < behind; ++k) own_.push_back(k);
    stepper_.select(own_);
    narrowed = true;
  };
  const auto widened = [&](auto found) {
    if (narrowed && !selects()) stepper_.select(selected_);
    return found;
  };
  for (const std::size_t i : looked_at_) {
    if (contacts_[i].moves) continue;
    const std::span<const double> values = std::span(samples_[i]).first(order + 1);
    if (const double share = contacts_[i].penetration_share(); contacts_.closed(i) && share > 0.0)
      max_penetration_ = share * Bernstein::through(values).largest(max_penetration_ / share);
    double lowest = values[0], highest = lowest;
    for (const double value : values) lowest = std::min(lowest, value), highest = std::max(highest, value);
    if (contacts_[i].collides && !contacts_.closed(i)) stepper_.weights().widen(i, highest);
    const double speed = end > begin ? (highest - lowest) / (end - begin) : 0.0;
    const double of_time = time_rounding(std::max(std::abs(begin), std::abs(end)), speed);
    if (lets_go_ && lets_go(i)) {
      if (narrowed) narrow(i);
      const auto change = change_of_stop(i, begin, end, values, -agreement_.uncertainty(i) - of_time);
      if (change && change->s < first) first = change->s, which_ = i, later = change->later, by_push_ = change->by_push;
      continue;
    }
    const Bernstein p = Bernstein::through(values);
    const auto descent = p.first_descent(-agreement_.uncertainty(i) - of_time, 0x1p-52, first);
    if (!descent) continue;
    narrow(i);
    const auto s = agreement_.to_change(i, begin, end, *descent, p);
    if (s && *s < first) first = *s, which_ = i, later = s != descent, by_push_ = false;
  }
  if (first > 1.0) return widened(std::optional<double>());
  const double t = begin + first * (end - begin);
  if (later || (lets_go(which_) && agreement_.against(which_, t) > 0.0))  // to_change() has asked the others
    return widened(std::optional(t));
  narrow(which_);
  if (by_push_) std::swap(weights_[which_], *pushes_[which_]);
  const double time = polished(begin, end, t, which_);
  if (by_push_) std::swap(weights_[which_], *pushes_[which_]);
  return widened(std::optional(!by_push_ && agreement_.against(which_, time) > 0.0 ? t : time));
}

std::optional<EventSearch::StopChange> EventSearch::change_of_stop(std::size_t i, double begin, double end,
                                                                   std::span<const double> values, double level) {
  const std::size_t order = values.size() - 1;
  const std::span<const double> pushes = std::span(push_samples_[i]).first(order + 1);
  const auto [weakest, strongest] = std::ranges::minmax(pushes, {}, [](double value) { return std::abs(value); });
  // Rounding of the condition's parts: a velocity is known to that of the largest.
  const double rounding = 64.0 * std::numeric_limits<double>::epsilon() *
                          (std::max(std::abs(weakest), std::abs(strongest)) + std::abs(*pushes_[i]->offset) +
                           std::abs(pushes_[i]->values[2]) * stepper_.weights().largest_velocity());
  const auto lets_go = Bernstein::through(pushes).first_descent(level - rounding);
  const auto first = [](std::optional<double> s, bool by_push) {
    return s ? std::optional(StopChange{*s, by_push, false}) : std::nullopt;
  };
  const auto by_depth = Bernstein::through(values).first_descent(level);
  if (contacts_.closed(i))
    return by_depth && !(lets_go && *lets_go < *by_depth) ? first(by_depth, false) : first(lets_go, true);
  if (!by_depth) return std::nullopt;
  if (*by_depth > 0.0) {
    const auto s = agreement_.to_change(i, begin, end, *by_depth, Bernstein());
    return s ? std::optional(StopChange{*s, false, s != by_depth}) : std::nullopt;
  }
  // It has been let go inside.
  std::array<double, Bernstein::max_degree + 1> outwards{};
  std::ranges::transform(values, outwards.begin(), std::negate());
  const auto leaves = Bernstein::through(std::span(outwards).first(order + 1)).first_descent(0.0);
  if (!leaves || (lets_go && *lets_go < *leaves)) return first(lets_go, true);
  const double from = begin + *leaves * (end - begin);
  const auto again =
      agreement_.polynomial(from, end, [&](double t) { return oriented(i, t, at(t)); }).first_descent(level);
  return again ? first(*leaves + *again * (1.0 - *leaves), false) : std::nullopt;
}

bool EventSearch::may_reach_moving(double begin, double end, double whole) {
  if (selects() && !moving_.empty()) select_entries(moving_);  // the step before may have left them out
  for (const std::size_t i : moving_) {
    const Contact& contact = contacts_[i];
    const auto clearance = [&](double t) {
      return oriented(i, t, at(t)) + (system_.bar().frame().gap(contact, t) - contact.gap);
    };
    const double rounding = contacts_[i].clearance_rounding(stepper_.weights().largest_displacement());
    if (may_reach_within(whole, clearance, breaks_of_gap(system_.bar(), contact), rounding, begin, end)) return true;
  }
  return false;
}

void EventSearch::look_at(double begin, double t) {
  if (selects()) select_entries(all_);
  rates_.resize(count_), present_.resize(count_);
  if (!contacts_.collides()) {
    const std::span<const double> rates = stepper_.sample(t, 1);
    for (std::size_t i = 0; i < count_; ++i)
      rates_[i] = orientation(contacts_, i) * indicators_.weights(i)(part(i, rates));
    return;
  }
  const Sample sample = at(t);
  for (std::size_t i = 0; i < count_; ++i) present_[i] = oriented(i, t, sample);
  for (std::size_t i = 0; i < count_; ++i) rates_[i] = rate(i, begin, t, present_[i]);
}

bool EventSearch::changes(std::size_t i, double t, std::span<const double> y) {
  if (contacts_[i].moves) return false;
  std::array<double, 8> values{};
  for (std::size_t k = first_[i]; k < first_[i + 1]; ++k) values[k - first_[i]] = y[entries_[k]];
  const std::span<const double> entries = std::span(values).first(first_[i + 1] - first_[i]);
  const double p = contacts_.holds_mass(i) ? present_[i] : oriented(i, t, indicators_.weights(i), entries);
  // One of two mirror images may be ahead by rounding; one that has just opened does not close by it.
  const ErrorWeights& weights = stepper_.weights();
  const double rounding = contacts_[i].changes_by_row
                              ? contacts_[i].clearance_rounding(weights.largest_displacement())
                              : 32.0 * std::numeric_limits<double>::epsilon() * weights.largest_velocity();
  if (agreement_.against(i, t, y) > -orientation(contacts_, i) * rounding) return false;
  // Half the tolerance, so that a contact switched now is not found on the wrong side by the next check.
  return rates_[i] < 0.0 && p <= 0.5 * (agreement_.uncertainty(i) + time_rounding(t, -rates_[i]));
}

// Mostly the bounds of a step prove that nothing happens in it, and take a part of what samples do.
bool EventSearch::proved_quiet(const std::optional<ContactWatch>& ends) {
  const bool watched = ends && !ends->idle();
  if (!bounded_ || (watched && !ends->springs())) return false;
  if (!stepper_.hull(lowest_, highest_, last_)) return false;
  for (std::size_t i = 0; i < count_; ++i)
    if (!far(i)) return false;
  for (std::size_t i = 0; i < count_; ++i)
    if (contacts_[i].collides && !contacts_.closed(i))
      stepper_.weights().widen(i, (contacts_[i].joint > 0 ? last_[first_[i] + 1] - last_[first_[i] + 2]
                                                          : contacts_[i].sign * last_[first_[i]]) +
                                      indicators_.offset(i, 0.0));
  return !watched || ends->within(lowest_, highest_, last_);
}

// Under a span obstacle most nodes are far from a change: their hull over the step proves it, and only the others are
// sampled. A closed contact is near, too, where it may be deeper than any before. False: none is near.
bool EventSearch::look_at_the_near(std::span<const PointValues> forms) {
  looked_at_ = by_entries_;
  if (!by_entries_.empty()) {
    select_entries(looked_at_);
    if (stepper_.hull(lowest_, highest_, last_)) std::erase_if(looked_at_, [this](std::size_t i) { return far(i); });
    select_entries(looked_at_);
    find_rated();
  }
  for (std::size_t i = 0; i < count_; ++i)
    if (by_form(i) && !far(i, forms[form_of_[i]])) looked_at_.push_back(i);
  std::ranges::sort(looked_at_);
  return !looked_at_.empty();
}

// Orients the samples of its form. They tell that contact i is far if they, and what a polynomial may leave their range
// by, are on one side.
bool EventSearch::far(std::size_t i, const PointValues& form) {
  const double direction = orientation(contacts_, i), offset = *weights_[i].offset;
  auto p = Points<16>::Map(samples_[i].data());
  p = direction * (Points<16>::Map(form.data()) + offset);
  const std::span<const double> values = std::span(samples_[i]).first(stepper_.order() + 1);
  double least = values[0], most = least;
  for (const double value : values) least = std::min(least, value), most = std::max(most, value);
  const double excess = Bernstein::excess(values.size() - 1) * (most - least);
  if (contacts_[i].collides && !contacts_.closed(i)) stepper_.weights().widen(i, most);
  if (!(least - excess > 0.0)) return false;
  const double share = contacts_[i].penetration_share();
  if (contacts_.closed(i) && share * (most + excess) > max_penetration_)
    max_penetration_ = share * Bernstein::through(values).largest(max_penetration_ / share);
  return true;
}

// Time by time, since a load is evaluated once for all that ask for it at one time.
void EventSearch::take_loads(double begin, double end) {
  if (!system_.load().acts()) return;
  loads_.resize(count_);
  for (std::size_t j = 0, order = stepper_.order(); j <= order; ++j) {
    const double t = point_of(begin, end, order, j);
    for (const std::size_t i : looked_at_)
      if (!weights_[i].offset)
        loads_[i][j] = weights_[i].varying.of_load([&](std::size_t k) { return system_.load().alone(k, t); });
  }
}

void EventSearch::find_rated() {
  rated_.clear();
  for (const std::size_t i : looked_at_)
    for (std::size_t k = first_[i] + 2; contacts_.holds_mass(i) && k < first_[i + 1]; ++k) rated_.push_back(k);
  with_rates_ = !rated_.empty();
}

void EventSearch::look_up(std::size_t i) {
  weights_[i] = indicators_.weights(i);
  if (lets_go(i)) pushes_[i] = push_weights(contacts_, i);
}

void EventSearch::select_entries(const std::vector<std::size_t>& contacts) {
  near_.clear();
  for (const std::size_t i : contacts)
    for (std::size_t position = first_[i]; position < first_[i + 1]; ++position) near_.push_back(position);
  stepper_.select(near_);
}

bool EventSearch::far(std::size_t i) const {
  if (contacts_[i].moves) return true;
  if (contacts_[i].joint > 0) {
    const std::size_t b = first_[i] + 1, a = first_[i] + 2;
    return !contacts_.closed(i) && lowest_[b] - highest_[a] + indicators_.offset(i, 0.0) > 0.0;
  }
  if (lets_go_ && lets_go(i) && contacts_.closed(i)) return false;
  // Here it does not depend on t.
  const double offset = weights_[i].offset ? *weights_[i].offset : indicators_.offset(i, 0.0);
  const double lowest = lowest_[first_[i]], highest = highest_[first_[i]];
  const bool below = contacts_[i].sign > 0.0;
  const double low = (below ? lowest : -highest) + offset, high = (below ? highest : -lowest) + offset;
  return contacts_.closed(i) ? high < 0.0 && -low <= max_penetration_ : low > 0.0;
}

inline EventSearch::Sample EventSearch::at(double t) {
  const std::span<const double> values = stepper_.sample(t, 0);
  if (!with_rates_) return {values, {}};
  std::ranges::copy(values, values_.begin());
  return {values_, stepper_.sample(t, 1)};
}

inline double EventSearch::oriented(std::size_t i, double t, const Sample& sample) const {
  const auto rates = sample.rates.empty() ? sample.rates : part(i, sample.rates);
  return oriented(i, t, weights_[i], part(i, sample.values), rates);
}

inline double EventSearch::oriented(std::size_t i, double t, const IndicatorWeights& weights,
                                    std::span<const double> values, std::span<const double> rates) const {
  return orientation(contacts_, i) *
         (weights(values, rates) + (weights.offset ? *weights.offset : indicators_.offset(i, t)));
}

void EventSearch::orient(std::size_t i, const IndicatorWeights& weights, std::span<const PointValues> values,
                         std::span<const PointValues> rates, PointValues& out) const {
  const std::size_t first = first_[i], count = first_[i + 1] - first, order = stepper_.order();
  PointValues sum;
  // Not inlined: gcc would make vectors of the few entries instead of the points.
  const auto add = [&sum](double weight, const PointValues& entry) __attribute__((noinline)) {
    for (std::size_t j = 0; j < sum.size(); ++j) sum[j] += weight * entry[j];
  };
  if (weights.alone) {
    for (std::size_t j = 0; j < sum.size(); ++j) sum[j] = weights.values[0] * values[first][j];
  } else {
    const PointValues &one = values[first + 1], &other = values[first + 2];
    for (std::size_t j = 0; j < sum.size(); ++j) sum[j] = weights.values[1] * one[j] + weights.values[2] * other[j];
    for (std::size_t k = 3; weights.sided && k < count; ++k) add(weights.values[k], values[first + k]);
    for (std::size_t k = 2; !rates.empty() && k < count; ++k) add(weights.rates[k - 2], rates[first + k]);
  }
  const double direction = orientation(contacts_, i), offset = weights.offset.value_or(weights.varying.rest);
  for (std::size_t j = 0; j < sum.size(); ++j) out[j] = direction * (sum[j] + offset);
  for (std::size_t j = 0; !weights.offset && j <= order; ++j) out[j] = direction * (sum[j] + offset + loads_[i][j]);
}

// Rate of the oriented indicator, which is `now`. Where that has accelerations their rate is a difference over a part
// of the step.
double EventSearch::rate(std::size_t i, double begin, double t, double now) {
  if (!contacts_.holds_mass(i)) {
    const std::span<const double> rates = stepper_.sample(t, 1);
    return orientation(contacts_, i) * weights_[i](part(i, rates));
  }
  const double before = t - 1e-3 * (t - begin);
  if (before >= t) return 0.0;
  return (now - oriented(i, before, at(before))) / (t - before);
}

// The descent through the uncertainty is late; Newton's method leads back to the zero, unless the indicator grazes it:
// then it is no line on the way there, and the descent itself is the event.
double EventSearch::polished(double begin, double end, double t, std::size_t i) {
  double value = oriented(i, t, at(t)), slope = rate(i, begin, t, value);
  for (int iteration = 0; iteration < 4 && slope < 0.0; ++iteration) {
    const double next = std::clamp(t - value / slope, begin, end);
    if (next == t) break;
    const double left = oriented(i, next, at(next)), steepness = rate(i, begin, next, left) / slope;
    if (steepness < 0.5 || steepness > 2.0 || std::abs(left) > 0.5 * std::abs(value)) break;
    t = next, value = left, slope *= steepness;
  }
  return t;
}

}  // namespace viscobar

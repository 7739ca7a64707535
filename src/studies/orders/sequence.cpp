#include <algorithm>
#include <cmath>
#include <span>

#include "viscobar/studies/orders/observed_order.hpp"

namespace viscobar {

namespace {

constexpr double above_floor = 10.0;
constexpr double roughness = 1.5;  // of what powers agree to
constexpr double most_order = 50.0;

double between(const Sequence& s, std::size_t i, std::size_t j) {
  return std::log(s.distance[i] / s.distance[j]) / std::log(s.x[i] / s.x[j]);
}

bool told(const Sequence& s, std::size_t i) {
  return s.distance[i] > 0.0 && std::isfinite(s.distance[i]) && s.distance[i] >= above_floor * s.floor[i];
}

/// How far the floors may put the power from i to j wrong.
double by_floors(const Sequence& s, std::size_t i, std::size_t j) {
  return (s.floor[i] / s.distance[i] + s.floor[j] / s.distance[j]) / std::log(s.x[i] / s.x[j]);
}

/// The slope of a range whose distances are told, where its powers agree; its bound is what they show by themselves.
std::optional<SequenceOrder> slope_of(const Sequence& s, std::size_t first, std::size_t last) {
  const std::size_t powers = last - first;
  if (powers < 2) return std::nullopt;
  double lowest = between(s, first, first + 1), highest = lowest;
  for (std::size_t i = first + 1; i < last; ++i) {
    lowest = std::min(lowest, between(s, i, i + 1));
    highest = std::max(highest, between(s, i, i + 1));
  }
  if (highest - lowest > s.within) return std::nullopt;
  const auto slope =
      observed_order(std::span(s.x).subspan(first, powers + 1), std::span(s.distance).subspan(first, powers + 1));
  if (!slope) return std::nullopt;
  const std::size_t middle = last - std::max<std::size_t>(1, powers / 2);
  SequenceOrder order{*slope, 0.0, first, last};
  order.bound = std::max(
      {2.0 * slope->standard_error, std::abs(between(s, middle, last) - slope->order), by_floors(s, first, last)});
  return order;
}

std::optional<SequenceOrder> if_bounded(const Sequence& s, const std::optional<SequenceOrder>& order) {
  return order && order->bound <= s.within ? order : std::nullopt;
}

/// The order of a range whose distances are told: it is that of x -> 0, too.
std::optional<SequenceOrder> order_of(const Sequence& s, std::size_t first, std::size_t last) {
  std::optional<SequenceOrder> order = slope_of(s, first, last);
  if (!order) return std::nullopt;
  const bool before = first > 0 && told(s, first - 1);
  // Two powers may agree by chance, where the one before them is another.
  if (last - first == 2 && before && std::abs(between(s, first - 1, first) - order->order) > roughness * s.within)
    return std::nullopt;
  // A third of the range tells a drift better than its last powers do.
  if (const std::size_t part = std::max<std::size_t>(1, (last - first) / 3); last - first > 2 || before) {
    const double end = between(s, last - part, last), middle = between(s, last - 2 * part, last - part),
                 now = end - middle, change = middle - between(s, last - 3 * part, last - 2 * part);
    if (now * change > 0.0 && std::abs(now) > by_floors(s, last - part, last)) {
      const double ratio = std::max(0.1, change / now - 1.0);
      order->bound = std::max(order->bound, std::abs(end - order->order) + std::abs(now) * (1.0 + 2.0 / ratio));
    }
  }
  return if_bounded(s, order);
}

}  // namespace

double fall_of_changes(double r_1, double r_2, double p) {
  if (p == 0.0) return std::log(r_1) / std::log(r_2);
  return std::expm1(p * std::log(r_1)) / -std::expm1(-p * std::log(r_2));
}

std::optional<double> power_of_changes(double r_1, double r_2, double first, double second) {
  if (!(first > 0.0) || !(second > 0.0) || !std::isfinite(first / second)) return std::nullopt;
  if (r_1 == r_2) return std::log(first / second) / std::log(r_1);
  double low = -most_order, high = most_order;
  while (high - low > 1e-6) {
    const double middle = 0.5 * (low + high);
    (fall_of_changes(r_1, r_2, middle) < first / second ? low : high) = middle;
  }
  return low;
}

std::vector<SequenceOrder> Sequence::settled() const {
  std::vector<SequenceOrder> ranges;
  for (std::size_t first = 0; first + 2 < x.size();) {
    std::size_t end = first;
    while (end < x.size() && told(*this, end)) ++end;
    std::optional<SequenceOrder> found;
    for (std::size_t last = end; last-- > first + 1 && !found;) found = order_of(*this, first, last);
    if (found) ranges.push_back(*found);
    first = found ? found->last : first + 1;
  }
  return ranges;
}

std::optional<std::size_t> Sequence::last_told() const {
  for (std::size_t i = x.size(); i-- > 0;)
    if (told(*this, i)) return i;
  return std::nullopt;
}

std::optional<SequenceOrder> Sequence::order() const {
  const auto last = last_told();
  std::size_t first = last.value_or(0);
  while (first > 0 && told(*this, first - 1)) --first;
  for (; last && first + 2 <= *last; ++first)
    if (const auto found = order_of(*this, first, *last)) return found;
  return std::nullopt;
}

std::optional<SequenceOrder> Sequence::order_within(const std::optional<SequenceOrder>& nearer) const {
  if (!nearer) return std::nullopt;
  std::size_t last = nearer->first;
  while (last < nearer->last && told(*this, last + 1)) ++last;
  return told(*this, nearer->first) ? if_bounded(*this, slope_of(*this, nearer->first, last)) : std::nullopt;
}

std::optional<double> Sequence::power(std::size_t i) const {
  if (i + 1 >= x.size() || !(distance[i] > 0.0 && distance[i + 1] > 0.0)) return std::nullopt;
  return between(*this, i, i + 1);
}

std::optional<std::size_t> Sequence::around(double level) const {
  for (std::size_t i = 0; i + 1 < x.size(); ++i)
    if (distance[i] >= level && level >= distance[i + 1] && distance[i] > distance[i + 1] &&
        distance[i + 1] > floor[i + 1])
      return i;
  return std::nullopt;
}

std::optional<double> Sequence::where(double level) const {
  const auto i = around(level);
  return i ? std::optional(x[*i] * std::pow(level / distance[*i], 1.0 / *power(*i))) : std::nullopt;
}

bool Sequence::falls(double theory) const {
  const std::size_t count = x.size();
  if (count == 0) return false;
  if (distance.back() <= above_floor * floor.back()) return true;
  if (count < 3) return false;
  std::size_t first = count - 3;
  while (first > 0 && x[first] < 3.0 * x.back()) --first;
  for (std::size_t i = first; i + 1 < count; ++i)
    if (!(distance[i + 1] < distance[i])) return false;
  return x[first] >= 3.0 * x.back() && between(*this, first, count - 1) >= 0.25 * theory;
}

}  // namespace viscobar

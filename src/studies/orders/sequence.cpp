#include <algorithm>
#include <cmath>
#include <span>

#include "viscobar/studies/orders/observed_order.hpp"

namespace viscobar {

namespace {

constexpr double above_floor = 10.0;
constexpr double agreement = 0.04, largest_bound = 0.04, roughness = 0.06;

double power(const Sequence& s, std::size_t i, std::size_t j) {
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
  double lowest = power(s, first, first + 1), highest = lowest;
  for (std::size_t i = first + 1; i < last; ++i) {
    lowest = std::min(lowest, power(s, i, i + 1));
    highest = std::max(highest, power(s, i, i + 1));
  }
  if (highest - lowest > agreement) return std::nullopt;
  const auto slope =
      observed_order(std::span(s.x).subspan(first, powers + 1), std::span(s.distance).subspan(first, powers + 1));
  if (!slope) return std::nullopt;
  const std::size_t middle = last - std::max<std::size_t>(1, powers / 2);
  SequenceOrder order{*slope, 0.0, first, last};
  order.bound = std::max(
      {2.0 * slope->standard_error, std::abs(power(s, middle, last) - slope->order), by_floors(s, first, last)});
  return order;
}

std::optional<SequenceOrder> if_bounded(const std::optional<SequenceOrder>& order) {
  return order && order->bound <= largest_bound ? order : std::nullopt;
}

/// The order of a range whose distances are told: it is that of x -> 0, too.
std::optional<SequenceOrder> order_of(const Sequence& s, std::size_t first, std::size_t last) {
  std::optional<SequenceOrder> order = slope_of(s, first, last);
  if (!order) return std::nullopt;
  const bool before = first > 0 && told(s, first - 1);
  // Two powers may agree by chance, where the one before them is another.
  if (last - first == 2 && before && std::abs(power(s, first - 1, first) - order->order) > roughness)
    return std::nullopt;
  // A third of the range tells a drift better than its last powers do.
  if (const std::size_t part = std::max<std::size_t>(1, (last - first) / 3); last - first > 2 || before) {
    const double end = power(s, last - part, last), middle = power(s, last - 2 * part, last - part), now = end - middle,
                 change = middle - power(s, last - 3 * part, last - 2 * part);
    if (now * change > 0.0 && std::abs(now) > by_floors(s, last - part, last)) {
      const double ratio = std::max(0.1, change / now - 1.0);
      order->bound = std::max(order->bound, std::abs(end - order->order) + std::abs(now) * (1.0 + 2.0 / ratio));
    }
  }
  return if_bounded(order);
}

}  // namespace

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
  return told(*this, nearer->first) ? if_bounded(slope_of(*this, nearer->first, last)) : std::nullopt;
}

std::optional<double> Sequence::where(double level) const {
  for (std::size_t i = 0; i + 1 < x.size(); ++i)
    if (distance[i] >= level && level >= distance[i + 1] && distance[i] > distance[i + 1] && distance[i + 1] > 0.0)
      return x[i] * std::pow(level / distance[i], 1.0 / power(*this, i, i + 1));
  return std::nullopt;
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
  return x[first] >= 3.0 * x.back() && power(*this, first, count - 1) >= 0.25 * theory;
}

}  // namespace viscobar

#include <algorithm>
#include <cmath>
#include <span>

#include "viscobar/studies/orders/observed_order.hpp"

namespace viscobar {

namespace {

constexpr double above_floor = 10.0;
constexpr double agreement_of_two = 0.03, agreement_of_more = 0.06, largest_bound = 0.04, roughness = 0.1;

double power(const Sequence& s, std::size_t i, std::size_t j) {
  return std::log(s.distance[i] / s.distance[j]) / std::log(s.x[i] / s.x[j]);
}

bool told(const Sequence& s, std::size_t i) {
  return s.distance[i] > 0.0 && std::isfinite(s.distance[i]) && s.distance[i] >= above_floor * s.floor[i];
}

/// The order of a range whose distances are told, if its local powers agree.
std::optional<SequenceOrder> order_of(const Sequence& s, std::size_t first, std::size_t last) {
  const std::size_t powers = last - first;
  if (powers < 2) return std::nullopt;
  double lowest = power(s, first, first + 1), highest = lowest;
  for (std::size_t i = first + 1; i < last; ++i) {
    lowest = std::min(lowest, power(s, i, i + 1));
    highest = std::max(highest, power(s, i, i + 1));
  }
  if (highest - lowest > (powers == 2 ? agreement_of_two : agreement_of_more)) return std::nullopt;
  const auto slope =
      observed_order(std::span(s.x).subspan(first, powers + 1), std::span(s.distance).subspan(first, powers + 1));
  if (!slope) return std::nullopt;
  // Two powers may agree by chance, where the one before them is another.
  if (powers == 2 && first > 0 && told(s, first - 1) && std::abs(power(s, first - 1, first) - slope->order) > roughness)
    return std::nullopt;
  // Powers that drift to one side go on doing so, like a geometric sequence.
  double drift = 0.0;
  if (powers > 2) {
    const double end = power(s, last - 1, last), now = end - power(s, last - 2, last - 1),
                 before = power(s, last - 2, last - 1) - power(s, last - 3, last - 2);
    if (now * before > 0.0)
      drift = std::abs(end - slope->order) + std::abs(now) / std::max(0.1, std::abs(before / now) - 1.0);
  }
  const std::size_t middle = last - std::max<std::size_t>(1, powers / 2);
  const double floors =
      (s.floor[first] / s.distance[first] + s.floor[last] / s.distance[last]) / std::log(s.x[first] / s.x[last]);
  SequenceOrder order{*slope, 0.0, first, last};
  order.bound = std::max({2.0 * slope->standard_error, std::abs(power(s, middle, last) - slope->order), floors, drift});
  return order.bound <= largest_bound ? std::optional(order) : std::nullopt;
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
  const auto end = last_told();
  if (!end) return std::nullopt;
  std::optional<SequenceOrder> best;
  for (std::size_t last = *end; last + 2 >= *end && last >= 2; --last)
    for (std::size_t first = 0; first + (last < *end ? 3 : 2) <= last; ++first) {
      bool all = true;
      for (std::size_t i = first; i <= last; ++i) all &= told(*this, i);
      const auto found = all ? order_of(*this, first, last) : std::nullopt;
      if (!found) continue;
      // What follows may be rough, but not of another regime.
      for (std::size_t i = last; i < *end; ++i) all &= std::abs(power(*this, i, i + 1) - found->order) <= roughness;
      if (!all) continue;
      if (!best || found->last - found->first > best->last - best->first) best = found;
      break;
    }
  return best;
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

#include "viscobar/studies/compare/difference.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <stdexcept>
#include <tuple>
#include <utility>

#include "studies/compare/matching.hpp"
#include "studies/touch.hpp"

namespace viscobar {

namespace {

using Place = std::pair<Where, std::size_t>;

// Trapezoidal rule of a trace given on a grid, over part of it.
double integral(std::span<const double> times, std::span<const double> values, double begin, double end) {
  double sum = 0.0;
  for (std::size_t k = 0; k + 1 < times.size(); ++k) {
    const double a = std::max(begin, times[k]), b = std::min(end, times[k + 1]);
    if (b <= a) continue;
    const double slope = (values[k + 1] - values[k]) / (times[k + 1] - times[k]);
    sum += (b - a) * (values[k] + slope * (0.5 * (a + b) - times[k]));
  }
  return sum;
}

// Calls `use` for each two items of one kind that are matched by their times. Two mean distances of the longer list are
// the reach: a single time is matched with a single one wherever it is.
template <class Item>
void match(const std::vector<Item>& first, const std::vector<Item>& other, double duration, auto&& kind, auto&& time,
           auto&& use) {
  using List = std::vector<const Item*>;
  std::map<decltype(kind(first.front())), std::pair<List, List>> kinds;
  for (const Item& item : first) kinds[kind(item)].first.push_back(&item);
  for (const Item& item : other) kinds[kind(item)].second.push_back(&item);
  const auto times = [&](const List& list) {
    std::vector<double> all;
    for (const Item* item : list) all.push_back(time(*item));
    return all;
  };
  for (const auto& [key, lists] : kinds) {
    const auto& [a, b] = lists;
    const double reach = 2.0 * duration / static_cast<double>(std::max(a.size(), b.size()));
    for (const Match& pair : match_times(times(a), times(b), reach)) use(*a[pair.first], *b[pair.other]);
  }
}

// Largest norm of the difference over time; absent where one of the two has no such field.
std::optional<double> largest_difference(const Recording& first, const Recording& other,
                                         const std::vector<double> Recording::*field,
                                         double (*norm)(const Mesh&, std::span<const double>)) {
  const std::vector<double>&a = first.*field, &b = other.*field;
  if (!same_nodes(first.mesh, other.mesh) || a.size() != b.size()) return std::nullopt;
  const std::size_t nodes = first.mesh.nodes();
  std::vector<double> difference(nodes);
  double largest = 0.0;
  for (std::size_t k = 0; k + nodes <= a.size(); k += nodes) {
    for (std::size_t j = 0; j < nodes; ++j) difference[j] = a[k + j] - b[k + j];
    largest = std::max(largest, norm(first.mesh, difference));
  }
  return largest;
}

}  // namespace

double l2_norm(const Mesh& mesh, std::span<const double> nodal) {
  double sum = 0.0;
  const auto size = [&](std::size_t j) { return mesh.uniform() ? 1.0 : mesh.element(j); };
  for (std::size_t j = 0; j + 1 < nodal.size(); ++j)
    sum += size(j) * (nodal[j] * nodal[j] + nodal[j] * nodal[j + 1] + nodal[j + 1] * nodal[j + 1]);
  return std::sqrt((mesh.uniform() ? sum * mesh.spacing() : sum) / 3.0);
}

double h1_seminorm(const Mesh& mesh, std::span<const double> nodal) {
  double sum = 0.0;
  if (!mesh.uniform()) {
    for (std::size_t j = 0; j + 1 < nodal.size(); ++j) {
      const double difference = nodal[j + 1] - nodal[j];
      if (const double size = mesh.element(j); size > 0.0) sum += difference * difference / size;
    }
    return std::sqrt(sum);
  }
  for (std::size_t j = 0; j + 1 < nodal.size(); ++j) {
    const double difference = nodal[j + 1] - nodal[j];
    sum += difference * difference;
  }
  return std::sqrt(sum / mesh.spacing());
}

// Where the run kept no account, impulses are by the trapezoidal rule over the recording's times.
std::vector<ContactPeriod> contact_periods(const Recording& recording, double merge) {
  const std::vector<double>& times = recording.times;
  std::map<Place, std::vector<const Event*>> places;
  for (const Event& event : recording.events) places[{event.where, event.node}].push_back(&event);
  const auto close = [merge](const Touch& one, const Touch& next) {
    return one.closing && next.begin() - one.end(one.begin()) < merge;
  };
  std::vector<Touch> all;
  for (const auto& [place, changes] : places)
    for (const Touch& touch : touches(changes, close))
      if (touch.closing) all.push_back(touch);
  std::ranges::sort(all, {}, &Touch::closing);
  std::vector<ContactPeriod> periods;
  for (const Touch& touch : all) {
    const Event& closing = *touch.closing;
    const double begin = closing.time, end = touch.end(times.empty() ? begin : times.back());
    ContactPeriod& period =
        periods.emplace_back(ContactPeriod{closing.where, closing.node, begin, end, std::nullopt, touch.bounces});
    const auto& account = recording.statistics.account;
    const bool left = closing.where == Where::left;
    if (touch.opening ? touch.opening->impulse.has_value() : account && closing.impulse)
      period.impulse = touch.impulse(touch.opening                   ? 0.0
                                     : closing.where == Where::joint ? account->joints.at(closing.node - 1).impulse
                                     : left                          ? account->left.impulse
                                                                     : account->right.impulse);
    const std::vector<double>& reaction = left ? recording.reaction_left : recording.reaction_right;
    const auto inside = std::ranges::upper_bound(times, begin);
    if (closing.impulse || inside == times.end() || *inside >= end) continue;
    if ((left || closing.where == Where::right) && !reaction.empty())
      period.impulse = integral(times, reaction, begin, end);
  }
  return periods;
}

Difference compare(const Recording& first, const Recording& other) {
  const bool same_mesh = same_nodes(first.mesh, other.mesh);
  if (first.times != other.times || !(same_mesh || first.mesh.elements == 1 || other.mesh.elements == 1))
    throw std::invalid_argument("only recordings on the same mesh and time grid can be compared");
  Difference result;
  result.displacement_l2 = largest_difference(first, other, &Recording::u, l2_norm);
  result.displacement_h1 = largest_difference(first, other, &Recording::u, h1_seminorm);
  result.velocity_l2 = largest_difference(first, other, &Recording::v, l2_norm);
  for (std::size_t k = 0; k < first.times.size(); ++k) {
    const auto a = first.displacement(k), b = other.displacement(k);
    result.end_trace = std::max({result.end_trace, std::abs(a.front() - b.front()), std::abs(a.back() - b.back())});
  }
  result.events = first.events.size();
  result.events_other = other.events.size();
  if (first.statistics.energy && other.statistics.energy)
    result.energy_final = first.statistics.energy->final - other.statistics.energy->final;
  if (first.times.empty()) return result;
  const double duration = first.times.back() - first.times.front();
  match(
      first.events, other.events, duration,
      [](const Event& event) { return std::tuple(event.where, event.node, event.change); },
      [](const Event& event) { return event.time; },
      [&](const Event& a, const Event& b) {
        ++result.events_matched;
        result.largest_event_shift = std::max(result.largest_event_shift.value_or(0.0), std::abs(a.time - b.time));
      });
  // Bounces closer together than a hundredth of the run belong to one contact. By the middle of the period: one that
  // two methods see merged differently is still the same.
  const double merge = 0.01 * duration;
  match(
      contact_periods(first, merge), contact_periods(other, merge), duration,
      [](const ContactPeriod& period) { return Place(period.where, period.node); },
      [](const ContactPeriod& period) { return 0.5 * (period.begin + period.end); },
      [&](const ContactPeriod& a, const ContactPeriod& b) {
        result.contacts.push_back({a, b});
      });
  std::ranges::stable_sort(result.contacts, {}, [](const Difference::Contact& both) { return both.first.begin; });
  return result;
}

}  // namespace viscobar

#include "viscobar/studies/compare/difference.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <stdexcept>
#include <tuple>
#include <utility>

#include "studies/compare/matching.hpp"

namespace viscobar {

double l2_norm(const Mesh& mesh, std::span<const double> nodal) {
  double sum = 0.0;
  if (!mesh.uniform()) {
    for (std::size_t j = 0; j + 1 < nodal.size(); ++j)
      sum += mesh.element(j) * (nodal[j] * nodal[j] + nodal[j] * nodal[j + 1] + nodal[j + 1] * nodal[j + 1]);
    return std::sqrt(sum / 3.0);
  }
  for (std::size_t j = 0; j + 1 < nodal.size(); ++j)
    sum += nodal[j] * nodal[j] + nodal[j] * nodal[j + 1] + nodal[j + 1] * nodal[j + 1];
  return std::sqrt(sum * mesh.spacing() / 3.0);
}

double h1_seminorm(const Mesh& mesh, std::span<const double> nodal) {
  double sum = 0.0;
  if (!mesh.uniform()) {
    for (std::size_t j = 0; j + 1 < nodal.size(); ++j) {
      const double difference = nodal[j + 1] - nodal[j];
      sum += difference * difference / mesh.element(j);
    }
    return std::sqrt(sum);
  }
  for (std::size_t j = 0; j + 1 < nodal.size(); ++j) {
    const double difference = nodal[j + 1] - nodal[j];
    sum += difference * difference;
  }
  return std::sqrt(sum / mesh.spacing());
}

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

// Whether the reaction at an end is that of this contact alone.
const std::vector<double>* end_reaction(const Recording& recording, Where where) {
  if (where == Where::span) return nullptr;
  const auto& reaction = where == Where::left ? recording.reaction_left : recording.reaction_right;
  return reaction.empty() ? nullptr : &reaction;
}

}  // namespace

// Where the run kept no account, by the trapezoidal rule over the recording's times.
std::vector<ContactPeriod> contact_periods(const Recording& recording, double merge) {
  std::vector<ContactPeriod> periods;
  std::vector<std::optional<double>> before;  // impulse of the reaction until a period begins
  std::map<Place, std::size_t> latest;        // period of a place that may go on
  std::map<Place, bool> open;
  for (const Event& event : recording.events) {
    const Place place{event.where, event.node};
    const auto found = latest.find(place);
    if (event.change == Change::opening) {
      open[place] = true;
      if (found == latest.end()) continue;
      ContactPeriod& period = periods[found->second];
      period.end = event.time;
      if (event.impulse) period.impulse = *event.impulse - before[found->second].value_or(0.0);
      continue;
    }
    open[place] = false;
    if (found != latest.end() && event.time - periods[found->second].end < merge) {
      ++periods[found->second].bounces;
    } else {
      latest[place] = periods.size();
      periods.push_back({event.where, event.node, event.time, event.time, 0.0, 1});
      before.push_back(event.impulse);
    }
  }
  if (!recording.times.empty())
    for (const auto& [place, index] : latest) {
      if (open[place]) continue;
      ContactPeriod& period = periods[index];
      period.end = recording.times.back();
      const auto& account = recording.statistics.account;
      if (account && before[index])
        period.impulse = (period.where == Where::left ? account->left : account->right).impulse - *before[index];
    }
  for (std::size_t k = 0; k < periods.size(); ++k) {
    const auto* reaction = before[k] ? nullptr : end_reaction(recording, periods[k].where);
    if (reaction) periods[k].impulse = integral(recording.times, *reaction, periods[k].begin, periods[k].end);
  }
  return periods;
}

namespace {

// Two mean distances of the longer list; a single time is matched with a single one wherever it is.
double reach(std::size_t first, std::size_t other, double duration) {
  return 2.0 * duration / static_cast<double>(std::max(first, other));
}

void match_events(const Recording& first, const Recording& other, double duration, Difference& result) {
  using Kind = std::tuple<Where, std::size_t, Change>;
  std::map<Kind, std::pair<std::vector<double>, std::vector<double>>> times;
  for (const Event& event : first.events) times[{event.where, event.node, event.change}].first.push_back(event.time);
  for (const Event& event : other.events) times[{event.where, event.node, event.change}].second.push_back(event.time);
  for (const auto& [kind, lists] : times) {
    const auto& [a, b] = lists;
    for (const Match& match : match_times(a, b, reach(a.size(), b.size(), duration))) {
      const double shift = std::abs(a[match.first] - b[match.other]);
      ++result.events_matched;
      result.largest_event_shift = std::max(result.largest_event_shift.value_or(0.0), shift);
    }
  }
}

// By the middle of the period: one that two methods see merged differently is still the same.
void match_contacts(const Recording& first, const Recording& other, double duration, Difference& result) {
  // Bounces closer together than a hundredth of the run belong to one contact.
  const double merge = 0.01 * duration;
  std::map<Place, std::pair<std::vector<ContactPeriod>, std::vector<ContactPeriod>>> periods;
  for (const ContactPeriod& p : contact_periods(first, merge)) periods[{p.where, p.node}].first.push_back(p);
  for (const ContactPeriod& p : contact_periods(other, merge)) periods[{p.where, p.node}].second.push_back(p);
  const auto middles = [](const std::vector<ContactPeriod>& list) {
    std::vector<double> times;
    for (const ContactPeriod& p : list) times.push_back(0.5 * (p.begin + p.end));
    return times;
  };
  for (const auto& [place, lists] : periods) {
    const auto& [a, b] = lists;
    for (const Match& match : match_times(middles(a), middles(b), reach(a.size(), b.size(), duration)))
      result.contacts.push_back({a[match.first], b[match.other]});
  }
  std::stable_sort(result.contacts.begin(), result.contacts.end(),
                   [](const auto& a, const auto& b) { return a.first.begin < b.first.begin; });
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
  match_events(first, other, duration, result);
  match_contacts(first, other, duration, result);
  return result;
}

}  // namespace viscobar

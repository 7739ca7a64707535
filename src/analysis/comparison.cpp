#include "viscobar/analysis/comparison.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <stdexcept>
#include <tuple>
#include <utility>

namespace viscobar {

double l2_norm(const Mesh& mesh, std::span<const double> nodal) {
  double sum = 0.0;
  for (std::size_t j = 0; j + 1 < nodal.size(); ++j)
    sum += nodal[j] * nodal[j] + nodal[j] * nodal[j + 1] + nodal[j + 1] * nodal[j + 1];
  return std::sqrt(sum * mesh.spacing() / 3.0);
}

double h1_seminorm(const Mesh& mesh, std::span<const double> nodal) {
  double sum = 0.0;
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
  if (where == Where::left) return &recording.reaction_left;
  if (where == Where::right) return &recording.reaction_right;
  return nullptr;
}

}  // namespace

std::vector<ContactPeriod> contact_periods(const Recording& recording, double merge) {
  std::vector<ContactPeriod> periods;
  std::map<Place, std::size_t> latest;  // period of a place that may go on
  std::map<Place, bool> open;
  for (const Event& event : recording.events) {
    const Place place{event.where, event.node};
    const auto found = latest.find(place);
    if (event.change == Change::opening) {
      if (found != latest.end()) periods[found->second].end = event.time;
      open[place] = true;
      continue;
    }
    open[place] = false;
    if (found != latest.end() && event.time - periods[found->second].end < merge) {
      ++periods[found->second].bounces;
    } else {
      latest[place] = periods.size();
      periods.push_back({event.where, event.node, event.time, event.time, 0.0, 1});
    }
  }
  if (!recording.times.empty())
    for (const auto& [place, index] : latest)
      if (!open[place]) periods[index].end = recording.times.back();
  for (ContactPeriod& period : periods)
    if (const auto* reaction = end_reaction(recording, period.where))
      period.impulse = integral(recording.times, *reaction, period.begin, period.end);
  return periods;
}

Comparison compare(const Recording& first, const Recording& other) {
  if (first.mesh.elements != other.mesh.elements || first.times != other.times)
    throw std::invalid_argument("only recordings on the same mesh and time grid can be compared");
  Comparison result;
  const std::size_t nodes = first.mesh.nodes();
  std::vector<double> difference(nodes);
  const auto subtract = [&](std::span<const double> a, std::span<const double> b) -> std::span<const double> {
    for (std::size_t j = 0; j < nodes; ++j) difference[j] = a[j] - b[j];
    return difference;
  };
  for (std::size_t k = 0; k < first.times.size(); ++k) {
    const auto u = subtract(first.displacement(k), other.displacement(k));
    result.displacement_l2 = std::max(result.displacement_l2, l2_norm(first.mesh, u));
    result.displacement_h1 = std::max(result.displacement_h1, h1_seminorm(first.mesh, u));
    result.end_trace = std::max({result.end_trace, std::abs(u.front()), std::abs(u.back())});
    const auto v = subtract(first.velocity(k), other.velocity(k));
    result.velocity_l2 = std::max(result.velocity_l2, l2_norm(first.mesh, v));
  }
  result.events = first.events.size();
  result.events_other = other.events.size();
  std::map<std::tuple<Where, std::size_t, Change>, std::vector<double>> times;
  for (const Event& event : first.events) times[{event.where, event.node, event.change}].push_back(event.time);
  std::map<std::tuple<Where, std::size_t, Change>, std::size_t> used;
  for (const Event& event : other.events) {
    const std::tuple key{event.where, event.node, event.change};
    const auto found = times.find(key);
    if (found == times.end() || used[key] == found->second.size()) continue;
    const double shift = std::abs(found->second[used[key]++] - event.time);
    ++result.events_matched;
    result.largest_event_shift = std::max(result.largest_event_shift.value_or(0.0), shift);
  }
  if (first.statistics.energy && other.statistics.energy)
    result.energy_final = first.statistics.energy->final - other.statistics.energy->final;

  // Bounces closer together than a hundredth of the run belong to one contact.
  const double merge = first.times.empty() ? 0.0 : 0.01 * (first.times.back() - first.times.front());
  std::map<Place, std::vector<ContactPeriod>> others;
  for (const ContactPeriod& period : contact_periods(other, merge))
    others[{period.where, period.node}].push_back(period);
  std::map<Place, std::size_t> next;
  for (const ContactPeriod& period : contact_periods(first, merge)) {
    const Place place{period.where, period.node};
    const auto& list = others[place];
    if (next[place] < list.size()) result.contacts.push_back({period, list[next[place]++]});
  }
  return result;
}

}  // namespace viscobar

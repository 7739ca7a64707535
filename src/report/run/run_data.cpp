#include "report/run/run_data.hpp"

#include <algorithm>
#include <cmath>

#include "dynamics/pieces.hpp"

namespace viscobar {

namespace {

std::vector<std::pair<std::size_t, std::size_t>> nodes_of_members(const BarSystem& system) {
  std::vector<std::pair<std::size_t, std::size_t>> nodes;
  for (const Piece& piece : system.elements().pieces()) nodes.emplace_back(piece.first, piece.last());
  return nodes;
}

auto& end_of(auto& data, const BarSystem& system, const ContactPlace& place) {
  if (place.where != Where::joint)
    return place.where == Where::left ? data.left : place.where == Where::right ? data.right : data.span;
  const auto& known = system.elements().joints();
  const auto joint = std::ranges::find(known, place.joint, &JointNodes::number);
  return data.joints[static_cast<std::size_t>(joint - known.begin())];
}

}  // namespace

ThinnedField::ThinnedField(const Mesh& mesh, At at, const std::vector<std::pair<std::size_t, std::size_t>>& members)
    : node_stride_((mesh.elements + most - 1) / most) {
  const bool nodal = at == At::nodes;
  // A node that bonded members share is kept once, and no element of a joint, which has no length.
  const auto keep = [&](std::size_t first, std::size_t last) {
    if (!nodal && first == last) return parts_.push_back({nodes_.size(), 0});
    if (!nodal) --last;
    const std::size_t shared = !nodes_.empty() && nodes_.back() == first ? 1 : 0, begin = nodes_.size() - shared;
    for (std::size_t j = first + shared * node_stride_; j < last; j += node_stride_) nodes_.push_back(j);
    if (begin == nodes_.size() || nodes_.back() != last) nodes_.push_back(last);
    parts_.push_back({begin, nodes_.size() - begin});
  };
  if (members.empty()) keep(0, mesh.elements);
  for (const auto& [first, last] : members) keep(first, last);
  for (const std::size_t j : nodes_) x_.push_back(nodal ? mesh.node(j) : 0.5 * (mesh.node(j) + mesh.node(j + 1)));
  last_.values.resize(nodes_.size());
}

std::vector<double> ThinnedField::times() const {
  std::vector<double> all(rows());
  for (std::size_t row = 0; row < all.size(); ++row) all[row] = time(row);
  return all;
}

plot::Range ThinnedField::range() const {
  plot::Range range;
  for (std::size_t row = 0; row < rows(); ++row) range.add(this->row(row));
  return range;
}

std::pair<std::vector<double>, std::vector<double>> ThinnedField::envelope() const {
  std::vector<double> low(row(0).begin(), row(0).end()), high = low;
  for (std::size_t k = 1; k < rows(); ++k) {
    const std::span<const double> values = row(k);
    std::ranges::transform(low, values, low.begin(), [](double a, double b) { return b < a ? b : a; });
    std::ranges::transform(high, values, high.begin(), [](double a, double b) { return b > a ? b : a; });
  }
  return {low, high};
}

ReportData::ReportData(const Case& run, const BarSystem& system)
    : field(system.mesh(), ThinnedField::At::nodes, nodes_of_members(system)),
      stress(system.mesh(), ThinnedField::At::elements, nodes_of_members(system)),
      joints(system.elements().joints().size()),
      readings(run.gauges.size()),
      system_(system),
      gauges_(make_gauges(run.gauges, system.mesh(), run.scene)),
      bars_(element_bars(run.scene, system.mesh())),
      has_springs_(is_penalised(run.method) && !system.contacts().empty()) {}

std::vector<plot::Interval> ReportData::End::in_contact(double now, const ContactPeak& lasting) const {
  std::vector<plot::Interval> all = contacts.intervals();
  if (closed_since) all.push_back({*closed_since, now, {lasting.time, lasting.reaction}});
  return all;
}

void ReportData::End::add(const Event& event) {
  if (event.change == Change::closing) {
    if (!closed_since) closed_since = event.time;
  } else if (closed_since) {
    const ContactPeak peak = event.peak.value_or(ContactPeak{0.0, event.time});
    contacts.add({*closed_since, event.time, {peak.time, peak.reaction}});
    closed_since.reset();
  }
}

void ReportData::Fastest::join(const Fastest& next) {
  if (std::abs(next.event.velocity) > std::abs(event.velocity)) event = next.event;
}

const ReportData::End& ReportData::at(const ContactPlace& place) const { return end_of(*this, system_, place); }

void ReportData::add(const Snapshot& at) {
  const auto stress_of = [&](std::size_t j) {
    return element_stress(bars_.empty() ? system_.bar() : bars_[j], system_.mesh(), at.u, at.v, j);
  };
  field.add(at.time, at.u);
  stress.add_each(at.time, stress_of);
  const auto add_to = [&](End& end, double u, double reaction, double traction) {
    // An end that presses at the start has been closed from there; that of a fixed one is never asked.
    if (snapshots == 0 && reaction != 0.0) end.closed_since = at.time;
    end.displacement.add({at.time, u});
    end.reaction.add({at.time, reaction});
    end.traction.add({at.time, traction});
  };
  add_to(left, at.u.front(), at.reaction_left, stress_of(0));
  add_to(right, at.u.back(), at.reaction_right, stress_of(system_.mesh().elements - 1));
  if (snapshots == 0 && at.reaction_span != 0.0) span.closed_since = at.time;
  span.reaction.add({at.time, at.reaction_span});
  for (std::size_t k = 0; k < std::min(joints.size(), at.joint_forces.size()); ++k) {
    const double force = at.joint_forces[k];
    if (snapshots == 0 && force != 0.0 && system_.elements().joints()[k].contact) joints[k].closed_since = at.time;
    joints[k].reaction.add({at.time, force});
  }
  ++snapshots;
  sensitivities.resize(std::max(sensitivities.size(), at.sensitivities.size()));
  for (std::size_t k = 0; k < at.sensitivities.size(); ++k) {
    sensitivities[k].left.add({at.time, at.sensitivities[k].u.front()});
    sensitivities[k].right.add({at.time, at.sensitivities[k].u.back()});
  }
  for (std::size_t k = 0; k < gauges_.size(); ++k) {
    const Gauge::Reading reading = gauges_[k](at.u, at.v);
    readings[k].displacement.add({at.time, reading.u});
    readings[k].stress.add({at.time, reading.stress});
  }
  if (!at.energy) return;
  for (std::size_t k = 0; k < energy.size(); ++k) energy[k].add({at.time, energy_columns[k].value(*at.energy)});
}

void ReportData::add(const Event& event) {
  if (first_events.size() < most_events) first_events.push_back(event);
  marked_events.add({event});
  if (event.where != Where::span) return end_of(*this, system_, {event.where, event.node}).add(event);
  if (event.change == Change::closing || event.peak) span.add(event);
  // An end lies on it, too.
  if (event.node == 0) left.add(event);
  if (event.node == system_.mesh().elements) right.add(event);
}

}  // namespace viscobar

#include "report/run/run_data.hpp"

#include <algorithm>
#include <cmath>

#include "dynamics/element_stress.hpp"

namespace viscobar {

ThinnedField::ThinnedField(const Mesh& mesh, At at) : node_stride_((mesh.elements + most - 1) / most) {
  const bool nodal = at == At::nodes;
  const std::size_t last = nodal ? mesh.elements : mesh.elements - 1;
  for (std::size_t j = 0; j < last; j += node_stride_) nodes_.push_back(j);
  nodes_.push_back(last);
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

ReportData::ReportData(const Case& run, const BarSystem& system)
    : field(system.mesh()),
      stress(system.mesh(), ThinnedField::At::elements),
      system_(system),
      has_springs_(is_penalised(run.method) && !system.contacts().empty()) {}

std::vector<plot::Interval> ReportData::End::in_contact(double now) const {
  std::vector<plot::Interval> all = contacts.intervals();
  if (closed_since) all.push_back({*closed_since, now});
  return all;
}

void ReportData::Fastest::join(const Fastest& next) {
  if (std::abs(next.event.velocity) > std::abs(event.velocity)) event = next.event;
}

void ReportData::add(const Snapshot& at) {
  if (snapshots++ == 0) {
    // An end that presses at the start has been closed from there; that of a fixed one is never asked.
    if (at.reaction_left != 0.0) left.closed_since = at.time;
    if (at.reaction_right != 0.0) right.closed_since = at.time;
  }
  const auto stress_of = [&](std::size_t j) { return element_stress(system_.bar(), system_.mesh(), at.u, at.v, j); };
  field.add(at.time, at.u);
  stress.add_each(at.time, stress_of);
  left.traction.add({at.time, stress_of(0)});
  right.traction.add({at.time, stress_of(system_.mesh().elements - 1)});
  left.displacement.add({at.time, at.u.front()});
  right.displacement.add({at.time, at.u.back()});
  left.reaction.add({at.time, at.reaction_left});
  right.reaction.add({at.time, at.reaction_right});
  sensitivities.resize(std::max(sensitivities.size(), at.sensitivities.size()));
  for (std::size_t k = 0; k < at.sensitivities.size(); ++k) {
    sensitivities[k].left.add({at.time, at.sensitivities[k].u.front()});
    sensitivities[k].right.add({at.time, at.sensitivities[k].u.back()});
  }
  if (!at.energy) return;
  energy.kinetic.add({at.time, at.energy->kinetic});
  energy.elastic.add({at.time, at.energy->elastic});
  if (has_springs()) energy.contact.add({at.time, at.energy->contact});
  energy.total.add({at.time, at.energy->total()});
  energy.dissipated.add({at.time, at.energy->dissipated + at.energy->end_inertia});
  energy.work.add({at.time, at.energy->work});
}

void ReportData::add(const Event& event) {
  if (first_events.size() < most_events) first_events.push_back(event);
  marked_events.add({event});
  if (event.where == Where::span) return;
  End& end = event.where == Where::left ? left : right;
  if (event.change == Change::closing) {
    if (!end.closed_since) end.closed_since = event.time;
  } else if (end.closed_since) {
    end.contacts.add({*end.closed_since, event.time});
    end.closed_since.reset();
  }
}

}  // namespace viscobar

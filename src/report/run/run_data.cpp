#include "report/run/run_data.hpp"

#include <algorithm>

#include "viscobar/dynamics/penalty_law.hpp"

namespace viscobar {

ReportData::ReportData(const Case& run, const BarSystem& system) : field(system.mesh()), system_(system) {
  if (is_penalised(run.method) && !system.contacts().empty()) epsilon_ = effective_epsilon(run);
}

double ReportData::spring_energy(double t, std::span<const double> u) const {
  const Lift lift = system_.moving() ? system_.lift(t, 0) : Lift{};
  double sum = 0.0;
  for (const Contact& contact : system_.contacts()) {
    const double at = u[contact.unknown] - lift.at(system_.share(contact.unknown));
    sum += PenaltyLaw{contact.weight / *epsilon_}.energy(-contact.clearance(at));
  }
  return sum;
}

std::vector<plot::Interval> ReportData::End::in_contact(double now) const {
  std::vector<plot::Interval> all = contacts.intervals();
  if (closed_since) all.push_back({*closed_since, now});
  return all;
}

void ReportData::add(const Snapshot& at) {
  if (snapshots++ == 0) {
    // An end that presses at the start has been closed from there; that of a fixed one is never asked.
    if (at.reaction_left != 0.0) left.closed_since = at.time;
    if (at.reaction_right != 0.0) right.closed_since = at.time;
  }
  field.add(at.time, at.u);
  left.displacement.add({at.time, at.u.front()});
  right.displacement.add({at.time, at.u.back()});
  left.reaction.add({at.time, at.reaction_left});
  right.reaction.add({at.time, at.reaction_right});
  sensitivities.resize(std::max(sensitivities.size(), at.sensitivities.size()));
  for (std::size_t k = 0; k < at.sensitivities.size(); ++k) {
    sensitivities[k].left.add({at.time, at.sensitivities[k].u.front()});
    sensitivities[k].right.add({at.time, at.sensitivities[k].u.back()});
  }
  const auto u = at.u.subspan(system_.first_node(), system_.size());
  const auto [kinetic, elastic] = system_.nodal_energy(at.u, at.v);
  const double contact = epsilon_ ? spring_energy(at.time, u) : 0.0;
  energy.kinetic.add({at.time, kinetic});
  energy.elastic.add({at.time, elastic});
  if (epsilon_) energy.contact.add({at.time, contact});
  energy.total.add({at.time, kinetic + elastic + contact});
}

void ReportData::add(const Event& event) {
  if (first_events.size() < most_events) first_events.push_back(event);
  marked_events.add(event);
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

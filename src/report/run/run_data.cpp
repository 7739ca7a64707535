#include "report/run/run_data.hpp"

#include "viscobar/dynamics/penalty_law.hpp"

namespace viscobar {

ReportData::ReportData(const Case& run, const BarSystem& system) : field(system.mesh()), system_(system) {
  if (is_penalised(run.method) && !system.contacts().empty()) epsilon_ = run.epsilon;
}

double ReportData::spring_energy(std::span<const double> u) const {
  double sum = 0.0;
  for (const Contact& contact : system_.contacts())
    sum += PenaltyLaw{contact.weight / *epsilon_}.energy(-(u[contact.unknown] + contact.gap));
  return sum;
}

void ReportData::add(const Snapshot& at) {
  ++snapshots;
  field.add(at.time, at.u);
  left.displacement.add({at.time, at.u.front()});
  right.displacement.add({at.time, at.u.back()});
  left.reaction.add({at.time, at.reaction_left});
  right.reaction.add({at.time, at.reaction_right});
  const auto u = at.u.subspan(system_.first_node(), system_.size());
  const auto v = at.v.subspan(system_.first_node(), system_.size());
  const double kinetic = 0.5 * system_.inertia().quadratic_form(v);
  const double elastic = 0.5 * system_.bar().modulus * system_.squared_strain(u);
  const double contact = epsilon_ ? spring_energy(u) : 0.0;
  energy.kinetic.add({at.time, kinetic});
  energy.elastic.add({at.time, elastic});
  if (epsilon_) energy.contact.add({at.time, contact});
  energy.total.add({at.time, kinetic + elastic + contact});
}

void ReportData::add(const Event& event) {
  if (first_events.size() < most_events) first_events.push_back(event);
  marked_events.add(event);
}

}  // namespace viscobar

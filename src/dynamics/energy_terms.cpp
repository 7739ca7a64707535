#include "dynamics/energy_terms.hpp"

#include <vector>

#include "dynamics/frame_energy.hpp"

namespace viscobar {

namespace {

double frame_energy(const Contacts& contacts, const BarSystem& bar, double t, std::span<const double> u,
                    std::span<const double> w) {
  if (!bar.frame().moving()) return 0.0;
  const std::vector<double> in_frame = contacts.origin().displacement(u);
  return lifted_energy(bar, bar.frame().lift(t, 0), bar.frame().lift(t, 1), in_frame, w).total() -
         bar.energy(in_frame, w);
}

}  // namespace

double energy(const Contacts& contacts, std::span<const double> u, std::span<const double> w) {
  return contacts.bar().energy(contacts.origin().displacement(u), w) + contact_energy(contacts, u);
}

double contact_energy(const Contacts& contacts, std::span<const double> u) {
  double sum = 0.0;
  for (std::size_t i = 0; i < contacts.size(); ++i)
    if (const ContactNode& one = contacts[i]; !one.holds && !one.moves && !one.law.stop())
      sum += one.law.linear().energy(-contacts.clearance(i, u));
  for (std::size_t i = 0; contacts.has_stops() && i < contacts.size(); ++i)
    if (const Stop* stop = contacts[i].law.stop(); stop && contacts.closed(i))
      sum += stop->energy(-contacts.clearance(i, u));
  return sum;
}

double frame_energy(const PenalisedSystem& system, double t, std::span<const double> u, std::span<const double> w) {
  return system.bar().frame().moving() ? frame_energy(system.contacts(), system.bar(), system.load().inside(t), u, w)
                                       : 0.0;
}

double change_frame(const PenalisedSystem& system, const BarSystem& to, double t, std::span<double> u,
                    std::span<double> w) {
  const double before = frame_energy(system, t, u, w);
  system.bar().frame().change(to.frame(), t, u, w);
  return frame_energy(system.contacts(), to, t, u, w) - before;
}

bool takes_energy(const Contacts& contacts) {
  const BarSystem& bar = contacts.bar();
  return dissipates(contacts) || contacts.take_energy() || has_dashpots(bar.supports()) ||
         (bar.side() && bar.side()->has_drag());
}

EndPower end_power(const PenalisedSystem& system, double t, std::span<const double> u, std::span<const double> w,
                   std::span<const double> a) {
  const BarSystem& bar = system.bar();
  const auto lift = [&](int derivative) { return system.load().lift(t, derivative); };
  double of_frame = bar.frame().moving() ? lift_end_power(bar, lift(1), lift(2), bar.unknowns().at_nodes(w),
                                                          bar.unknowns().at_nodes(RowValues{a, bar.size()}))
                                         : 0.0;
  double of_side = 0.0;
  if (const SideRows* side = bar.side(); side && side->has_row_power()) {
    const auto placed = [of = bar.unknowns().displacement_at_nodes(u), first = bar.unknowns().first_node(),
                         origin = system.contacts().origin().values()](std::size_t j) {
      const bool unknown = j >= first && j - first < origin.size();
      return unknown ? of(j) + origin[j - first] : of(j);
    };
    of_side = side->row_power(bar.unknowns().at_nodes(w), placed);
    if (bar.frame().moving()) of_frame += side_lift_power(bar, lift(0), lift(1), bar.unknowns().at_nodes(w), placed);
  }
  return {bar.inertia().end_power(w, a), of_side, of_frame};
}

}  // namespace viscobar

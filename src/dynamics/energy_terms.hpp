#pragma once

#include <span>

#include "dynamics/frame_energy.hpp"
#include "dynamics/penalised_system.hpp"

namespace viscobar {

/// Energy of the springs of closed contacts.
double contact_energy(const Contacts& contacts, std::span<const double> u);
/// Kinetic, elastic and contact energy, in the frame of the system.
double energy(const Contacts& contacts, std::span<const double> u, std::span<const double> w);
/// Contribution of a frame that moves, 0 otherwise. The work of what moves it is the increase of that, the power of the
/// load, and frame_loss(): the balance of energy is then the frame's.
double frame_energy(const PenalisedSystem& system, double t, std::span<const double> u, std::span<const double> w);
/// Makes the state that of another frame, by MovingFrame::change(); returns the increase of frame_energy().
double change_frame(const PenalisedSystem& system, const BarSystem& to, double t, std::span<double> u,
                    std::span<double> w);

/// True if viscosity or a contact's dashpot takes energy.
inline bool dissipates(const Contacts& contacts) { return contacts.bar().bar().damped() || contacts.has_dashpots(); }
/// True if those do, a stop's, a support's dashpot, drag along the bar, or impacts.
bool takes_energy(const Contacts& contacts);

/// eta w.K w + sum c_e w_e^2 + sum b_i w_i^2, and that of drag along the bar, of velocities w(i), numbers or arrays of
/// them at several times, with w.K w.
template <class Values>
Values dissipated_power(const Contacts& contacts, auto&& w, const Values& squared_strain_rate) {
  const BarSystem& bar = contacts.bar();
  Values power = bar.bar().viscosity * squared_strain_rate;
  for (const Support& support : bar.supports()) power += support.dashpot * w(support.unknown) * w(support.unknown);
  for (std::size_t i = 0; contacts.has_dashpots() && i < contacts.size(); ++i) {
    if (!contacts.closed(i)) continue;
    const std::size_t node = contacts[i].unknown;
    const double damping = contacts[i].law.linear().damping;
    if (contacts[i].joint == 0) {
      power += damping * w(node) * w(node);
    } else {
      const Values apart = w(node) - w(node - 1);
      power += damping * apart * apart;
    }
  }
  if (const SideRows* side = bar.side(); side && side->has_drag()) {
    const Values still = power - power;
    power += side->drag_power([&, first = bar.unknowns().first_node()](std::size_t j) -> Values {
      return j < first || j - first >= bar.size() ? still : w(j - first);
    });
  }
  return power;
}
/// The same of velocities w.
inline double dissipated_power(const Contacts& contacts, std::span<const double> w) {
  const BarSystem& bar = contacts.bar();
  return dissipated_power(
      contacts, [w](std::size_t i) { return w[i]; }, bar.bar().damped() ? bar.elements().squared_strain_rate(w) : 0.0);
}
/// The same of closed stops that are not linear.
inline double stop_loss(const Contacts& contacts, std::span<const double> u, std::span<const double> w) {
  double power = 0.0;
  for (std::size_t i = 0; contacts.bend() && i < contacts.size(); ++i)
    if (contacts.closed(i)) power += contacts[i].law.loss(contacts.clearance(i, u), contacts[i].of(w));
  return power;
}
/// Contribution of a frame that moves (see lift_loss).
inline double frame_loss(const BarSystem& bar, double t, std::span<const double> w) {
  if (!bar.frame().moving()) return 0.0;
  const Lift rate = bar.frame().lift(t, 1);
  const double sum = lift_loss(bar, rate, bar.unknowns().at_nodes(w));
  return bar.side() ? sum + side_lift_loss(bar, rate, bar.unknowns().at_nodes(w)) : sum;
}
/// Power of the end rows of the mass (see Inertia::end_power) at the acceleration a, of which it has row_values(), of
/// those of SideRows, and what is the frame's of both, which what moves the frame does.
/// Where a is that of F(t, u, w), it has E/h times what u is wrong by, which does no work but adds up in a long flight:
/// the derivative of the same w has not.
struct EndPower {
  double of_mass, of_side, of_frame;
  double all() const { return of_mass + of_side + of_frame; }
};
EndPower end_power(const PenalisedSystem& system, double t, std::span<const double> u, std::span<const double> w,
                   std::span<const double> a);

}  // namespace viscobar

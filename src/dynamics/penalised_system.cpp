#include "viscobar/dynamics/penalised_system.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace viscobar {

PenalisedSystem::PenalisedSystem(const BarSystem& bar, const Penalty& penalty)
    : bar_(bar), closed_(bar.contacts().size(), 0) {
  // Effective masses matter to the dashpot alone.
  const bool undamped = penalty.restitution >= 1.0;
  const std::vector<double> masses =
      undamped || bar.contacts().empty() ? std::vector<double>{} : bar.effective_masses();
  for (const Contact& contact : bar.contacts())
    laws_.push_back(penalty_law(penalty, contact.weight, undamped ? 0.0 : masses[contact.unknown]));
  dashpots_ = std::any_of(laws_.begin(), laws_.end(), [](const PenaltyLaw& law) { return law.damping > 0.0; });
  if (bar.loaded()) load_.emplace(bar);
}

void PenalisedSystem::set_closed(std::size_t i, bool closed) {
  closed_[i] = closed ? 1 : 0;
  ++revision_;
}

double PenalisedSystem::clearance_rounding(std::size_t i, double largest) const {
  return 32.0 * std::numeric_limits<double>::epsilon() * (contact(i).gap + largest);
}

bool PenalisedSystem::algebraic(std::size_t unknown) const {
  return !bar_.damped() && (unknown < bar_.massive_begin() || unknown >= bar_.massive_end());
}

std::size_t PenalisedSystem::watched(std::size_t i) const {
  const std::size_t node = contact(i).unknown;
  if (!algebraic(node)) return node;
  return node == 0 ? 1 : node - 1;
}

double PenalisedSystem::offset(std::size_t i, double t) {
  const std::size_t node = contact(i).unknown;
  if (!load_ || !algebraic(node)) return contact(i).gap;
  return contact(i).gap + load_->at(t)[node] * bar_.mesh().spacing() / bar_.bar().modulus;
}

double PenalisedSystem::penetration_share(std::size_t i) const {
  if (!algebraic(contact(i).unknown)) return 1.0;
  return 1.0 / (1.0 + laws_[i].stiffness * bar_.mesh().spacing() / bar_.bar().modulus);
}

void PenalisedSystem::force(double t, std::span<const double> u, std::span<const double> w, std::span<double> out) {
  bar_.internal_force(u, w, out);
  if (load_) {
    const std::span<const double> load = load_->at(t);
    for (std::size_t i = 0; i < out.size(); ++i) out[i] += load[i];
  }
  for (std::size_t i = 0; i < laws_.size(); ++i) {
    if (!closed(i)) continue;
    const std::size_t node = contact(i).unknown;
    out[node] -= laws_[i].stiffness * clearance(i, u) + laws_[i].damping * w[node];
  }
}

void PenalisedSystem::dynamic_stiffness(double m, double c, double k, SymmetricTridiagonal& out) const {
  bar_.dynamic_stiffness(m, c, k, out);
  for (std::size_t i = 0; i < laws_.size(); ++i)
    if (closed(i)) out.diagonal[contact(i).unknown] += k * laws_[i].stiffness + c * laws_[i].damping;
}

double PenalisedSystem::stiffness_of_closed(std::size_t unknown) const {
  double sum = 0.0;
  for (std::size_t i = 0; i < laws_.size(); ++i)
    if (closed(i) && contact(i).unknown == unknown) sum += laws_[i].stiffness;
  return sum;
}

void PenalisedSystem::complete_velocity_of(std::size_t end, std::size_t neighbour, double t, std::span<const double> u,
                                           std::span<double> w) {
  const double h = bar_.mesh().spacing();
  const double modulus = bar_.bar().modulus / h, damping = bar_.bar().viscosity / h;
  if (bar_.damped()) {
    double force = modulus * (u[neighbour] - u[end]) + damping * w[neighbour];
    if (load_) force += load_->at(t)[end];
    for (std::size_t i = 0; i < laws_.size(); ++i)
      if (closed(i) && contact(i).unknown == end) force -= laws_[i].stiffness * clearance(i, u);
    w[end] = force / damping;
    return;
  }
  double rate = modulus * w[neighbour];
  if (load_ && !load_->steady()) {
    const double transit = h * std::sqrt(bar_.bar().density / bar_.bar().modulus);
    // No load is asked for before the start, where it need not exist.
    const double step = 1e-4 * transit, before = std::max(0.0, t - step), after = t + step;
    const double early = load_->at(before)[end];
    rate += (load_->at(after)[end] - early) / (after - before);
  }
  w[end] = rate / (modulus + stiffness_of_closed(end));
}

void PenalisedSystem::complete_velocity(double t, std::span<const double> u, std::span<double> w) {
  const std::size_t n = size();
  if (bar_.massive_begin() == 1) complete_velocity_of(0, 1, t, u, w);
  if (bar_.massive_end() + 1 == n) complete_velocity_of(n - 1, n - 2, t, u, w);
}

void PenalisedSystem::complete_displacement_of(std::size_t end, std::size_t neighbour, double t, std::span<double> u) {
  const double modulus = bar_.bar().modulus / bar_.mesh().spacing();
  double force = modulus * u[neighbour], stiffness = modulus;
  if (load_) force += load_->at(t)[end];
  for (std::size_t i = 0; i < laws_.size(); ++i) {
    if (!closed(i) || contact(i).unknown != end) continue;
    force -= laws_[i].stiffness * contact(i).gap;
    stiffness += laws_[i].stiffness;
  }
  u[end] = force / stiffness;
}

void PenalisedSystem::complete_displacement(double t, std::span<double> u) {
  if (bar_.damped()) return;
  const std::size_t n = size();
  if (bar_.massive_begin() == 1) complete_displacement_of(0, 1, t, u);
  if (bar_.massive_end() + 1 == n) complete_displacement_of(n - 1, n - 2, t, u);
}

void PenalisedSystem::settle(double t, std::span<double> u, std::span<double> w) {
  for (std::size_t i = 0; i < laws_.size(); ++i) set_closed(i, false);
  complete_displacement(t, u);
  complete_velocity(t, u, w);
  if (laws_.empty()) return;
  double largest = 0.0;
  for (double displacement : u) largest = std::max(largest, std::abs(displacement));
  std::vector<double> acceleration;
  std::vector<unsigned char> press(laws_.size(), 0);
  for (std::size_t i = 0; i < laws_.size(); ++i) {
    const std::size_t node = contact(i).unknown;
    const double clear = clearance(i, u), rounding = clearance_rounding(i, largest);
    if (clear > rounding) continue;
    if (clear < -rounding || w[node] < 0.0) {
      press[i] = 1;
    } else if (w[node] == 0.0) {
      if (acceleration.empty()) {
        acceleration.resize(size());
        force(t, u, w, acceleration);
        bar_.accelerate(acceleration);
      }
      press[i] = acceleration[node] < 0.0 ? 1 : 0;
    }
  }
  for (std::size_t i = 0; i < laws_.size(); ++i)
    if (press[i]) set_closed(i, true);
  complete_displacement(t, u);
  complete_velocity(t, u, w);
}

double PenalisedSystem::reaction(std::size_t i, std::span<const double> u, std::span<const double> w) const {
  return closed(i) ? laws_[i].reaction(-clearance(i, u), -w[contact(i).unknown]) : 0.0;
}

double PenalisedSystem::energy(std::span<const double> u, std::span<const double> w) const {
  double sum = bar_.energy(u, w);
  for (std::size_t i = 0; i < laws_.size(); ++i) sum += laws_[i].energy(-clearance(i, u));
  return sum;
}

double PenalisedSystem::dissipated_power(std::span<const double> w) const {
  double power = bar_.damped() ? bar_.bar().viscosity * bar_.squared_strain_rate(w) : 0.0;
  if (dashpots_)
    for (std::size_t i = 0; i < laws_.size(); ++i)
      if (closed(i)) power += laws_[i].damping * w[contact(i).unknown] * w[contact(i).unknown];
  return power;
}

double PenalisedSystem::load_power(double t, std::span<const double> w) {
  const std::span<const double> load = load_->at(t);
  return std::inner_product(load.begin(), load.end(), w.begin(), 0.0);
}

}  // namespace viscobar

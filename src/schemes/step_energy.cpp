#include "schemes/step_energy.hpp"

#include <algorithm>
#include <vector>

#include "dynamics/frame_energy.hpp"

namespace viscobar {

// v^n of a node that is stored at i.
auto StepEnergy::velocity() const {
  return [p = step_.p().data(), a = step_.acceleration().data(), half = dt_ / 2](std::size_t i) {
    return p[i] - half * a[i];
  };
}

// v^n at all nodes.
auto StepEnergy::velocity_at_nodes() const {
  return [this, v = velocity(), n = step_.p().size(), first = system_.unknowns().first_node()](std::size_t j) {
    return j < first || j - first >= n ? 0.0 : v(places_[j - first]);
  };
}

// The mean of u^{n+1} and u^{n-1}.
auto StepEnergy::displacement_at_nodes() const {
  return [this, u = step_.u(), p = step_.p(), a = step_.acceleration(),
          first = system_.unknowns().first_node()](std::size_t j) {
    if (j < first || j - first >= u.size()) return *system_.unknowns().wall(j > 0);
    const std::size_t i = places_[j - first];
    return u[i] - dt_ * (p[i] - dt_ / 2 * a[i]);
  };
}

auto StepEnergy::acceleration_at_nodes() const {
  return [this, a = step_.acceleration(), first = system_.unknowns().first_node()](std::size_t j) {
    return j < first || j - first >= a.size() ? 0.0 : a[places_[j - first]];
  };
}

StepEnergy::StepEnergy(const BarSystem& system, TimeStep& step, std::span<const double> times, double dt)
    : system_(system),
      step_(step),
      bar_(system, step.order()),
      places_(system.size()),
      active_(step.active()),
      begin_(times.front()),
      end_(times.back()),
      dt_(dt) {
  for (std::size_t i = 0; i < places_.size(); ++i) places_[i] = step.order().place(i);
}

// The skew part takes what v^n = p - dt/2 a and p alike give it.
double StepEnergy::end_power() const {
  const std::size_t* const places = places_.data();
  const auto v = [v = velocity(), places](std::size_t i) { return v(places[i]); };
  const auto a = [a = step_.acceleration().data(), places](std::size_t i) { return a[places[i]]; };
  const BandedMatrix& inertia = system_.inertia().matrix();
  if (inertia.skew.empty() || step_.order().rows == 0) return inertia.unsymmetric_product(v, a);
  return inertia.one_sided_product(v, a) + bar_.skew_power(step_.p(), step_.acceleration());
}

namespace {

// u^n, u^{n-1}, p^{n-1/2} of the nodes in their order.
struct Nodal {
  Nodal(const TimeStep& step, double dt) : u(step.u().size()), u_before(u.size()), p(u.size()) {
    const LaneOrder& order = step.order();
    order.to_nodes([u = step.u()](std::size_t i) { return u[i]; }, u);
    order.to_nodes([u = step.u(), p = step.p(), dt](std::size_t i) { return u[i] - dt * p[i]; }, u_before);
    order.to_nodes([p = step.p()](std::size_t i) { return p[i]; }, p);
  }
  std::vector<double> u, u_before, p;
};

}  // namespace

EnergyState StepEnergy::parts(double t) const {
  const Nodal nodal(step_, dt_);
  Lift now, before, rate;
  if (system_.frame().moving()) {
    now = system_.frame().lift(t, 0), before = system_.frame().lift(t - dt_, 0);
    rate = {(now.left - before.left) / dt_, (now.right - before.right) / dt_};
  }
  const BarEnergy at_end = lifted_energy(system_, now, rate, nodal.u, nodal.p);
  return {.kinetic = at_end.kinetic,
          .elastic = (at_end.elastic + lifted_energy(system_, before, rate, nodal.u_before, nodal.p).elastic) / 2};
}

double StepEnergy::energy() const {
  const Nodal nodal(step_, dt_);
  return (system_.energy(nodal.u, nodal.p) + system_.energy(nodal.u_before, nodal.p)) / 2;
}

void StepEnergy::account(std::size_t n, EnergyAccount& energy) {
  const auto p = step_.p(), a = step_.acceleration();
  const auto v = velocity();
  if (system_.bar().damped())
    energy.dissipated += dt_ * system_.bar().viscosity * bar_.squared_strain_rate(p, -dt_ / 2, a);
  if (has_dashpots(system_.supports())) {
    double power = 0.0;
    for (const Support& support : system_.supports())
      power += support.dashpot * v(support.unknown) * v(support.unknown);
    energy.dissipated += dt_ * power;
  }
  if (system_.frame().moving()) account_frame(n, energy);
  const double taken = taken_by_contacts(n, energy);
  energy.dissipated += taken;
  if (system_.loaded()) energy.work += dt_ * power(step_.load(), p, -dt_ / 2, a);
  if (system_.has_end_rows()) {
    const double taken_by_rows = dt_ * end_power();
    energy.end_inertia += taken_by_rows, energy.dissipated += taken_by_rows;
  }
  if (system_.side()) account_side(n, *system_.side(), energy);
  energy.notice(energy.dissipated, energy.work);
  if (!step_.contacts().empty()) watch_growth(time(n), taken, energy);
}

void StepEnergy::account_frame(std::size_t n, EnergyAccount& energy) const {
  const Lift rate = system_.frame().lift(time(n), 1, dt_);
  const double loss = dt_ * lift_loss(system_, rate, velocity_at_nodes());
  energy.dissipated += loss;
  energy.work += loss;
  const double power = dt_ * lift_end_power(system_, rate, system_.frame().lift(time(n), 2, dt_), velocity_at_nodes(),
                                            acceleration_at_nodes());
  for (double* one : {&energy.end_inertia, &energy.dissipated, &energy.work}) *one += power;
}

void StepEnergy::account_side(std::size_t n, const SideRows& side, EnergyAccount& energy) const {
  const auto v = velocity_at_nodes();
  const auto u = displacement_at_nodes();
  double rows = dt_ * side.row_power(v, u);
  if (side.has_drag()) energy.dissipated += dt_ * side.drag_power(v);
  if (system_.frame().moving()) {
    const Lift lift = system_.frame().lift(time(n), 0, dt_), rate = system_.frame().lift(time(n), 1, dt_);
    const double loss = dt_ * side_lift_loss(system_, rate, v),
                 of_frame = dt_ * side_lift_power(system_, lift, rate, v, u);
    energy.dissipated += loss;
    energy.work += loss + of_frame;
    rows += of_frame;
  }
  energy.end_inertia += rows, energy.dissipated += rows;
}

// An obstacle that moves does work at its own velocity, and takes energy at that of the node against it.
double StepEnergy::taken_by_contacts(std::size_t n, EnergyAccount& energy) const {
  if (!step_.pushed()) return 0.0;
  const auto& contacts = step_.contacts();
  const auto v = velocity();
  double taken = 0.0, given = 0.0;
  for (std::size_t k = 0; k < contacts.size(); ++k) {
    const double impulse = dt_ * step_.reaction()[k];
    const std::size_t i = step_.stored_contacts()[k].entry;
    const double against = contacts[k].joint > 0 ? v(i - 1) : 0.0;
    taken -= impulse * (contacts[k].sign * (v(i) - against));
    if (impulse != 0.0 && system_.frame().moves(contacts[k]))
      given -= impulse *
               (system_.frame().gap(contacts[k], time(n + 1)) - system_.frame().gap(contacts[k], time(n - 1))) /
               (2.0 * dt_);
  }
  energy.work += given;
  return taken + given;
}

// An impact of Paoli and Schatzman's lasts two steps: what the first took the second may give back. So impacts are
// compared where nothing has touched for two.
void StepEnergy::watch_growth(double t, double taken, EnergyAccount& energy) {
  taken_ += taken;
  if (taken_at_rest_ - taken_ > energy.growth) {
    energy.growth = taken_at_rest_ - taken_;
    energy.growth_time = std::min(t, end_);
  }
  const bool touching = std::ranges::find(active_, 1) != active_.end();
  if (!touching && !touching_) taken_at_rest_ = std::max(taken_at_rest_, taken_);
  touching_ = touching;
}

}  // namespace viscobar

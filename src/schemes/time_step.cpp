#include "schemes/time_step.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <tuple>

namespace viscobar {

namespace {

// One contact a node, the one with the smallest gap.
std::vector<Contact> bounded_nodes(const std::vector<Contact>& all) {
  std::vector<Contact> nodes = all;
  std::sort(nodes.begin(), nodes.end(), [](const Contact& a, const Contact& b) {
    return std::tie(a.unknown, a.gap, a.where) < std::tie(b.unknown, b.gap, b.where);
  });
  const auto same = [](const Contact& a, const Contact& b) { return a.unknown == b.unknown; };
  nodes.erase(std::unique(nodes.begin(), nodes.end(), same), nodes.end());
  return nodes;
}

bool covers_span(const std::vector<Contact>& contacts) {
  return std::any_of(contacts.begin(), contacts.end(), [](const Contact& c) { return c.where == Where::span; });
}

}  // namespace

TimeStep::TimeStep(const BarSystem& system, const State& start, double begin, const FullyDiscrete& scheme)
    : system_(system), dt_(scheme.step), restitution_(scheme.restitution), contacts_(bounded_nodes(system.contacts())) {
  SymmetricTridiagonal matrix;
  system.dynamic_stiffness(1.0, dt_ / 2, dt_ * dt_ / 2, matrix);
  if (covers_span(system.contacts())) {
    solver_.emplace<SpanConstraint>(matrix);
    force_.resize(system.size());
  } else if (!contacts_.empty()) {
    std::vector<std::size_t> ends;
    for (const Contact& contact : contacts_) ends.push_back(contact.unknown);
    solver_.emplace<EndConstraint>(matrix, ends);
    solves_ = ends.size();
  } else {
    std::get<TridiagonalFactor>(solver_).factorise(matrix);
  }
  if (system.loaded()) load_.emplace(system);
  a_.resize(system.size());
  before_.resize(system.size());
  for (std::vector<double>* values : {&lower_, &bound_, &reaction_, &reaction_before_})
    values->resize(contacts_.size());

  start_from(start, begin, scheme.start);
  balance(begin + dt_);
  for (std::size_t k = 0; k < contacts_.size(); ++k)
    reaction_before_[k] = start.u[contacts_[k].unknown] <= -contacts_[k].gap ? reaction_[k] : 0.0;
}

void TimeStep::start_from(const State& start, double begin, Start order) {
  u_ = start.u;
  p_ = start.v;
  for (std::size_t k = 0; k < contacts_.size(); ++k) lower_[k] = -contacts_[k].gap;
  if (order == Start::second_order) {
    // The Taylor term with the step's own matrix in place of rho M: a difference of O(dt^3), and it stays bounded at
    // any dt / h, where dt^2 (rho M)^{-1} K would not.
    evaluate_load(begin);
    solve(dt_ / 2);
    for (std::size_t i = 0; i < p_.size(); ++i) p_[i] += dt_ / 2 * a_[i];
  }
  if (system_.massive_begin() > 0) settle_massless(contacts_.front().gap, 0, 1, begin);
  if (system_.massive_end() < system_.size()) {
    const std::size_t end = system_.size() - 1;
    settle_massless(contacts_.back().gap, end, end - 1, begin);
  }
  for (std::size_t k = 0; k < contacts_.size(); ++k) {
    double& p = p_[contacts_[k].unknown];
    p = std::max(p, (lower_[k] - u_[contacts_[k].unknown]) / dt_);
  }
  for (std::size_t i = 0; i < u_.size(); ++i) {
    a_[i] = (p_[i] - start.v[i]) / (dt_ / 2);
    u_[i] += dt_ * p_[i];
  }
  for (std::size_t k = 0; k < contacts_.size(); ++k) {
    double& u = u_[contacts_[k].unknown];
    u = std::max(u, lower_[k]);
  }
}

void TimeStep::settle_massless(double gap, std::size_t end, std::size_t next, double begin) {
  const Bar& bar = system_.bar();
  const auto rest_stretch = [&](double t, double relaxed, double memory) {
    double pull = 0.0;
    if (load_) {
      evaluate_load(t);
      pull = system_.mesh().spacing() * load_now_[end];
    }
    return (memory * relaxed + pull) / (memory + bar.modulus);
  };
  if (!system_.damped()) u_[end] = std::max(u_[next] + rest_stretch(begin, 0.0, 0.0), -gap);
  const double stretch = rest_stretch(begin + dt_, u_[end] - u_[next], bar.viscosity / dt_);
  p_[end] = (u_[next] + dt_ * p_[next] + stretch - u_[end]) / dt_;
}

void TimeStep::balance(double t) {
  std::swap(a_, before_);
  std::swap(reaction_, reaction_before_);
  if (load_) evaluate_load(t);
  for (std::size_t k = 0; k < contacts_.size(); ++k) {
    const std::size_t i = contacts_[k].unknown;
    lower_[k] = -contacts_[k].gap - restitution_ * (contacts_[k].gap + (u_[i] - dt_ * p_[i]));
  }
  solve(dt_);
}

void TimeStep::evaluate_load(double t) {
  if (!load_) return;
  if (!load_->steady() || load_evaluations_ == 0) ++load_evaluations_;
  load_now_ = load_->at(t);
}

// Finds a and lambda such that u + dt (p + lever a) lies above lower_.
void TimeStep::solve(double lever) {
  auto* span = std::get_if<SpanConstraint>(&solver_);
  std::vector<double>& force = span ? force_ : a_;
  system_.internal_force(u_, p_, force);
  if (load_)
    for (std::size_t i = 0; i < force.size(); ++i) force[i] += load_now_[i];
  for (std::size_t k = 0; k < contacts_.size(); ++k) {
    const std::size_t i = contacts_[k].unknown;
    bound_[k] = ((lower_[k] - u_[i]) / dt_ - p_[i]) / lever;
  }
  if (span) return span->solve(force_, bound_, a_, reaction_);
  ++solves_;
  if (auto* ends = std::get_if<EndConstraint>(&solver_)) return ends->solve(a_, bound_, reaction_);
  std::get<TridiagonalFactor>(solver_).solve(a_);
}

void TimeStep::advance() {
  const std::span<const unsigned char> held = active();
  // The velocity of a held node from its displacements, so that rest is exact and not rounding's motion.
  for (std::size_t k = 0; k < contacts_.size(); ++k) bound_[k] = (lower_[k] - u_[contacts_[k].unknown]) / dt_;
  for (std::size_t i = 0; i < u_.size(); ++i) {
    p_[i] += dt_ * a_[i];
    u_[i] += dt_ * p_[i];
  }
  for (std::size_t k = 0; k < contacts_.size(); ++k) {
    const std::size_t i = contacts_[k].unknown;
    if (held[k]) p_[i] = bound_[k];
    u_[i] = held[k] ? lower_[k] : std::max(u_[i], lower_[k]);
  }
}

std::span<const unsigned char> TimeStep::active() const {
  if (const auto* span = std::get_if<SpanConstraint>(&solver_)) return span->active();
  if (const auto* ends = std::get_if<EndConstraint>(&solver_)) return ends->active();
  return {};
}

bool TimeStep::finite() const {
  if (std::holds_alternative<SpanConstraint>(solver_)) return std::isfinite(std::accumulate(a_.begin(), a_.end(), 0.0));
  return std::isfinite(a_.front()) && std::isfinite(a_.back());
}

double TimeStep::energy() const {
  std::vector<double> u_before(u_);
  for (std::size_t i = 0; i < u_before.size(); ++i) u_before[i] -= dt_ * p_[i];
  return (system_.energy(u_, p_) + system_.energy(u_before, p_)) / 2;
}

std::size_t TimeStep::linear_solves() const {
  const auto* span = std::get_if<SpanConstraint>(&solver_);
  return span ? span->solves() : solves_;
}

std::size_t TimeStep::factorisations() const {
  const auto* span = std::get_if<SpanConstraint>(&solver_);
  return span ? span->factorisations() : 1;
}

}  // namespace viscobar

#include "schemes/time_step.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>
#include <span>
#include <tuple>
#include <utility>
#include <vector>

namespace viscobar {

namespace {

constexpr double unbounded = -std::numeric_limits<double>::infinity();

// One contact a node and side, the one with the smallest gap.
std::vector<Contact> bounded_nodes(std::vector<Contact> nodes) {
  std::ranges::sort(nodes, {},
                    [](const Contact& one) { return std::tuple(one.unknown, one.sign, one.gap, one.where); });
  const auto same = [](const Contact& a, const Contact& b) {
    return a.unknown == b.unknown && a.sign == b.sign && a.joint == b.joint;
  };
  nodes.erase(std::unique(nodes.begin(), nodes.end(), same), nodes.end());
  return nodes;
}

bool covers_span(const std::vector<Contact>& contacts) {
  return std::ranges::any_of(contacts, [](const Contact& one) { return one.where == Where::span; });
}

BandedMatrix step_matrix(const BarSystem& system, double dt) {
  BandedMatrix matrix;
  system.dynamic_stiffness(1.0, dt / 2, dt * dt / 2, matrix);
  return matrix;
}

}  // namespace

// Small functions that every step calls are inlined: at few nodes calls cost as much as they do.

[[gnu::always_inline]] inline void TimeStep::keep_within(std::size_t k) {
  const EndConstraint::Bounded& at = stored_[k];
  double& u = u_[at.entry];
  if (at.joint)
    u = u_[at.entry - 1] + std::max(at.of(u_), lower_[k]);
  else
    u = at.sign * std::max(at.sign * u, lower_[k]);
}

TimeStep::TimeStep(const BarSystem& system, const State& start, double begin, const FullyDiscrete& scheme,
                   std::optional<double> end)
    : system_(system),
      dt_(scheme.step),
      restitution_(scheme.restitution),
      impact_(scheme.impact),
      begin_(begin),
      factor_(covers_span(system.contacts()) ? LaneFactor() : LaneBar::factor(system, step_matrix(system, dt_))),
      order_(factor_.order().size > 0 ? factor_.order() : LaneOrder{system.size()}),
      bar_(system, order_),
      contacts_(bounded_nodes(system.contacts())),
      obstacles_move_(std::ranges::any_of(contacts_, [&](const Contact& one) { return system.frame().moves(one); })),
      bounds_stay_(!obstacles_move_ && restitution_ == 0.0 && impact_ == Impact::paoli_schatzman),
      fields_(order_, system.loaded() && order_.rows > 0 ? 5 : 4) {
  if (covers_span(system.contacts())) {
    solver_.emplace<SpanConstraint>(step_matrix(system, dt_));
    for (std::vector<double>* values : {&interface_, &span_lower_, &span_upper_, &span_reaction_})
      values->resize(system.size());
    span_active_.resize(contacts_.size());
    active_ = span_active_;
    for (const Contact& contact : contacts_) stored_.push_back({contact.unknown, contact.sign});
  } else {
    const BandedMatrix& condensed = factor_.condensed();
    interface_.resize(condensed.size());
    std::vector<EndConstraint::Bounded> ends;
    for (const Contact& contact : contacts_) {
      const std::size_t i = order_.interface_index(contact.unknown);
      ends.push_back({i, contact.sign, contact.joint > 0});
      stored_.push_back({order_.stored(i), contact.sign, contact.joint > 0});
    }
    ends_ = &solver_.emplace<EndConstraint>(condensed, ends);
    active_ = ends_->active();
    solves_ = ends.size();
  }
  if (system.loaded()) load_.emplace(system, dt_);
  if (const auto profile = load_ ? load_->profile() : std::nullopt; profile && !load_->steady() && order_.rows > 0) {
    profile_.resize(system.size());
    if (!profile->empty()) order_.from_nodes(*profile, profile_);
  }
  if (load_ && end && !load_->steady() && !system.frame().moving()) {
    load_begin_ = begin, load_end_ = *end;
    pieces_.emplace(system, dt_);
    enter_load(begin);
    mean_.resize(system.size());
  }
  for (std::vector<double>* values : {&lower_, &bound_, &reaction_, &reaction_before_, &start_impulse_})
    values->resize(contacts_.size());

  start_from(start, begin, scheme.start);
  balance(begin + dt_);
  for (std::size_t k = 0; k < contacts_.size(); ++k)
    reaction_before_[k] = clearance(k, begin, contacts_[k].of(start.u)) <= 0.0 ? reaction_[k] : 0.0;
}

void TimeStep::start_from(const State& start, double begin, Start order) {
  order_.from_nodes(start.u, u_);
  order_.from_nodes(start.v, p_);
  const std::vector<double> v(p_.begin(), p_.end());
  bound_contacts(begin);
  if (order == Start::second_order) {
    // The Taylor term with the step's own matrix in place of rho M: a difference of O(dt^3), and it stays bounded at
    // any dt / h, where dt^2 (rho M)^{-1} K would not.
    evaluate_load(begin);
    solve(dt_ / 2);
    const auto a = acceleration();
    for (std::size_t i = 0; i < p_.size(); ++i) p_[i] += dt_ / 2 * a[i];
    for (std::size_t k = 0; k < contacts_.size(); ++k) start_impulse_[k] = dt_ / 2 * reaction_[k];
  }
  if (system_.inertia().massive_begin() > 0) settle_massless(contacts_.front(), 1, begin);
  if (system_.inertia().massive_end() < system_.size()) settle_massless(contacts_.back(), system_.size() - 2, begin);
  project_start();
  for (std::size_t i = 0; i < u_.size(); ++i) {
    a_[i] = (p_[i] - v[i]) / (dt_ / 2);
    u_[i] += dt_ * p_[i];
  }
  for (std::size_t k = 0; k < contacts_.size(); ++k) keep_within(k);
}

void TimeStep::solve_span(SpanConstraint& span, std::span<const double> b, std::span<const double> bound,
                          std::span<double> x, std::span<double> multiplier) {
  std::ranges::fill(span_lower_, unbounded);
  std::ranges::fill(span_upper_, -unbounded);
  for (std::size_t k = 0; k < stored_.size(); ++k)
    (stored_[k].sign > 0.0 ? span_lower_ : span_upper_)[stored_[k].entry] = stored_[k].sign * bound[k];
  if (!span.solve(b, span_lower_, span_upper_, x, span_reaction_)) {
    std::ranges::fill(multiplier, 0.0);
    std::ranges::fill(span_active_, 0);
    return;
  }
  for (std::size_t k = 0; k < stored_.size(); ++k) {
    const auto& [i, sign, joint] = stored_[k];
    multiplier[k] = std::max(sign * span_reaction_[i], 0.0);
    span_active_[k] = span.active()[i] == (sign > 0.0 ? SpanConstraint::at_lower : SpanConstraint::at_upper);
  }
}

// The velocity of contact k's node, in the direction that it is bounded from, that leads to the bound.
double TimeStep::least_velocity(std::size_t k) const { return (lower_[k] - stored_[k].sign * stored_[k].of(u_)) / dt_; }

// The velocity next to p_, in the norm of the inertia, that leads to no penetration: what an impact does that takes all
// of a node's velocity (restitution 0), its neighbours feeling it as far as they share its mass. With a diagonal mass,
// and for massless nodes, node by node.
void TimeStep::project_start() {
  std::vector<double> bound(contacts_.size());
  bool held = false;
  for (std::size_t k = 0; k < contacts_.size(); ++k) {
    bound[k] = least_velocity(k);
    held |= stored_[k].sign * stored_[k].of(p_) < bound[k];
  }
  if (!held) return;
  const BandedMatrix& inertia = system_.inertia().matrix();
  if ((inertia.is_diagonal() && !system_.elements().is_chain()) || system_.inertia().has_massless()) {
    for (std::size_t k = 0; k < contacts_.size(); ++k) {
      const std::size_t i = contacts_[k].unknown;
      double& p = p_[stored_[k].entry];
      const double sign = contacts_[k].sign, taken = std::max(bound[k] - sign * p, 0.0);
      start_impulse_[k] += inertia.diagonal[i] * taken;
      p += sign * taken;
    }
    return;
  }
  std::vector<double> p(p_.size()), momentum(p.size()), impulse(contacts_.size());
  order_.to_nodes([this](std::size_t i) { return p_[i]; }, p);
  inertia.multiply(p, momentum);
  if (covers_span(contacts_)) {
    SpanConstraint span(inertia);
    solve_span(span, momentum, bound, p, impulse);
  } else {
    std::vector<EndConstraint::Bounded> ends;
    for (const Contact& contact : contacts_) ends.push_back({contact.unknown, contact.sign, contact.joint > 0});
    EndConstraint(inertia, ends).solve(momentum, bound, impulse);
    p.swap(momentum);
  }
  order_.from_nodes(p, p_);
  for (std::size_t k = 0; k < contacts_.size(); ++k) start_impulse_[k] += impulse[k];
}

void TimeStep::settle_massless(const Contact& contact, std::size_t next, double begin) {
  const Bar& bar = system_.bar();
  const std::size_t end = contact.unknown;
  const double sign = contact.sign;
  const auto rest_stretch = [&](double t, double relaxed, double memory) {
    double pull = 0.0;
    if (load_) {
      evaluate_load(t);
      pull = system_.elements().stretch_beside(end) * load_now_[end];
    }
    return (memory * relaxed + pull) / (memory + bar.modulus);
  };
  if (!system_.bar().damped())
    u_[end] = sign * std::max(sign * (u_[next] + rest_stretch(begin, 0.0, 0.0)), -system_.frame().gap(contact, begin));
  const double stretch = rest_stretch(begin + dt_, u_[end] - u_[next], bar.viscosity / dt_);
  p_[end] = (u_[next] + dt_ * p_[next] + stretch - u_[end]) / dt_;
}

void TimeStep::restored() {
  eliminated_ = false;
  if (auto* span = std::get_if<SpanConstraint>(&solver_)) span->restored();
  if (ends_) ends_->restored(reaction_);
  pushes_ = pushed_ = true;
}

// The bound of u^{n+1} from u^n and u^{n-1} = u^n - dt p^{n-1/2}, at the start from u^0 and the initial velocity.
void TimeStep::bound_contacts(double t) {
  if (bounds_stay_) {
    for (std::size_t k = 0; k < contacts_.size(); ++k) lower_[k] = -contacts_[k].gap;
    return;
  }
  for (std::size_t k = 0; k < contacts_.size(); ++k) {
    const Contact& contact = contacts_[k];
    const double u = contact.sign * stored_[k].of(u_), p = contact.sign * stored_[k].of(p_);
    // A step back from the start the obstacle has moved as the bar, at its initial velocity.
    const double gap = system_.frame().gap(contact, t), next = system_.frame().gap(contact, t + dt_);
    const double before =
        t > begin_ + dt_ / 2 ? system_.frame().gap(contact, t - dt_) : gap - dt_ * system_.frame().gap(contact, t, 1);
    if (impact_ == Impact::paoli_schatzman) {
      lower_[k] = -next - restitution_ * (before + (u - dt_ * p));
    } else {
      const double relative = p + (gap - before) / dt_;
      lower_[k] = u > -gap ? unbounded : u - dt_ * (relative > 0.0 ? 1.0 : restitution_) * relative + (gap - next);
    }
  }
}

// Finds a at the interface and lambda such that s (u + dt (p + lever a)) lies above lower_.
inline void TimeStep::solve(double lever) {
  for (std::size_t k = 0, count = bound_.size(); k < count; ++k)
    bound_[k] = (least_velocity(k) - stored_[k].sign * stored_[k].of(p_)) / lever;
  if (!ends_) {
    system_.internal_force(u_, p_, interface_);
    for (std::size_t i = 0; i < load_now_.size(); ++i) interface_[i] += load_now_[i];
    return solve_span(std::get<SpanConstraint>(solver_), interface_, bound_, a_, reaction_);
  }
  bar_.eliminate_force(factor_, u_, p_, load_now_, a_, interface_);
  eliminated_ = true;
  ++solves_;
  ends_->solve(interface_, bound_, reaction_);
}

void TimeStep::balance(double t) {
  std::swap(a_, before_);
  std::swap(reaction_, reaction_before_);
  if (!load_stays()) evaluate_load(t);
  if (!bounds_stay_) bound_contacts(t);
  solve(dt_);
  pushed_ = std::exchange(pushes_, std::ranges::any_of(reaction_, [](double one) { return one != 0.0; }));
}

void TimeStep::enter_load(double t) {
  next_break_ = pieces_->enter(t, load_end_);
  if (next_break_ >= load_end_) next_break_ = -unbounded;
}

// Where the load breaks within half a step of t_n, its mean over that time acts: what it does there is not lost, and
// what it is at one instant is nothing.
bool TimeStep::take_mean(double t) {
  if (!pieces_) return false;
  const double from = std::max(t - dt_ / 2, load_begin_), to = t + dt_ / 2;
  if (next_break_ <= from) enter_load(from);
  if (to <= next_break_) return false;
  std::ranges::fill(mean_, 0.0);
  for (double begin = from; begin < to;) {
    const double end = std::min(next_break_, to), share = (end - begin) / (to - from);
    // Gauss' two points a piece, never a break itself, where the load may have a pole: a smooth pulse that stands
    // between two breaks is one of some width.
    constexpr int pieces = 16;
    for (int k = 0; k < 2 * pieces; ++k) {
      const double part = (k / 2 + 0.5 + (k % 2 == 0 ? -0.5 : 0.5) / std::numbers::sqrt3) / pieces;
      const std::span<const double> now = pieces_->at(begin + (end - begin) * part);
      for (std::size_t i = 0; i < mean_.size(); ++i) mean_[i] += share / (2 * pieces) * now[i];
      ++load_evaluations_;
    }
    if (next_break_ < to) enter_load(next_break_);
    begin = end;
  }
  return true;
}

void TimeStep::evaluate_load(double t) {
  if (load_stays()) return;
  ++load_evaluations_;
  const bool breaks = take_mean(t);
  if (!breaks && !profile_.empty()) {
    const double now = load_->history(t);
    const std::span<double> out = fields_[4];
    for (std::size_t i = 0; i < out.size(); ++i) out[i] = now * profile_[i];
    const auto [left, right] = load_->end_forces(t);
    out.front() += left, out.back() += right;
    load_now_ = out;
    return;
  }
  load_now_ = breaks ? std::span<const double>(mean_) : load_->at(t);
  if (order_.rows == 0) return;
  order_.from_nodes(load_now_, fields_[4]);
  load_now_ = fields_[4];
}

// Second sweep; `use(i, a)` sees every node, or row of nodes, stored at i.
template <class Use>
void TimeStep::substitute(Use&& use) {
  eliminated_ = false;
  factor_.substitute(interface_, a_,
                     [use, first = order_.first](std::size_t k, const Lanes& a) { use(first + k * lane_count, a); });
  for (std::size_t i = 0; i < order_.first; ++i) use(i, a_[i] = interface_[i]);
  std::size_t i = order_.first, at = order_.row(order_.rows);
  for (; i + lane_count <= interface_.size(); i += lane_count, at += lane_count) {
    const Lanes a = load_lanes(&interface_[i]);
    store_lanes(a, &a_[at]);
    use(at, a);
  }
  for (; i < interface_.size(); ++i, ++at) use(at, a_[at] = interface_[i]);
}

void TimeStep::complete() {
  substitute([](std::size_t, const auto&) {});
}

namespace {

[[gnu::always_inline]] inline void move(double dt, double a, double& p, double& u) {
  p += dt * a;
  u += dt * p;
}

[[gnu::always_inline]] inline void move(double dt, const Lanes& a, double& p, double& u) {
  const Lanes moved = load_lanes(&p) + dt * a;
  store_lanes(moved, &p);
  store_lanes(load_lanes(&u) + dt * moved, &u);
}

}  // namespace

// Without rows: the nodes lie one after the other.
void TimeStep::advance_in_order(const double* acceleration) {
  eliminated_ = false;
  const double dt = dt_;
  double *a = a_.data(), *p = p_.data(), *u = u_.data();
#pragma GCC ivdep
  for (std::size_t i = 0; i < order_.size; ++i) {
    a[i] = acceleration[i];
    move(dt, a[i], p[i], u[i]);
  }
}

void TimeStep::advance() {
  const std::span<const unsigned char> held = active_;
  // The velocity of a held node from its displacements, so that rest is exact and not rounding's motion.
  for (std::size_t k = 0; k < held.size(); ++k)
    if (held[k]) bound_[k] = least_velocity(k);
  if (eliminated_ && order_.rows == 0)
    advance_in_order(interface_.data());
  else if (eliminated_)
    substitute([dt = dt_, p = p_.data(), u = u_.data()](std::size_t i, const auto& a) { move(dt, a, p[i], u[i]); });
  else
    advance_in_order(a_.data());
  for (std::size_t k = 0; k < held.size(); ++k) {
    if (!held[k]) {
      keep_within(k);
      continue;
    }
    const auto& [i, sign, joint] = stored_[k];
    p_[i] = joint ? p_[i - 1] + bound_[k] : sign * bound_[k];
    u_[i] = joint ? u_[i - 1] + lower_[k] : sign * lower_[k];
  }
}

bool TimeStep::finite_over_span() const { return std::isfinite(std::accumulate(a_.begin(), a_.end(), 0.0)); }

void TimeStep::count(Statistics& statistics) const {
  const auto* span = std::get_if<SpanConstraint>(&solver_);
  statistics.linear_solves = span ? span->solves() : solves_;
  statistics.matrix_factorisations = span ? span->factorisations() : 1;
  statistics.load_evaluations = load_evaluations_;
}

}  // namespace viscobar

#pragma once

#include <cmath>
#include <optional>
#include <span>
#include <variant>
#include <vector>

#include "schemes/end_constraint.hpp"
#include "schemes/lane_bar.hpp"
#include "schemes/span_constraint.hpp"
#include "viscobar/dynamics/load_vector.hpp"
#include "viscobar/schemes/schemes.hpp"

namespace viscobar {

/// Scheme (2.8) as a leapfrog for u^n and p^{n-1/2} = (u^n - u^{n-1}) / dt: with a^n = (u^{n+1} - 2 u^n + u^{n-1}) /
/// dt^2,
///
///     (rho M + dt/2 eta K + dt^2/2 E K) a^n = F(t_n, u^n, p^{n-1/2}) + sum lambda^n,    u^{n+1} in K_h,
///     p^{n+1/2} = p^{n-1/2} + dt a^n,    u^{n+1} = u^n + dt p^{n+1/2},
///
/// which is (2.8) without its cancellations: a rigid motion has a = 0 exactly, and no term is divided by dt^2.
///
/// Fields are in the order of order(), in which a step is two sweeps over the bar: one makes the force and eliminates,
/// the other substitutes back and moves the nodes. The contacts of the ends lie in the small system between them.
/// Under a span obstacle the order is that of the nodes.
class TimeStep {
 public:
  /// Finds u^1 by `scheme.start`, projected in the norm of the inertia on what the contacts bound with u^{-1} = u^0 -
  /// dt u_1, which is K_h at restitution 0, and the balance at t_1. A massless node has no initial velocity: its u^1
  /// follows from the balance of its row at t_1 (backward Euler), and without viscosity, where that row is algebraic,
  /// its u^0 from the same balance at t_0. lambda^0 is lambda^1 where u^0 touches, 0 elsewhere.
  /// Where the load breaks within half a step of t_n, f^n is its mean over that time, up to `end`; without that, and in
  /// a frame that moves, its value.
  /// @throws LoadError, NotPositive
  TimeStep(const BarSystem& system, const State& start, double begin, const FullyDiscrete& scheme,
           std::optional<double> end = std::nullopt);

  /// All that balance() depends on after advance(), for a checkpoint there.
  static void members(auto& step, auto&& each) {
    each(step.u_, step.p_, step.a_, std::span(step.reaction_), step.solves_, step.load_evaluations_);
    if (auto* span = std::get_if<SpanConstraint>(&step.solver_)) each(*span);
  }
  /// Completes what members() that have been read do not hold.
  void restored();

  /// Finds a^n and lambda^n, the balance at t = t_n. @throws LoadError
  void balance(double t);

  /// From n to n + 1; acceleration() stays a^n.
  void advance();
  /// Replaces u^n and p^{n-1/2}, of the nodes in their order.
  void put(std::span<const double> u, std::span<const double> p) {
    order_.from_nodes(u, u_);
    order_.from_nodes(p, p_);
  }

  const LaneOrder& order() const { return order_; }
  std::span<const double> u() const { return u_; }  ///< u^n
  std::span<const double> p() const { return p_; }  ///< p^{n-1/2}
  /// a^n
  std::span<const double> acceleration() {
    if (eliminated_) complete();
    return a_;
  }
  std::span<const double> acceleration_before() const { return before_; }  ///< a^{n-1}

  /// Nodes with an obstacle in the order of the unknowns, with the one that bounds them most, from either side.
  const std::vector<Contact>& contacts() const { return contacts_; }
  /// The same as places in the order of fields.
  const std::vector<EndConstraint::Bounded>& stored_contacts() const { return stored_; }
  bool obstacles_move() const { return obstacles_move_; }  ///< true if any of these does
  /// s u + gap(t) of contact k for a displacement u of its node, at a joint against the one before.
  double clearance(std::size_t k, double t, double u) const {
    return contacts_[k].sign * u + (obstacles_move_ ? system_.frame().gap(contacts_[k], t) : contacts_[k].gap);
  }
  /// int lambda dt over the first half step, which leads to p^{1/2}: of the balance at t_0, and what an impact at t_0
  /// takes at once; one a contact.
  std::span<const double> start_impulse() const { return start_impulse_; }
  std::span<const double> reaction() const { return reaction_; }                ///< lambda^n >= 0, one a contact
  std::span<const double> reaction_before() const { return reaction_before_; }  ///< lambda^{n-1}
  bool pushed() const { return pushes_ || pushed_; }                            ///< true if one of these is not 0
  /// One a contact: true if its bound holds u^{n+1}.
  std::span<const unsigned char> active() const { return active_; }

  /// (M f)_e of a fixed end.
  double load_held(double t, bool right) const { return load_ ? load_->at_held(t, right) : 0.0; }
  /// M f(t_n); only for a loaded system.
  std::span<const double> load() const { return load_now_; }

  /// True if a^n is finite; one value that is not spreads over the nodes that are solved for together.
  bool finite() const {
    return ends_ ? std::isfinite(interface_.front()) && std::isfinite(interface_.back()) : finite_over_span();
  }

  /// Tells what it has solved, factorised and evaluated.
  void count(Statistics& statistics) const;

 private:
  bool finite_over_span() const;
  bool load_stays() const { return !load_ || (load_->steady() && load_evaluations_ > 0); }
  void evaluate_load(double t);
  void enter_load(double t);
  bool take_mean(double t);
  void bound_contacts(double t);
  void solve(double lever);
  template <class Use>
  void substitute(Use&& use);
  void complete();
  void advance_in_order(const double* acceleration);
  void start_from(const State& start, double begin, Start order);
  void project_start();
  void settle_massless(const Contact& contact, std::size_t next, double begin);
  void keep_within(std::size_t k);
  double least_velocity(std::size_t k) const;
  void solve_span(SpanConstraint& span, std::span<const double> b, std::span<const double> bound, std::span<double> x,
                  std::span<double> multiplier);

  const BarSystem& system_;
  double dt_, restitution_;
  Impact impact_;
  double begin_;
  LaneFactor factor_;  // of the rows between the interface's; none under a span obstacle
  LaneOrder order_;
  LaneBar bar_;
  std::optional<LoadVector> load_, pieces_;  // the latter between its breaks, where it has any
  std::span<const double> load_now_;
  double load_begin_ = 0.0, load_end_ = 0.0, next_break_ = 0.0;
  std::vector<double> mean_, profile_;  // the latter of the load, in the order of fields
  std::vector<Contact> contacts_;
  std::vector<EndConstraint::Bounded> stored_;
  bool obstacles_move_, bounds_stay_;  // the latter: lower_ is that of the start
  std::variant<std::monostate, EndConstraint, SpanConstraint> solver_;
  EndConstraint* ends_ = nullptr;          // the solver, but under a span obstacle
  std::span<const unsigned char> active_;  // of it
  LaneFields fields_;
  std::span<double> u_ = fields_[0], p_ = fields_[1], a_ = fields_[2], before_ = fields_[3];
  std::vector<double> interface_;  // a^n there; under a span obstacle the force
  bool eliminated_ = false;        // a_ waits for the second sweep
  std::vector<double> lower_, bound_, reaction_, reaction_before_, start_impulse_;  // one a contact, of s u and s R
  std::vector<double> span_lower_, span_upper_, span_reaction_;                     // one a node
  std::vector<unsigned char> span_active_;                                          // one a contact
  bool pushes_ = true, pushed_ = true;                                              // reaction_ and the one before
  std::size_t solves_ = 0, load_evaluations_ = 0;
};

}  // namespace viscobar

// Derivatives of the shifts of a JumpFilter.
#include <algorithm>
#include <cmath>
#include <utility>

#include "dynamics/derivative/derivative.hpp"
#include "dynamics/jumps/jump_filter.hpp"

namespace viscobar {

void JumpFilter::add_changes(const Derivative& derivative, std::span<const double> x, std::span<const double> x_rate,
                             std::span<double> force) const {
  const auto at = [this](std::span<const double> of) { return bar_.unknowns().at_nodes(of); };
  derivative.matrices().elastic().subtract(at(x), force);
  derivative.matrices().viscous().subtract(at(x_rate), force);
  for (const SideRows& side : derivative.sides())
    side.subtract(side.resistance(at(x), at(x_rate)), bar_.unknowns().first_node(), force.size(), force);
  for (const auto& [node, stiffness, dashpot, mass] : derivative.supports())
    force[node] -= (x.empty() ? 0.0 : stiffness * x[node]) + (x_rate.empty() ? 0.0 : dashpot * x_rate[node]);
}

// The largest change of springs along the bar: rows of the inner nodes are alike.
double JumpFilter::largest_side(const Added& change) const {
  const SideRows* own = bar_.side();
  if (!own) return 0.0;
  double largest = std::abs(change.of_own) * own->largest_stiffness();
  for (const SideRows& side : change.sides) {
    const double share = side.mass().diagonal[1] / own->mass().diagonal[1];
    for (std::size_t j = 0; j < bar_.mesh().nodes(); ++j)
      largest = std::max(largest, std::abs(share * side.stiffness(j)));
  }
  return largest;
}

// out += the slope along `change` of f(x), which changes with the springs and masses of the ends and of the side: by
// differences, of what is all but a polynomial.
template <class Function>
void JumpFilter::add_slope(const Added& change, Function&& f, std::span<double> out) {
  const Bar& bar = bar_.bar();
  const double h = bar_.mesh().spacing(), heaviest = std::max(std::abs(change.mass[0]), std::abs(change.mass[1]));
  const double stiffest_change = std::max(std::abs(change.stiffness[0]), std::abs(change.stiffness[1]));
  const double largest = std::max(
      {stiffest_change * h / bar.modulus, heaviest / (h * bar.density), largest_side(change) * h * h / bar.modulus});
  if (largest == 0.0) return;
  const double step = 1e-4 / largest;
  std::vector<double> value(out.size());
  for (const double side : {-step, step, 0.0}) {
    for (const bool right : {false, true})
      added_.stiffness[right] = side * change.stiffness[right], added_.mass[right] = side * change.mass[right];
    added_.sides = change.sides, added_.of_sides = side, added_.of_own = side * change.of_own;
    if (heaviest > 0.0) factorise();
    if (side == 0.0) continue;
    f(value);
    for (std::size_t i = 0; i < out.size(); ++i) out[i] += value[i] / (2.0 * side);
  }
}

double JumpFilter::fading(const Derivative& derivative) const {
  if (!bar_.bar().damped()) return 0.0;
  const MatrixRates::OfBar& rates = derivative.matrices().of_bar();
  const Bar& bar = bar_.bar();
  const double square = bar.viscosity * bar.viscosity / (scale_ * bar.modulus * bar.modulus);
  return -8.0 * square / (1.0 - 2.0 * square) *
         (2.0 * rates.viscosity / bar.viscosity - rates.inertia - rates.modulus / bar.modulus);
}

void JumpFilter::differentiate(Derivative& derivative, std::span<double> force, std::span<double> rate,
                               std::span<double> s, std::span<double> s_rate) {
  const MatrixRates::OfBar& rates = derivative.matrices().of_bar();
  const Bar& bar = bar_.bar();
  const double fading = this->fading(derivative), growth = fading - rates.modulus / bar.modulus;
  // A is a pure number but for its springs, k h / E, its masses, m / (rho h), and springs along the bar, k h^2 / E.
  Added supports;
  supports.sides = derivative.sides();
  if (bar_.side()) supports.of_own = -rates.modulus / bar.modulus;
  std::array<double, 2> dashpots{};
  for (const Support& support : bar_.supports()) {
    const bool right = bar_.unknowns().is_right(support.unknown);
    supports.stiffness[right] -= support.stiffness * rates.modulus / bar.modulus;
    supports.mass[right] -= support.mass * rates.inertia;
  }
  for (const Support& support : derivative.supports()) {
    const bool right = bar_.unknowns().is_right(support.unknown);
    supports.stiffness[right] += support.stiffness;
    supports.mass[right] += support.mass;
    dashpots[right] += support.dashpot;
  }
  const std::size_t n = s.size();
  const auto applied_to = [this](std::span<const double> jump) {
    return [this, jump](std::span<double> x) {
      std::ranges::copy(jump, x.begin());
      apply(x);
    };
  };
  std::vector<double> change(n);
  apply(rate);
  for (std::size_t i = 0; i < n; ++i) rate[i] += growth * shift_w_[i];
  add_slope(supports, applied_to(jump_rate_), rate);
  damping(rate, change);
  for (std::size_t i = 0; i < n; ++i) force[i] -= change[i];
  add_changes(derivative, {}, shift_w_, force);
  apply(force);
  add_slope(supports, applied_to(jump_force_), force);
  for (std::size_t i = 0; i < n; ++i) {
    force[i] = part_ * force[i] + growth * shift_u_[i];
    s_rate[i] += rate[i];
  }
  // A node that an obstacle has stopped stays on it.
  if (bound_ && part_ > 0.0) {
    const Contacts& contacts = derivative.motion().contacts();
    const std::size_t node = contacts[*bound_].unknown;
    const double left = contacts.clearance(*bound_, s) + contacts[*bound_].sign * force[node];
    const double further = -left / (contacts[*bound_].sign * shift_u_[node]);
    for (std::size_t i = 0; i < n; ++i) force[i] += further * shift_u_[i];
  }
  for (std::size_t i = 0; i < n; ++i) s[i] += force[i];
  if (!has_dashpots(bar_.supports())) return;
  const std::vector<double> impulse = impulse_;
  answer_with_dashpots(force, s_rate);
  std::ranges::fill(change, 0.0);
  for (const Support& support : bar_.supports()) {
    const bool right = bar_.unknowns().is_right(support.unknown);
    change[support.unknown] =
        -dashpots[right] * shift_u_[support.unknown] - supports.mass[right] * impulse[support.unknown];
  }
  factor_.solve(change);
  for (std::size_t i = 0; i < n; ++i) change[i] -= rates.inertia * impulse[i];
  take_high_part(change, force);
  for (std::size_t i = 0; i < n; ++i) s_rate[i] += change[i] - force[i];
  take_high_part(impulse, force);
  for (std::size_t i = 0; i < n; ++i) force[i] *= fading;
  add_slope(
      supports, [&](std::span<double> x) { take_high_part(impulse, x); }, force);
  for (std::size_t i = 0; i < n; ++i) s_rate[i] -= force[i];
  impulse_ = impulse;
}

void JumpFilter::start_rates(Derivative& derivative, double t, std::span<const double> w, std::span<const double> s,
                             std::span<const double> s_rate, std::span<double> force, std::span<double> rate) {
  derivative.motion().force(t, s, s_rate, force);
  prepare(derivative.motion());
  stiffness(s_rate, rate);
  for (double& one : rate) one = -one;
  derivative.motion().load().add_rate(t, rate);
  add_changes(derivative, w, {}, rate);
  derivative.add_frame_rate(t, rate);
}

}  // namespace viscobar

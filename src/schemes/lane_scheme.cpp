#include "schemes/lane_scheme.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

namespace viscobar::bars {

namespace {

using std::experimental::where;
using Mask = Lanes::mask_type;

}  // namespace

LaneScheme::LaneScheme(const Pattern& pattern) : pattern_(pattern), size_(pattern.size()) {
  assert(size_ >= 4);
  for (auto* field : {&diagonal_, &off_, &multiplier_, &inverse_pivot_, &coupling_, &to_last_, &u_, &p_, &y_, &load_,
                      &scaled_load_, &a_, &a_before_})
    field->resize(size_);
  for (const bool right : {false, true})
    if (pattern.contact[right]) column_[right].resize(size_);
}

void LaneScheme::evaluate_load(double t) {
  std::ranges::fill(load_, Lanes(0.0));
  if (shared_load_) {
    for (const LoadPart& part : *shared_load_) {
      const double now = part.history ? part.history(t) : 1.0;
      for (std::size_t i = 0; i < size_; ++i) load_[i] += Lanes(now * part.weights[i]);
    }
    return;
  }
  for (std::size_t l = 0; l < lane_count; ++l) {
    if (!own_loads_[l]) continue;
    for (const LoadPart& part : *own_loads_[l]) {
      const double now = part.history ? part.history(t) : 1.0;
      for (std::size_t i = 0; i < size_; ++i) load_[i][l] = load_[i][l] + now * part.weights[i];
    }
  }
}

// Factor of rho M + damping eta K + elasticity E K with springs, dashpots and masses of the ends:
//
//     row 0      (d_0 + f_0, o_0 + f_1, f_2)          x_0 = w_0 y_0
//     row i      (o_{i-1}, d_i, o_i)                  x_i = w_i y_i - c_i x_{i-1},     y_i = b_i - m_i y_{i+1}
//     row n-1    (l_2, o_{n-2} + l_1, d_{n-1} + l_0)
//
// f and l being the end rows of the mass: with them y_0 takes y_2 as well, and x_{n-1} x_{n-3}.
bool LaneScheme::factorise(double damping, double elasticity) {
  const std::size_t n = size_;
  const SymmetricTridiagonal& pattern = pattern_.inertia;
  const Lanes stiffness = damping * viscosity_ + elasticity * modulus_;
  for (std::size_t i = 0; i < n; ++i) {
    diagonal_[i] = pattern.diagonal[i] * inertia_ + (pattern_.stretch[i] + pattern_.stretch[i + 1]) * stiffness;
    const double beside = i + 1 < n && !pattern.is_diagonal() ? pattern.off_diagonal[i] : 0.0;
    off_[i] = beside * inertia_ - pattern_.stretch[i + 1] * stiffness;
  }
  for (const bool right : {false, true})
    if (pattern_.mounted[right] && !pattern_.fixed(right))
      diagonal_[right ? n - 1 : 0] += mass_[right] + damping * dashpot_[right] + elasticity * spring_[right];
  std::array<Lanes, 3> first{}, last{};
  if (pattern.end_rows)
    for (std::size_t k = 0; k < 3; ++k)
      first[k] = pattern.end_rows->first[k] * inertia_, last[k] = pattern.end_rows->last[k] * inertia_;

  Mask positive(true);
  const auto pivot = [&](std::size_t i, const Lanes& value) {
    positive = positive && value > 0.0;
    inverse_pivot_[i] = 1.0 / value;
  };
  pivot(n - 1, diagonal_[n - 1] + last[0]);
  coupling_[n - 1] = (off_[n - 2] + last[1]) * inverse_pivot_[n - 1];
  last_skip_ = last[2] * inverse_pivot_[n - 1];
  multiplier_[n - 1] = 0.0;
  for (std::size_t i = n - 2; i > 0; --i) {
    multiplier_[i] = off_[i] * inverse_pivot_[i + 1];
    pivot(i, diagonal_[i] - off_[i] * coupling_[i + 1]);
    const Lanes before = i == n - 2 ? off_[i - 1] - off_[i] * last_skip_ : off_[i - 1];
    coupling_[i] = before * inverse_pivot_[i];
  }
  const Lanes beside = off_[0] + first[1] - first[2] * coupling_[2];
  multiplier_[0] = beside * inverse_pivot_[1];
  first_skip_ = first[2] * inverse_pivot_[2];
  pivot(0, diagonal_[0] + first[0] - beside * coupling_[1]);
  coupling_[0] = 0.0;

  // x_{n-1} = sum to_last_i y_i
  std::ranges::fill(to_last_, Lanes(0.0));
  to_last_[n - 1] = 1.0;
  for (std::size_t i = n - 1; i > 0; --i) {
    to_last_[i - 1] -= coupling_[i] * to_last_[i];
    if (i == n - 1) to_last_[i - 2] -= last_skip_ * to_last_[i];
    to_last_[i] *= inverse_pivot_[i];
  }
  to_last_[0] *= inverse_pivot_[0];

  for (const bool of : {false, true}) {
    if (!pattern_.contact[of]) continue;
    std::vector<Lanes>& x = column_[of];
    std::ranges::fill(x, Lanes(0.0));
    x[of ? n - 1 : 0] = pattern_.sign[of];
    for (std::size_t i = n - 1; i-- > 0;) x[i] -= multiplier_[i] * x[i + 1];
    x[0] -= first_skip_ * x[2];
    finish(x);
    for (const bool at : {false, true}) compliance_[at][of] = pattern_.sign[at] * x[at ? n - 1 : 0];
  }
  for (std::size_t i = 0; i < n; ++i) inverse_pivot_[i] *= scale_, to_last_[i] *= scale_;
  return std::experimental::all_of(positive);
}

void LaneScheme::finish(std::span<Lanes> x) const {
  const std::size_t n = size_;
  x[0] *= inverse_pivot_[0];
  for (std::size_t i = 1; i < n; ++i) x[i] = inverse_pivot_[i] * x[i] - coupling_[i] * x[i - 1];
  x[n - 1] -= last_skip_ * x[n - 3];
}

// The force -(E K u + eta K p) + load, divided by scale_, is made and eliminated in one sweep, from the last row on.
// Per scale_ the stress of an element is a difference of q = u + (eta / E) p.
void LaneScheme::sweep() {
  if (loaded_)
    for (std::size_t i = 0; i < size_; ++i) scaled_load_[i] = load_[i] / scale_;
  const auto choose = [&](auto graded, auto loaded) {
    if (pattern_.contact[1] || !fields_)
      sweep_rows(graded, loaded, std::true_type{});
    else
      sweep_rows(graded, loaded, std::false_type{});
  };
  const auto choose_load = [&](auto graded) {
    if (loaded_)
      choose(graded, std::true_type{});
    else
      choose(graded, std::false_type{});
  };
  if (graded_)
    choose_load(std::true_type{});
  else
    choose_load(std::false_type{});
}

template <class Graded, class Loaded, class ToLast>
[[gnu::flatten]] void LaneScheme::sweep_rows(Graded, Loaded, ToLast) {
  const std::size_t n = size_;
  const double* stretch = pattern_.stretch.data();
  const Lanes *u = u_.data(), *p = p_.data(), *load = scaled_load_.data(), *multiplier = multiplier_.data(),
              *to_last = to_last_.data();
  Lanes* y = y_.data();
  const Lanes relaxation = relaxation_;
  const auto stress = [&](std::size_t i, const Lanes& difference) {
    if constexpr (Graded::value)
      return stretch[i] * difference;
    else
      return difference;
  };
  Lanes here = u[n - 1] + relaxation * p[n - 1], beyond = 0.0;  // q_i, and the stress after node i
  if (pattern_.fixed(true)) beyond = stress(n, wall_[1] - here);
  if (pattern_.mounted[1]) beyond -= (spring_[1] * u[n - 1] + dashpot_[1] * p[n - 1]) / scale_;
  Lanes eliminated = 0.0, last = 0.0;
  for (std::size_t i = n - 1; i > 0; --i) {
    const Lanes next = u[i - 1] + relaxation * p[i - 1], before = stress(i, here - next);
    Lanes force = beyond - before;
    if constexpr (Loaded::value) force += load[i];
    eliminated = force - multiplier[i] * eliminated;
    y[i] = eliminated;
    if constexpr (ToLast::value) last += to_last[i] * eliminated;
    here = next, beyond = before;
  }
  if (pattern_.fixed(false)) beyond -= stress(0, here - wall_[0]);
  if (pattern_.mounted[0]) beyond -= (spring_[0] * u[0] + dashpot_[0] * p[0]) / scale_;
  if constexpr (Loaded::value) beyond += load[0];
  y[0] = beyond - multiplier[0] * eliminated - first_skip_ * y[2];
  if constexpr (ToLast::value) last += to_last[0] * y[0];
  last_ = last;
}

// Multipliers of s_X x_X >= bound_X from the excess of x without them, see EndConstraint.
void LaneScheme::constrain(std::array<Lanes, 2> excess) {
  const auto& contact = pattern_.contact;
  for (const bool right : {false, true}) {
    reaction_[right] = 0.0;
    active_[right] = Mask(false);
    if (contact[right]) active_[right] = excess[right] < 0.0;
  }
  if (!(contact[0] && contact[1])) {
    for (const bool right : {false, true})
      if (contact[right]) where(active_[right], reaction_[right]) = -excess[right] / compliance_[right][right];
    return;
  }
  const Mask any = active_[0] || active_[1];
  if (std::experimental::none_of(any)) return;
  const Lanes &g00 = compliance_[0][0], &g11 = compliance_[1][1], &g01 = compliance_[0][1], &g10 = compliance_[1][0];
  // The excess of either end, times the other's compliance, while the other alone is held at its bound.
  const Lanes excess_0 = g11 * excess[0] - g01 * excess[1], excess_1 = g00 * excess[1] - g10 * excess[0];
  const Mask left = excess[0] < 0.0 && excess_1 >= 0.0, right = !left && excess[1] < 0.0 && excess_0 >= 0.0;
  const Mask both = any && !left && !right;
  const Lanes determinant = g00 * g11 - g01 * g10;
  where(left, reaction_[0]) = -excess[0] / g00;
  where(right, reaction_[1]) = -excess[1] / g11;
  where(both, reaction_[0]) = larger(-excess_0 / determinant, 0.0);
  where(both, reaction_[1]) = larger(-excess_1 / determinant, 0.0);
  active_ = {left || both, right || both};
}

// Finds the reactions and the accelerations of the ends such that s (u + dt (p + lever a)) lies above lower_.
void LaneScheme::balance(double lever) {
  sweep();
  end_a_ = {inverse_pivot_[0] * y_[0], last_};
  std::array<Lanes, 2> excess{};
  for (const bool right : {false, true}) {
    if (!pattern_.contact[right]) continue;
    const std::size_t i = right ? size_ - 1 : 0;
    const double s = pattern_.sign[right];
    bound_[right] = ((lower_[right] - s * u_[i]) / dt_ - s * p_[i]) / lever;
    excess[right] = s * end_a_[right] - bound_[right];
  }
  constrain(excess);
  for (const bool of : {false, true})
    if (pattern_.contact[of])
      for (const bool at : {false, true}) end_a_[at] += reaction_[of] * column_[of][at ? size_ - 1 : 0];
  for (const bool right : {false, true})
    if (pattern_.contact[right]) where(active_[right], end_a_[right]) = pattern_.sign[right] * bound_[right];
}

// From n to n + 1; with `keep` a_ is a^n, of held nodes but for rounding. Calls that lanes pass through cost more than
// their arithmetic: all are inlined.
[[gnu::flatten]] void LaneScheme::advance(bool keep) {
  const std::size_t n = size_;
  const double dt = dt_;
  const bool left = pattern_.contact[0] && std::experimental::any_of(active_[0]),
             right = pattern_.contact[1] && std::experimental::any_of(active_[1]);
  std::array<Lanes, 2> held{};
  for (const bool end : {false, true})
    if (pattern_.contact[end]) held[end] = (lower_[end] - pattern_.sign[end] * u_[end ? n - 1 : 0]) / dt;
  const Lanes *y = y_.data(), *inverse_pivot = inverse_pivot_.data(), *coupling = coupling_.data();
  const Lanes *first = column_[0].data(), *last = column_[1].data();
  const Lanes reaction_left = reaction_[0], reaction_right = reaction_[1];
  Lanes *u = u_.data(), *p = p_.data(), *a = a_.data();
  const auto rows = [&](auto of_left, auto of_right, auto kept) {
    Lanes x = 0.0, before = 0.0, two_before = 0.0;
    for (std::size_t i = 0; i < n; ++i) {
      two_before = before, before = x;
      x = inverse_pivot[i] * y[i] - coupling[i] * x;
      if (i == n - 1) x -= last_skip_ * two_before;
      Lanes whole = x;
      if constexpr (decltype(of_left)::value) whole += reaction_left * first[i];
      if constexpr (decltype(of_right)::value) whole += reaction_right * last[i];
      if constexpr (decltype(kept)::value) a[i] = whole;
      const Lanes moved = p[i] + dt * whole;
      p[i] = moved;
      u[i] += dt * moved;
    }
  };
  const auto choose = [&](auto of_left, auto of_right) {
    if (keep)
      rows(of_left, of_right, std::true_type{});
    else
      rows(of_left, of_right, std::false_type{});
  };
  if (left && right)
    choose(std::true_type{}, std::true_type{});
  else if (left)
    choose(std::true_type{}, std::false_type{});
  else if (right)
    choose(std::false_type{}, std::true_type{});
  else
    choose(std::false_type{}, std::false_type{});
  for (const bool end : {false, true}) {
    if (!pattern_.contact[end]) continue;
    const std::size_t i = end ? n - 1 : 0;
    const double s = pattern_.sign[end];
    u[i] = s * larger(s * u[i], lower_[end]);
    where(active_[end], p[i]) = s * held[end];
    where(active_[end], u[i]) = s * lower_[end];
    if (keep) where(active_[end], a[i]) = s * bound_[end];
  }
}

}  // namespace viscobar::bars

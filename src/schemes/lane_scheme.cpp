#include "schemes/lane_scheme.hpp"

#include <algorithm>
#include <cassert>
#include <functional>

namespace viscobar::bars {

namespace {

using std::experimental::where;

}  // namespace

LaneScheme::LaneScheme(const Pattern& pattern) : pattern_(pattern), size_(pattern.size()) {
  assert(size_ >= 4);
  for (auto* field : {&diagonal_, &off_, &u_, &p_, &y_, &load_, &scaled_load_, &x_, &x_before_}) field->resize(size_);
  for (Elimination& one : eliminations_)
    for (auto* field : {&one.multiplier, &one.inverse_pivot, &one.coupling, &one.to_far}) field->resize(size_);
  for (const bool right : {false, true})
    if (pattern.contact[right]) column_[right].resize(size_);
}

void LaneScheme::evaluate_load(double t) {
  std::ranges::fill(load_, Lanes(0.0));
  const auto add = [&](const std::vector<LoadPart>& load, const Lanes& share) {
    for (const LoadPart& part : load) {
      const Lanes now = share * (part.history ? part.history(t) : 1.0);
      for (std::size_t i = 0; i < size_; ++i) load_[i] += now * part.weights[i];
    }
  };
  if (shared_load_) {
    add(*shared_load_, 1.0);
  } else {
    for (std::size_t l = 0; l < lane_count; ++l) {
      Lanes only = 0.0;
      only[l] = 1.0;
      if (own_loads_[l]) add(*own_loads_[l], only);
    }
  }
  for (std::size_t i = 0; i < size_; ++i) scaled_load_[i] = load_[i] * inverse_scale_;
}

// Matrix of rho M + damping eta K + elasticity E K with springs, dashpots and masses of the ends, for kicks: a solution
// is lever times what the matrix makes of a force.
bool LaneScheme::factorise(double damping, double elasticity, double lever) {
  const std::size_t n = size_;
  const BandedMatrix& pattern = pattern_.inertia;
  const Lanes stiffness = damping * viscosity_ + elasticity * modulus_;
  for (std::size_t i = 0; i < n; ++i) {
    diagonal_[i] = pattern.diagonal[i] * inertia_ + (pattern_.stretch[i] + pattern_.stretch[i + 1]) * stiffness;
    const double beside = i + 1 < n && !pattern.is_diagonal() ? pattern.off_diagonal[i] : 0.0;
    off_[i] = beside * inertia_ - pattern_.stretch[i + 1] * stiffness;
  }
  for (const bool right : {false, true})
    if (pattern_.mounted[right] && !pattern_.fixed(right))
      diagonal_[right ? n - 1 : 0] += mass_[right] + damping * dashpot_[right] + elasticity * spring_[right];
  const bool positive = eliminate(false, lever) && eliminate(true, lever);

  const Elimination& own = eliminations_[false];
  for (const bool of : {false, true}) {
    if (!pattern_.contact[of]) continue;
    std::vector<Lanes>& x = column_[of];
    std::ranges::fill(x, Lanes(0.0));
    x[of ? n - 1 : 0] = pattern_.sign[of];
    for (std::size_t i = n - 1; i-- > 0;) x[i] -= own.multiplier[i] * x[i + 1];
    x[0] -= own.near_skip * x[2];
    finish(x);
    for (const bool at : {false, true}) compliance_[at][of] = pattern_.sign[at] * x[at ? n - 1 : 0];
    inverse_compliance_[of] = 1.0 / compliance_[of][of];
  }
  if (pattern_.contact[0] && pattern_.contact[1])
    inverse_determinant_ = 1.0 / (compliance_[0][0] * compliance_[1][1] - compliance_[0][1] * compliance_[1][0]);
  // From here on forces are in units of scale_.
  for (Elimination& one : eliminations_)
    for (std::size_t i = 0; i < n; ++i) one.inverse_pivot[i] *= scale_, one.to_far[i] *= scale_;
  return positive;
}

// The rows counted from the near end:
//
//     row 0      (d_0 + f_0, o_0 + f_1, f_2)          x_0 = w_0 y_0
//     row i      (o_{i-1}, d_i, o_i)                  x_i = w_i y_i - c_i x_{i-1},     y_i = b_i - m_i y_{i+1}
//     row n-1    (l_2, o_{n-2} + l_1, d_{n-1} + l_0)
//
// f and l being the end rows of the mass: with them y_0 takes y_2 as well, and x_{n-1} x_{n-3}. Its skew part adds to
// o_i in row i, and takes from it in row i + 1.
bool LaneScheme::eliminate(bool right, double lever) {
  const std::size_t n = size_;
  Elimination& to = eliminations_[right];
  const auto node = [&](std::size_t i) { return right ? n - 1 - i : i; };
  const std::vector<double>& skew = pattern_.inertia.skew;
  const auto off = [&](std::size_t i, bool below) -> Lanes {
    const std::size_t at = right ? n - 2 - i : i;
    if (skew.empty()) return off_[at];
    return off_[at] + (below != right ? -skew[at] : skew[at]) * inertia_;
  };
  std::array<Lanes, 3> first{}, last{};
  for (const OneSidedRow& one : pattern_.inertia.one_sided)
    for (std::size_t k = 0; k < 3; ++k) ((one.row == 0) != right ? first : last)[k] = one.entries[k] * inertia_;
  std::experimental::fixed_size_simd_mask<double, lane_count> positive(true);
  const auto inverse_pivot = [&](std::size_t i) -> Lanes& { return to.inverse_pivot[node(i)]; };
  const auto coupling = [&](std::size_t i) -> Lanes& { return to.coupling[node(i)]; };
  const auto multiplier = [&](std::size_t i) -> Lanes& { return to.multiplier[node(i)]; };
  const auto pivot = [&](std::size_t i, const Lanes& value) {
    positive = positive && value > 0.0;
    inverse_pivot(i) = 1.0 / value;
  };
  pivot(n - 1, diagonal_[node(n - 1)] + last[0]);
  coupling(n - 1) = (off(n - 2, true) + last[1]) * inverse_pivot(n - 1);
  to.far_skip = last[2] * inverse_pivot(n - 1);
  multiplier(n - 1) = 0.0;
  for (std::size_t i = n - 2; i > 0; --i) {
    const Lanes next = off(i, false);
    multiplier(i) = next * inverse_pivot(i + 1);
    pivot(i, diagonal_[node(i)] - next * coupling(i + 1));
    const Lanes before = i == n - 2 ? off(i - 1, true) - next * to.far_skip : off(i - 1, true);
    coupling(i) = before * inverse_pivot(i);
  }
  const Lanes beside = off(0, false) + first[1] - first[2] * coupling(2);
  multiplier(0) = beside * inverse_pivot(1);
  to.near_skip = first[2] * inverse_pivot(2);
  pivot(0, diagonal_[node(0)] + first[0] - beside * coupling(1));
  coupling(0) = 0.0;

  // x_{n-1} = sum to_far_i y_i
  const auto to_far = [&](std::size_t i) -> Lanes& { return to.to_far[node(i)]; };
  std::ranges::fill(to.to_far, Lanes(0.0));
  to_far(n - 1) = 1.0;
  for (std::size_t i = n - 1; i > 0; --i) {
    to_far(i - 1) -= coupling(i) * to_far(i);
    if (i == n - 1) to_far(i - 2) -= to.far_skip * to_far(i);
  }
  for (std::size_t i = 0; i < n; ++i) {
    to.inverse_pivot[i] *= lever;
    to.to_far[i] *= to.inverse_pivot[i];
  }
  return std::experimental::all_of(positive);
}

// From y, eliminated towards the left end, to x.
void LaneScheme::finish(std::span<Lanes> x) const {
  const Elimination& own = eliminations_[false];
  const std::size_t n = size_;
  x[0] *= own.inverse_pivot[0];
  for (std::size_t i = 1; i < n; ++i) x[i] = own.inverse_pivot[i] * x[i] - own.coupling[i] * x[i - 1];
  x[n - 1] -= own.far_skip * x[n - 3];
}

// s u^{n+1} stays above it: the gap, and the height of the rebound where there is one.
void LaneScheme::bound() {
  for (const bool right : {false, true}) {
    if (!pattern_.contact[right]) continue;
    const std::size_t i = right ? size_ - 1 : 0;
    const double s = pattern_.sign[right];
    lower_[right] = -gap_[right];
    if (rebounds_) lower_[right] -= restitution_ * (gap_[right] + (s * u_[i] - dt_ * (s * p_[i])));
  }
}

// Multipliers of s_X x_X >= bound_X from the excess of x without them, see EndConstraint.
template <bool on_left, bool on_right, class V, class Get>
void LaneScheme::constrain(const std::array<V, 2>& excess, Get&& get, std::array<V, 2>& reaction,
                           std::array<V, 2>& active) const {
  reaction = active = {V(0.0), V(0.0)};
  if constexpr (!(on_left && on_right)) {
    constexpr bool right = on_right;
    where(excess[right] < 0.0, active[right]) = 1.0;
    where(excess[right] < 0.0, reaction[right]) = -excess[right] * get(inverse_compliance_[right]);
    return;
  }
  if (none_of(excess[0] < 0.0 || excess[1] < 0.0)) return;
  // The excess of either end, times the other's compliance, while the other alone is held at its bound.
  const V excess_0 = get(compliance_[1][1]) * excess[0] - get(compliance_[0][1]) * excess[1],
          excess_1 = get(compliance_[0][0]) * excess[1] - get(compliance_[1][0]) * excess[0];
  const auto left = excess[0] < 0.0 && excess_1 >= 0.0, right = !left && excess[1] < 0.0 && excess_0 >= 0.0;
  const auto both = (excess[0] < 0.0 || excess[1] < 0.0) && !left && !right;
  where(left, reaction[0]) = -excess[0] * get(inverse_compliance_[0]);
  where(right, reaction[1]) = -excess[1] * get(inverse_compliance_[1]);
  where(both, reaction[0]) = max(-excess_0 * get(inverse_determinant_), V(0.0));
  where(both, reaction[1]) = max(-excess_1 * get(inverse_determinant_), V(0.0));
  where(left || both, active[0]) = 1.0;
  where(right || both, active[1]) = 1.0;
}

// The velocity of the start, which an obstacle that touches lets pass away from it alone.
void LaneScheme::project_start() {
  std::array<Lanes, 2> least{}, excess{};
  std::experimental::fixed_size_simd_mask<double, lane_count> held(false);
  const BandedMatrix& pattern = pattern_.inertia;
  const auto node = [this](bool right) { return right ? size_ - 1 : 0; };
  for (const bool right : {false, true}) {
    if (!pattern_.contact[right]) continue;
    const double s = pattern_.sign[right];
    least[right] = (lower_[right] - s * u_[node(right)]) / dt_;
    excess[right] = s * p_[node(right)] - least[right];
    held = held || excess[right] < 0.0;
  }
  if (std::experimental::none_of(held)) return;
  if (pattern.is_diagonal() || pattern_.massless[0] || pattern_.massless[1]) {
    for (const bool right : {false, true}) {
      if (!pattern_.contact[right]) continue;
      const Lanes taken = larger(-excess[right], 0.0);
      start_impulse_[right] += (pattern.diagonal[node(right)] * inertia_ + mass_[right]) * taken;
      p_[node(right)] += pattern_.sign[right] * taken;
    }
    return;
  }
  factorise(0.0, 0.0, 1.0);
  by_contacts([&](auto left, auto right) { constrain<left, right>(excess, std::identity(), reaction_, active_); });
  for (const bool of : {false, true}) {
    if (!pattern_.contact[of]) continue;
    for (std::size_t i = 0; i < size_; ++i) p_[i] += reaction_[of] * column_[of][i];
    start_impulse_[of] += reaction_[of];
  }
  for (const bool of : {false, true})  // after both: the reaction of either end moves the other
    if (pattern_.contact[of]) where(active_[of] != 0.0, p_[node(of)]) = pattern_.sign[of] * least[of];
}

// Finds the reactions and the kicks of the ends such that s (u + dt (p + x)) lies above lower_. That of the near end
// goes into y, which ends there.
template <bool on_left, bool on_right>
[[gnu::flatten]] void LaneScheme::react_at() {
  constexpr std::array<bool, 2> contact = {on_left, on_right};
  using Some = std::experimental::native_simd<double>;
  const double per_dt = 1.0 / dt_;
  const std::array<std::size_t, 2> node = {0, size_ - 1};
  const std::array<double, 2> sign = pattern_.sign;
  bool changes = false;
  for (std::size_t from = 0; from < lane_count; from += Some::size()) {
    const auto get = [from](const Lanes& of) { return load_part<Some>(of, from); };
    std::array<Some, 2> excess{}, limit{}, reaction, active;
    for (const bool right : {false, true}) {
      if (!contact[right]) continue;
      const double s = sign[right];
      limit[right] = (get(lower_[right]) - s * get(u_[node[right]])) * per_dt - s * get(p_[node[right]]);
      excess[right] = s * get(end_x_[right]) - limit[right];
    }
    constrain<on_left, on_right>(excess, get, reaction, active);
    for (const bool at : {false, true}) {
      Some x = get(end_x_[at]);
      for (const bool of : {false, true})
        if (contact[of]) x += reaction[of] * get(column_[of][node[at]]);
      if (contact[at]) {
        where(active[at] != 0.0, x) = sign[at] * limit[at];
        store_part(limit[at], bound_[at], from);
        store_part(reaction[at], reaction_[at], from);
        store_part(active[at], active_[at], from);
        changes |= any_of(active[at] != get(was_active_[at]));
      }
      store_part(x, end_x_[at], from);
    }
    if (contact[near_right_]) {
      Lanes& y = y_[node[near_right_]];
      store_part(get(y) + sign[near_right_] * reaction[near_right_] * get(inverse_scale_), y, from);
    }
  }
  changes_ = changes;
}

void LaneScheme::react() {
  reaction_before_ = reaction_;
  by_contacts([&](auto left, auto right) { react_at<left, right>(); });
}

// Impulses and peaks of the step that ends at n, or of a share of it; that of the start has its own impulse.
[[gnu::flatten]] void LaneScheme::account(bool first, double whole, LaneAccounts& accounts) {
  for (const bool right : {false, true}) {
    if (!pattern_.contact[right]) continue;
    const Lanes before = reaction_before_[right], now = reaction_[right];
    accounts.impulse[right] +=
        pattern_.sign[right] * dt_ * whole * ((first ? 0.0 : 1.0 - whole / 2) * before + whole / 2 * now);
    accounts.peak[right] = larger(accounts.peak[right], (1.0 - whole) * before + whole * now);
  }
}

}  // namespace viscobar::bars

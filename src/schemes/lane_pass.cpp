#include "schemes/lane_scheme.hpp"

// A step of (2.8) eliminates its force from the far end to the near one, finds the reactions, and goes back from the
// near end to the far one for the kicks. On that way back the next step's force is known a node later, and is
// eliminated at once: the next step's near end is this one's far end. So each step is one pass over the nodes, in turn
// from the left and from the right, with two chains of dependent operations side by side.

namespace viscobar::bars {

namespace {

using std::experimental::where;
// Two registers a quantity: more do not fit into sixteen.
using Part = std::experimental::fixed_size_simd<double, 2 * std::experimental::native_simd<double>::size()>;

}  // namespace

// Calls that lanes pass through cost more than their arithmetic: all are inlined.
template <bool right, bool moving, bool reacting, bool general>
[[gnu::flatten]] void LaneScheme::pass() {
  const std::size_t n = size_, near = right ? n - 1 : 0, far = right ? 0 : n - 1;
  const auto node = [n](std::size_t i) { return right ? n - 1 - i : i; };
  const Elimination &own = eliminations_[right], &next = eliminations_[!right];
  const double dt = dt_, per_dt = 1.0 / dt_;
  const double* const stretch = pattern_.stretch.data();
  Lanes *const u_of = u_.data(), *const p_of = p_.data(), *const y_of = y_.data(), *const x_of = x_.data();
  const Lanes *const inverse_pivot = own.inverse_pivot.data(), *const coupling = own.coupling.data(),
                     *const multiplier = next.multiplier.data(), *const to_far = next.to_far.data(),
                     *const column = column_[!right].data(), *const load = scaled_load_.data();
  for (std::size_t from = 0; from < lane_count; from += Part::size()) {
    const auto get = [from](const Lanes& of) { return load_part<Part>(of, from); };
    const Part relaxation = get(relaxation_), reaction = get(reaction_[!right]);
    Part x = 0.0, x_before = 0.0, x_two_before = 0.0, eliminated = 0.0, sum = 0.0;

    // An end that is held moves to its bound, to the bit; no other passes it by a rounding.
    const auto hold = [&](bool end, const Part& u_before, Part& u, Part& p, Part& kick) {
      if (!pattern_.contact[end]) return;
      const double s = pattern_.sign[end];
      const Part lower = get(lower_[end]);
      const auto held = get(active_[end]) != 0.0;
      u = s * std::experimental::max(s * u, lower);
      where(held, p) = s * ((lower - s * u_before) * per_dt);
      where(held, u) = s * lower;
      where(held, kick) = s * get(bound_[end]);
    };
    // From n to n + 1, and what the stress is a difference of: per scale_ it is q = u + (eta / E) p.
    const auto move = [&](std::size_t i, auto at_near, auto at_far) {
      const std::size_t k = node(i);
      Part u = get(u_of[k]), p = get(p_of[k]);
      if constexpr (moving) {
        x_two_before = x_before, x_before = x;
        x = get(inverse_pivot[k]) * get(y_of[k]) - get(coupling[k]) * x;
        if constexpr (at_far) x -= get(own.far_skip) * x_two_before;
        Part kick = x;
        if constexpr (reacting) kick += reaction * get(column[k]);
        const Part u_before = u;
        p += kick;
        u += dt * p;
        if constexpr (at_near) hold(right, u_before, u, p, kick);
        if constexpr (at_far) hold(!right, u_before, u, p, kick);
        store_part(p, p_of[k], from);
        store_part(u, u_of[k], from);
        if constexpr (general) store_part(kick, x_of[k], from);
      }
      return Part(u + relaxation * p);
    };
    const auto pull = [&](bool end, std::size_t k) {  // of springs and dashpots
      if (!pattern_.mounted[end]) return Part(0.0);
      return Part((get(spring_[end]) * get(u_of[k]) + get(dashpot_[end]) * get(p_of[k])) * get(inverse_scale_));
    };
    const auto stress = [&](std::size_t element, const Part& difference) {
      if constexpr (general) return Part(graded_ ? stretch[element] * difference : difference);
      return difference;
    };
    const auto eliminate = [&](std::size_t k, Part force) {
      if constexpr (general)
        if (loaded_) force += get(load[k]);
      eliminated = force - get(multiplier[k]) * eliminated;
      store_part(eliminated, y_of[k], from);
      sum += get(to_far[k]) * eliminated;
    };
    constexpr std::true_type yes;
    constexpr std::false_type no;
    constexpr std::size_t before_node = right ? 1 : 0;  // element k + before_node comes before node k on the way
    Part q = move(0, yes, no), beyond = pull(right, near);
    if (pattern_.fixed(right)) beyond += stress(near + before_node, q - get(wall_[right]));
    for (std::size_t i = 1; i + 1 < n; ++i) {
      const Part here = move(i, no, no), now = stress(node(i) + before_node, here - q);
      eliminate(node(i - 1), now - beyond);
      q = here, beyond = now;
    }
    const Part here = move(n - 1, no, yes), now = stress(far + before_node, here - q);
    eliminate(node(n - 2), now - beyond);
    Part force = -now - pull(!right, far);
    if (pattern_.fixed(!right)) force += stress(far + 1 - before_node, get(wall_[!right]) - here);
    force -= get(next.near_skip) * get(y_of[node(n - 3)]);
    eliminate(far, force);
    store_part(Part(get(next.inverse_pivot[far]) * eliminated), end_x_[!right], from);
    store_part(sum, end_x_[right], from);
  }
  near_right_ = !right;
}

// The force of the state as it is, eliminated towards the left end.
void LaneScheme::sweep() { pass<true, false, false, true>(); }

// From n to n + 1, and the next force; x_ is the kick where fields are told.
void LaneScheme::advance() {
  end_x_before_ = end_x_;
  const bool far = !near_right_;
  const bool reacts = pattern_.contact[far] && std::experimental::any_of(reaction_[far] != 0.0);
  const auto choose = [&](auto right, auto reacting) {
    if (graded_ || loaded_ || fields_)
      pass<right, true, reacting, true>();
    else
      pass<right, true, reacting, false>();
  };
  const auto choose_end = [&](auto reacting) {
    if (near_right_)
      choose(std::true_type{}, reacting);
    else
      choose(std::false_type{}, reacting);
  };
  if (reacts)
    choose_end(std::true_type{});
  else
    choose_end(std::false_type{});
}

}  // namespace viscobar::bars

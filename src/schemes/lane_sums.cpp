#include <array>

#include "schemes/lane_bar.hpp"

// Sums over the bar for the energy account.

namespace viscobar {

// sum_e weight_e finish(join(value at the left node of e, value at the right one)), over the elements between nodes.
// `value` is given a function that loads from an array, one number or 16. Without weights they are 1; `in_order` has
// them where there are no rows.
template <class Value, class Join, class Finish>
[[gnu::always_inline]] inline double LaneBar::sum_over_elements(const Weights* of, const double* in_order,
                                                                Value&& value, Join&& join, Finish&& finish) const {
  if (order_.rows == 0) {
    const auto terms = [&](auto&& at) __attribute__((always_inline)) {
      return finish(
          join(value([&](const double* x) { return at(x); }), value([&](const double* x) { return at(x + 1); })));
    };
    return in_order ? sum_by_lanes(order_.size - 1, [&](auto&& at) { return terms(at) * at(in_order); })
                    : sum_by_lanes(order_.size - 1, terms);
  }
  double* const joined = stresses_.data();
  const std::size_t last = stresses_.size() - 1;
  const std::size_t *const at_i = edges_.i.data(), *const at_j = edges_.j.data();
#pragma GCC ivdep
  for (std::size_t e = 1; e < last; ++e)
    joined[e] = join(value([i = at_i[e]](const double* x) { return x[i]; }),
                     value([j = at_j[e]](const double* x) { return x[j]; }));
  const auto sums = [&](auto&& of_row, auto&& of_edge) __attribute__((always_inline)) {
    const auto row = [&](std::size_t k) {
      return value([at = order_.row(k)](const double* x) { return load_lanes(x + at); });
    };
    auto here = row(0);
    Lanes of_rows = 0.0;
    const bool even = order_.even();
    for (std::size_t k = 1, end = order_.rows + even; k < end; ++k) {
      const auto next = row(k);
      of_rows += of_row(k * lane_count, finish(join(here, next)));
      here = next;
    }
    if (even) {  // `here` is the nodes between lanes; the one behind the last lane has none behind it
      const auto next = value([at = order_.first + 1](const double* x) { return load_lanes(x + at); });
      Lanes terms = of_row(1, finish(join(here, next)));
      change_lanes(terms, [](auto& lanes) { lanes.back() = 0.0; });
      of_rows += terms;
    }
    return sum_by_lanes(last - 1, [&, x = joined + 1](auto&& at) { return of_edge(at, finish(at(x))); }) +
           sum_of(of_rows);
  };
  if (!of)
    return sums([](std::size_t, const Lanes& terms) { return terms; },
                [](auto&&, const Lanes& terms) { return terms; });
  const double* const rows = reinterpret_cast<const double*>(of->of_rows.data());
  return sums([rows](std::size_t at, const Lanes& terms) { return load_lanes(rows + at) * terms; },
              [edges = of->of_edges.data() + 1](auto&& at, const Lanes& terms) { return at(edges) * terms; });
}

// As the following sums, all is inlined: which operations are contracted would else depend on the processor's level.
[[gnu::flatten]] double LaneBar::squared_strain_rate(std::span<const double> p, double lever,
                                                     std::span<const double> a) const {
  const bool alike = system_.elements().rows_alike();
  const std::vector<double>& weights = system_.elements().rate_weights();
  const Weights& of = viscous_.of_rows.empty() ? elastic_ : viscous_;
  double sum = sum_over_elements(
      alike ? nullptr : &of, alike ? nullptr : &weights[system_.unknowns().first_node()],
      [ lever, p = p.data(), a = a.data() ](auto&& load)
          __attribute__((always_inline)) { return load(p) + lever * load(a); },
      [](const auto& i, const auto& j) __attribute__((always_inline)) { return j - i; },
      [](const auto& difference) __attribute__((always_inline)) { return difference * difference; });
  const auto node = [=, p = p.data(), a = a.data()](std::size_t i) { return p[i] + lever * a[i]; };
  const std::size_t n = order_.size;
  if (system_.unknowns().left_fixed()) sum += node(0) * node(0) * (alike ? 1.0 : weights.front());
  if (system_.unknowns().right_fixed()) sum += node(n - 1) * node(n - 1) * (alike ? 1.0 : weights.back());
  return alike ? sum / system_.mesh().spacing() : sum;
}

[[gnu::flatten]] double LaneBar::skew_power(std::span<const double> p, std::span<const double> a) const {
  return sum_over_elements(
      &skew_, nullptr, [ p = p.data(), a = a.data() ](auto&& load) __attribute__((always_inline)) {
        return std::array{load(p), load(a)};
      },
      [](const auto& i, const auto& j) __attribute__((always_inline)) { return i[0] * j[1] - j[0] * i[1]; },
      [](const auto& joined) { return joined; });
}

[[gnu::flatten]] double power(std::span<const double> load, std::span<const double> p, double lever,
                              std::span<const double> a) {
  return sum_by_lanes(load.size(), [lever, load = load.data(), p = p.data(), a = a.data()](auto&& at) {
    return at(load) * (at(p) + lever * at(a));
  });
}

}  // namespace viscobar

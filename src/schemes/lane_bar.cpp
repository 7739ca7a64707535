#include "schemes/lane_bar.hpp"

#include <array>

#include "discretisation/partial_sums.hpp"

namespace viscobar {

namespace {

// Functions that rows of lanes pass through are inlined: else they go through memory, four registers at a time.

// Stress per E / h: u_j - u_i + (eta / E) (w_j - w_i) of the nodes, or rows, stored at i and j.
struct ViscousStress {
  double relaxation;
  const double *u, *w;
  double nodes(std::size_t i, std::size_t j) const { return u[j] - u[i] + relaxation * (w[j] - w[i]); }
  [[gnu::always_inline]] Lanes rows(std::size_t i, std::size_t j) const {
    return load_lanes(u + j) - load_lanes(u + i) + relaxation * (load_lanes(w + j) - load_lanes(w + i));
  }
};

struct ElasticStress {
  const double* u;
  double nodes(std::size_t i, std::size_t j) const { return u[j] - u[i]; }
  [[gnu::always_inline]] Lanes rows(std::size_t i, std::size_t j) const {
    return load_lanes(u + j) - load_lanes(u + i);
  }
};

[[gnu::always_inline]] inline Lanes with_lane(std::size_t lane, double value, const Lanes& lanes) {
  std::array<double, lane_count> values;
  store_lanes(lanes, values.data());
  values[lane] = value;
  return load_lanes(values.data());
}

// Stresses of the elements in front of the stretches, and below of those behind: a stretch follows the separator of the
// one before.
template <class Stress>
[[gnu::always_inline]] inline Lanes in_front(const LaneOrder& order, const Stress& stress) {
  const double first = stress.nodes(order.first - 1, order.first);
  return with_lane(0, first, stress.rows(order.row(order.rows - 1) - 1, order.first));
}
template <class Stress>
[[gnu::always_inline]] inline Lanes behind(const LaneOrder& order, const Stress& stress) {
  const std::size_t separators = order.row(order.rows - 1), end = order.row(order.rows);
  return with_lane(lane_count - 1, stress.nodes(end - 1, end), stress.rows(separators, order.first + 1));
}

// Forces on the nodes in their order; `left` and `right` are the stresses beyond the first and the last one. Each
// stress is made twice, so that no node waits for another.
template <class Stress>
void forces_in_order(const Stress& stress, double scale, double left, double right, std::span<const double> load,
                     std::span<double> out) {
  const std::size_t last = out.size() - 1;
  const auto fill = [&, force = out.data()](auto&& load_at) {
    force[0] = scale * ((last > 0 ? stress.nodes(0, 1) : right) - left) + load_at(0);
#pragma GCC ivdep
    for (std::size_t i = 1; i < last; ++i)
      force[i] = scale * (stress.nodes(i, i + 1) - stress.nodes(i - 1, i)) + load_at(i);
    if (last > 0) force[last] = scale * (right - stress.nodes(last - 1, last)) + load_at(last);
  };
  if (load.empty())
    fill([](std::size_t) { return 0.0; });
  else
    fill([values = load.data()](std::size_t i) { return values[i]; });
}

// Forces of the end nodes beside the rows.
template <class Stress>
void end_forces(const LaneOrder& order, const Stress& stress, double scale, double left, double right,
                std::span<double> interface) {
  const std::size_t n = order.size(), skipped = n - interface.size();
  const auto forces = [&](std::size_t begin, std::size_t end, double before, double* out) {
    for (std::size_t i = begin; i < end; ++i) {
      const double next = i + 1 < n ? stress.nodes(i, i + 1) : right;
      *out++ = scale * (next - before);
      before = next;
    }
  };
  forces(0, order.first, left, interface.data());
  const std::size_t begin = n - order.last;
  forces(begin, n, stress.nodes(begin - 1, begin), &interface[begin - skipped]);
}

template <class Stress>
void eliminate(const LaneFactor& factor, const Stress& stress, double scale, std::span<const double> load,
               std::span<double> y, std::span<double> interface) {
  const LaneOrder& order = factor.order();
  const std::size_t m = factor.inner_rows(), separators = order.row(m);
  Lanes at_separators = scale * (behind(order, stress) - stress.rows(order.row(m - 1), separators));
  auto force = [ stress, row = order.row(0), before = in_front(order, stress) ](std::size_t k) mutable
      __attribute__((always_inline)) {
    const std::size_t here = row + k * lane_count;
    const Lanes next = stress.rows(here, here + lane_count), difference = next - before;
    before = next;
    return difference;
  };
  if (load.empty()) {
    store_lanes(at_separators, &interface[order.first]);
    return factor.eliminate(force, y, interface);
  }
  for (std::size_t i = 0; i < order.first; ++i) interface[i] += load[i];
  store_lanes(at_separators + load_lanes(&load[separators]), &interface[order.first]);
  for (std::size_t i = 1; i <= order.last; ++i) interface[interface.size() - i] += load[load.size() - i];
  auto loaded = [ force, rows = &load[order.row(0)], per_scale = 1.0 / scale ](std::size_t k) mutable
      __attribute__((always_inline)) {
    return force(k) + per_scale * load_lanes(rows + k * lane_count);
  };
  factor.eliminate(loaded, y, interface);
}

}  // namespace

double LaneBar::stiffness(const BarSystem& system) { return system.bar().modulus / system.mesh().spacing(); }

void LaneBar::eliminate_force(const LaneFactor& factor, std::span<const double> u, std::span<const double> w,
                              std::span<const double> load, std::span<double> y, std::span<double> interface) const {
  if (!rows_alike(system_)) {
    system_.internal_force(u, w, interface);
    double* const force = interface.data();
#pragma GCC ivdep
    for (std::size_t i = 0; i < load.size(); ++i) force[i] += load[i];
    return;
  }
  const double relaxation = system_.bar().viscosity / system_.bar().modulus;
  const std::size_t n = order_.size();
  const std::optional<double>&left_end = system_.wall(false), &right_end = system_.wall(true);
  const double left = left_end ? u[0] - *left_end + relaxation * w[0] : 0.0;
  const double right = right_end ? *right_end - u[n - 1] - relaxation * w[n - 1] : 0.0;
  const auto run = [&](const auto& stress) {
    const double scale = stiffness(system_);
    if (order_.rows == 0)
      forces_in_order(stress, scale, left, right, load, interface);
    else
      end_forces(order_, stress, scale, left, right, interface);
    for (const Support& support : system_.supports())
      (support.unknown == 0 ? interface.front() : interface.back()) -=
          support.stiffness * u[support.unknown] + support.dashpot * w[support.unknown];
    if (order_.rows > 0) eliminate(factor, stress, scale, load, y, interface);
  };
  if (system_.damped())
    run(ViscousStress{relaxation, u.data(), w.data()});
  else
    run(ElasticStress{u.data()});
}

double LaneBar::squared_strain_rate(std::span<const double> p, double lever, std::span<const double> a) const {
  const std::size_t n = order_.size();
  const auto node = [=, p = p.data(), a = a.data()](std::size_t i) { return p[i] + lever * a[i]; };
  const auto squared = [&](std::size_t i, std::size_t j) { return (node(j) - node(i)) * (node(j) - node(i)); };
  double sum = 0.0;
  if (!system_.rows_alike()) {
    const std::vector<double>& weights = system_.rate_weights();
    sum = partial_sums(n - 1,
                       [&, of = &weights[system_.first_node()]](std::size_t i) { return squared(i, i + 1) * of[i]; });
    if (system_.left_fixed()) sum += node(0) * node(0) * weights.front();
    if (system_.right_fixed()) sum += node(n - 1) * node(n - 1) * weights.back();
    return sum;
  }
  for (std::size_t i = 0; i + 1 < order_.first; ++i) sum += squared(i, i + 1);
  if (order_.rows > 0) {
    const std::size_t separators = order_.row(order_.rows - 1), end = order_.row(order_.rows);
    sum += squared(order_.first - 1, order_.first) + squared(end - 1, end);
    for (std::size_t l = 1; l < lane_count; ++l) sum += squared(separators + l - 1, order_.first + l);
    const auto row = [&](std::size_t k) {
      return load_lanes(&p[order_.row(k)]) + lever * load_lanes(&a[order_.row(k)]);
    };
    Lanes here = row(0), sums = 0.0;
    for (std::size_t k = 1; k < order_.rows; ++k) {
      const Lanes next = row(k), difference = next - here;
      sums += difference * difference;
      here = next;
    }
    sum += std::experimental::reduce(sums);
    for (std::size_t i = n - order_.last; i + 1 < n; ++i) sum += squared(i, i + 1);
  }
  if (system_.left_fixed()) sum += node(0) * node(0);
  if (system_.right_fixed()) sum += node(n - 1) * node(n - 1);
  return sum / system_.mesh().spacing();
}

double power(std::span<const double> load, std::span<const double> p, double lever, std::span<const double> a) {
  Lanes sums = 0.0;
  std::size_t i = 0;
  for (; i + lane_count <= load.size(); i += lane_count)
    sums += load_lanes(&load[i]) * (load_lanes(&p[i]) + lever * load_lanes(&a[i]));
  double sum = std::experimental::reduce(sums);
  for (; i < load.size(); ++i) sum += load[i] * (p[i] + lever * a[i]);
  return sum;
}

}  // namespace viscobar

#include "schemes/lane_bar.hpp"

#include <array>

namespace viscobar {

namespace {

// k (u_j - u_i) + c (w_j - w_i) of the nodes, or rows, stored at i and j.
struct ViscousStress {
  double stiffness, damping;
  const double *u, *w;
  double nodes(std::size_t i, std::size_t j) const { return stiffness * (u[j] - u[i]) + damping * (w[j] - w[i]); }
  Lanes rows(std::size_t i, std::size_t j) const {
    return stiffness * (load_lanes(u + j) - load_lanes(u + i)) + damping * (load_lanes(w + j) - load_lanes(w + i));
  }
};

struct ElasticStress {
  double stiffness;
  const double* u;
  double nodes(std::size_t i, std::size_t j) const { return stiffness * (u[j] - u[i]); }
  Lanes rows(std::size_t i, std::size_t j) const { return stiffness * (load_lanes(u + j) - load_lanes(u + i)); }
};

// Of the elements in front of the stretches, and of the one behind the last.
template <class Nodes>
std::array<double, lane_count + 1> at_borders(const LaneOrder& order, const Nodes& nodes) {
  std::array<double, lane_count + 1> values;
  const std::size_t separators = order.row(order.rows - 1);
  values[0] = nodes(order.first - 1, order.first);
  for (std::size_t l = 1; l < lane_count; ++l) values[l] = nodes(separators + l - 1, order.first + l);
  values[lane_count] = nodes(separators + lane_count - 1, separators + lane_count);
  return values;
}

// Forces of the end nodes: `left` and `right` are the stresses beyond the first and the last node.
template <class Stress>
void end_forces(const LaneOrder& order, const Stress& stress, double left, double right, std::span<double> interface) {
  const std::size_t n = order.size(), skipped = n - interface.size();
  double before = left;
  for (std::size_t i = 0; i < order.first; ++i) {
    const double behind = i + 1 < n ? stress.nodes(i, i + 1) : right;
    interface[i] = behind - before;
    before = behind;
  }
  if (order.rows == 0) return;
  before = stress.nodes(n - order.last - 1, n - order.last);
  for (std::size_t i = n - order.last; i < n; ++i) {
    const double behind = i + 1 < n ? stress.nodes(i, i + 1) : right;
    interface[i - skipped] = behind - before;
    before = behind;
  }
}

template <class Stress>
void eliminate(const LaneFactor& factor, const Stress& stress, std::span<const double> load, std::span<double> y,
               std::span<double> interface) {
  const LaneOrder& order = factor.order();
  const std::size_t m = factor.inner_rows(), separators = order.row(m);
  const auto borders = at_borders(order, [&](std::size_t i, std::size_t j) { return stress.nodes(i, j); });
  store_lanes(load_lanes(&borders[1]) - stress.rows(order.row(m - 1), separators), &interface[order.first]);
  auto force = [stress, row = order.row(0), before = load_lanes(&borders[0])](std::size_t k) mutable {
    const std::size_t here = row + k * lane_count;
    const Lanes behind = stress.rows(here, here + lane_count), difference = behind - before;
    before = behind;
    return difference;
  };
  if (load.empty()) return factor.eliminate(force, y, interface);
  for (std::size_t i = 0; i < interface.size(); ++i)
    interface[i] += load[i < order.first ? i : i + (order.size() - interface.size())];
  auto loaded = [force, rows = &load[order.row(0)]](std::size_t k) mutable {
    return force(k) + load_lanes(rows + k * lane_count);
  };
  factor.eliminate(loaded, y, interface);
}

}  // namespace

void LaneBar::eliminate_force(const LaneFactor& factor, std::span<const double> u, std::span<const double> w,
                              std::span<const double> load, std::span<double> y, std::span<double> interface) const {
  const double h = system_.mesh().spacing();
  const double stiffness = system_.bar().modulus / h, damping = system_.bar().viscosity / h;
  const std::size_t n = order_.size();
  const auto left_end = system_.left_displacement(), right_end = system_.right_displacement();
  const double left = left_end ? stiffness * (u[0] - *left_end) + damping * w[0] : 0.0;
  const double right = right_end ? stiffness * (*right_end - u[n - 1]) - damping * w[n - 1] : 0.0;
  const auto run = [&](const auto& stress) {
    end_forces(order_, stress, left, right, interface);
    if (order_.rows > 0) return eliminate(factor, stress, load, y, interface);
    for (std::size_t i = 0; i < load.size(); ++i) interface[i] += load[i];
  };
  if (system_.damped())
    run(ViscousStress{stiffness, damping, u.data(), w.data()});
  else
    run(ElasticStress{stiffness, u.data()});
}

double LaneBar::squared_strain_rate(std::span<const double> p, double lever, std::span<const double> a) const {
  const std::size_t n = order_.size();
  const auto node = [&](std::size_t i) { return p[i] + lever * a[i]; };
  const auto squared = [&](std::size_t i, std::size_t j) { return (node(j) - node(i)) * (node(j) - node(i)); };
  double sum = 0.0;
  for (std::size_t i = 0; i + 1 < order_.first; ++i) sum += squared(i, i + 1);
  if (order_.rows > 0) {
    for (const double border : at_borders(order_, squared)) sum += border;
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

#pragma once

#include <algorithm>
#include <cstddef>
#include <span>
#include <variant>
#include <vector>

#include "viscobar/scene/scene.hpp"

namespace viscobar::oracle {

/// Displacements of the ends of an undamped bar at t = k L / (N c), and of its N + 1 nodes at the last of them and at
/// those of `kept`, which ascend: a difference
/// scheme at Courant number 1, which shares with the method `characteristics` that waves are carried unchanged, and
/// nothing else. The bar is N cells with the mean of v -+ c u_x; a step moves them by a cell, adds the load in its
/// middle, and puts an end that would pass its obstacle on it. Exact up to 1 / N: where a contact changes within a
/// step.
struct CellWaves {
  std::vector<double> left, right;  // a step each
  std::vector<double> nodes;
  std::vector<std::vector<double>> fields;  // of the steps kept
  double step = 0.0;

  CellWaves(const Scene& scene, std::size_t cells, std::size_t steps, std::span<const std::size_t> kept = {}) {
    const Bar& bar = scene.bar;
    const double c = bar.wave_speed(), dx = bar.length / static_cast<double>(cells);
    step = dx / c;
    const auto x = [&](double j) { return dx * j; };
    std::vector<double> a(cells), b(cells);  // rightward and leftward, of cell (j, j + 1)
    for (std::size_t j = 0; j < cells; ++j) {
      const auto at = static_cast<double>(j);
      double v = 0.0;
      for (const double part : {0.1, 0.3, 0.5, 0.7, 0.9}) v += 0.2 * scene.velocity(x(at + part));
      const double e = c * (scene.displacement(x(at + 1.0)) - scene.displacement(x(at))) / dx;
      a[j] = v - e;
      b[j] = v + e;
    }
    double u_left = scene.displacement(0.0), u_right = scene.displacement(bar.length);
    left = {u_left};
    right = {u_right};
    // Rings: the cell that is first moves, not the cells.
    std::size_t first_a = 0, first_b = 0;
    const auto load = [&](double place, double t) {
      if (const auto* steady = std::get_if<SteadyLoad>(&*scene.load)) return steady->profile(place);
      if (const auto* separable = std::get_if<SeparableLoad>(&*scene.load))
        return separable->profile(place) * separable->history(t);
      return std::get<GeneralLoad>(*scene.load).density(place, t);
    };
    const auto at_nodes = [&] {
      std::vector<double> u = {u_left};
      for (std::size_t j = 0; j < cells; ++j)
        u.push_back(u.back() + 0.5 * step * (b[(first_b + j) % cells] - a[(first_a + j) % cells]));
      return u;
    };
    for (std::size_t n = 0; n < steps; ++n) {
      if (fields.size() < kept.size() && kept[fields.size()] == n) fields.push_back(at_nodes());
      const double t = step * (static_cast<double>(n) + 0.5);
      const std::size_t last_a = (first_a + cells - 1) % cells;
      double arriving_left = b[first_b], arriving_right = a[last_a];
      if (scene.load) {
        // A cell passes a node within the step; the ones at the ends are on their way for half of it.
        for (std::size_t j = 0; j + 1 < cells; ++j) {
          const double gain = step / bar.density * load(x(static_cast<double>(j) + 1.0), t);
          a[(first_a + j) % cells] += gain;
          b[(first_b + j + 1) % cells] += gain;
        }
        arriving_left += 0.5 * step / bar.density * load(x(0.25), t - 0.25 * step);
        arriving_right += 0.5 * step / bar.density * load(x(static_cast<double>(cells) - 0.25), t - 0.25 * step);
      }
      double sent_left = answered(scene.left, arriving_left, u_left);
      double sent_right = answered(scene.right, arriving_right, u_right);
      if (scene.load) {
        sent_left += 0.5 * step / bar.density * load(x(0.25), t + 0.25 * step);
        sent_right += 0.5 * step / bar.density * load(x(static_cast<double>(cells) - 0.25), t + 0.25 * step);
      }
      a[last_a] = sent_left;
      first_a = last_a;
      b[first_b] = sent_right;
      first_b = (first_b + 1) % cells;
      left.push_back(u_left);
      right.push_back(u_right);
    }
    nodes = at_nodes();
    if (fields.size() < kept.size()) fields.push_back(nodes);
  }

 private:
  double answered(const EndCondition& end, double arriving, double& u) const {
    if (is_fixed(end)) return -arriving;
    const auto* obstacle = std::get_if<Obstacle>(&end);
    const double free = u + step * arriving, held = obstacle ? std::max(free, -obstacle->gap) : free;
    u = held;
    return arriving + 2.0 * (held - free) / step;
  }
};

}  // namespace viscobar::oracle

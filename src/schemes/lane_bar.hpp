#pragma once

#include <span>

#include "discretisation/lane_factor.hpp"
#include "viscobar/dynamics/bar_system.hpp"

namespace viscobar {

/// Forces of a uniform bar on its nodes in a LaneOrder: every element's stress is the same function of
/// the differences between its two nodes, of a row and the next one, or of two nodes at the border of the stretches.
/// On a graded mesh, where no two elements are alike, and with a side that resists the order has no rows and the force
/// is BarSystem's.
class LaneBar {
 public:
  LaneBar(const BarSystem& system, const LaneOrder& order) : system_(system), order_(order) {}

  /// True if the rows of the bar are alike, and a step can take them side by side.
  static bool rows_alike(const BarSystem& system) { return system.rows_alike() && !system.side(); }
  /// E / h, by which the factor must be scaled: the rows of the force are made per E / h.
  static double stiffness(const BarSystem& system);

  /// First sweep of A a = -(E K u + eta K w) + load, the force made row by row on the way. y receives the eliminated
  /// rows, `interface` its right-hand side; `load` is empty when there is none.
  void eliminate_force(const LaneFactor& factor, std::span<const double> u, std::span<const double> w,
                       std::span<const double> load, std::span<double> y, std::span<double> interface) const;

  /// int w_x^2 of the velocity w = p + lever a
  double squared_strain_rate(std::span<const double> p, double lever, std::span<const double> a) const;

 private:
  const BarSystem& system_;
  LaneOrder order_;
};

/// sum_i load_i (p_i + lever a_i), in any order of the nodes
double power(std::span<const double> load, std::span<const double> p, double lever, std::span<const double> a);

}  // namespace viscobar

#pragma once

#include <array>
#include <span>
#include <vector>

#include "discretisation/lane_factor.hpp"
#include "viscobar/dynamics/bar_system.hpp"

namespace viscobar {

/// Forces of the bars on their nodes in a LaneOrder: an element's stress is a function of the differences between its
/// two nodes, of a row and the next one, or of two nodes where a run ends. Without rows, as with a side that resists,
/// the force of bars whose elements are not alike is BarSystem's.
class LaneBar {
 public:
  LaneBar(const BarSystem& system, const LaneOrder& order);

  /// The factor of the step's matrix, scaled as the rows of the force are made.
  static LaneFactor factor(const BarSystem& system, const BandedMatrix& matrix);

  /// First sweep of A a = -(E K u + eta K w) + load, the force made row by row on the way. y receives the eliminated
  /// rows, `interface` its right-hand side; `load` is empty when there is none.
  void eliminate_force(const LaneFactor& factor, std::span<const double> u, std::span<const double> w,
                       std::span<const double> load, std::span<double> y, std::span<double> interface) const;

  /// int w_x^2 of the velocity w = p + lever a
  double squared_strain_rate(std::span<const double> p, double lever, std::span<const double> a) const;

  /// p.S a of the skew part S of the inertia, which has one, on rows
  double skew_power(std::span<const double> p, std::span<const double> a) const;

 private:
  // Elements in no row: where their two nodes are stored, and their numbers. A processor gathers several at once.
  struct Edges {
    std::vector<std::size_t> i, j, element;
  };
  // A run ends in front of a row, but for row 0, and the next of its lane begins, but for the last: its lane, and the
  // edges at either place.
  struct Break {
    std::size_t row, lane = 0, behind = 0, before = 0;
  };
  struct Weights {
    std::vector<double> of_edges;
    std::vector<Lanes> of_rows;  // of the elements in front of them, and behind the last; not even: 0 beside runs
  };
  Weights weights(const std::vector<double>& of_elements) const;
  void take_edges();
  template <class Rows>
  struct BrokenRows;
  template <class Value, class Join, class Finish>
  double sum_over_elements(const Weights* of, const double* in_order, Value&& value, Join&& join,
                           Finish&& finish) const;
  template <class Stress>
  void interface_forces(const Stress& stress, std::array<double, 2> walls, std::span<const double> load,
                        std::span<double> interface) const;
  template <class Stress>
  void eliminate_unlike(const LaneFactor& factor, const Stress& stress, std::span<const double> load,
                        std::span<double> y, std::span<double> interface) const;

  const BarSystem& system_;
  const LaneOrder& order_;
  double scale_, relaxation_;  // of stresses: E / h, or E; eta / E
  // Where elements are not alike: int dx / A of elasticity, and of viscosity where it is another.
  Weights elastic_, viscous_;
  Weights skew_;                          // (M_{i,i+1} - M_{i+1,i}) / 2
  Edges edges_;                           // rising; of a node of the interface the one before and the one behind
  std::vector<std::size_t> fronts_;       // of each node of the interface the edge before it; the walls are edges, too
  std::vector<Break> breaks_;             // by row
  mutable std::vector<double> stresses_;  // one an edge
};

/// sum_i load_i (p_i + lever a_i), in any order of the nodes
double power(std::span<const double> load, std::span<const double> p, double lever, std::span<const double> a);

}  // namespace viscobar

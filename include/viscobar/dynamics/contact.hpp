#pragma once

#include <cstddef>
#include <span>

namespace viscobar {

/// Where a contact is: at an obstacle, or at a joint of a chain.
enum class Where { left, right, span, joint };

/// A node that an obstacle bounds: g = s u_node + gap >= 0, with the reaction s R, R >= 0. At a joint it is bounded by
/// the node before it, g = u_node - u_{node-1} + gap, on which R acts in the other direction.
struct Contact {
  std::size_t unknown = 0;    ///< index among the unknowns
  double gap = 0.0;           ///< >= 0
  double weight = 1.0;        ///< 1 at an end; trapezoidal weight of the node under a span obstacle
  Where where = Where::left;  ///< of the obstacle
  double sign = 1.0;          ///< s: 1 for an obstacle below, -1 for one above
  std::size_t joint = 0;      ///< number of its joint, from 1; 0: it is not at one

  double clearance(double u) const { return sign * u + gap; }  ///< g; at a joint of u_node - u_{node-1}
  /// u_node, or w_node, against what bounds it: at a joint less that of the node before.
  double of(std::span<const double> x) const { return joint > 0 ? x[unknown] - x[unknown - 1] : x[unknown]; }
  bool at_end() const { return where == Where::left || where == Where::right; }  ///< of the whole chain
};

}  // namespace viscobar

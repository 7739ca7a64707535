#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "viscobar/case/case.hpp"

namespace viscobar::accuracy {

/// The power of h with which the error falls where the motion is smooth: 4 on `fourth_order`, else 2. On a span
/// obstacle the border of what touches moves from node to node: 2 on any mass, and 1 where nodes are thrown back or
/// nothing damps what their impacts leave.
double order_in_theory(const Case& run);

/// Two neighbouring meshes of a ladder and how far their runs are apart.
struct MeshStep {
  std::size_t coarse = 0, fine = 0;  ///< elements
  double distance = 0.0;             ///< of their runs
  double alignment = 1.0;            ///< cosine of the change of the solution in it and in the step before
};

/// The error of the finest mesh of a ladder.
///
/// With e = C h^p and d = e(coarse) - e(fine), r the ratio of the two meshes, e(fine) = d / (r^p - 1). Three meshes
/// show an order, by d_1 / d_2 = (r_1^p - 1) / (1 - r_2^-p). The least of the last two such orders and that of theory
/// P, of which the latter counts unless the orders are above it and do not fall yet, is believed where
///
///     it is 1 or more,   the orders do not fall from step to step by more than 3/4, or to no less than P - 3/4,
///     the last two changes of the solution point the same way: cosine >= 9/10, and 1/2 for P = 2,
///
/// and the error is then taken two fifths larger, 7/5 d / (r^p - 1); where the last order is above P + 3/2, twice
/// that, with d no less than d_1 shows with P, for a difference that falls so fast may have met a zero.
///
/// Elsewhere order 1 is counted on, and less where the last order p is below 1. With q = r^-p, changes that go on by q
/// add up to d q / (1 - q). Where each has the cosine c >= 0 to the one before, it is a walk, whose length is
///
///     d q ((1 + c q) / ((1 - c q) (1 - q^2)))^(1/2),
///
/// and two fifths more are taken of that. Where c >= 0 half of what the orders are above 1 is believed:
/// 7/5 d / (r^(1/2 + p/2) - 1). The least of these is the error.
struct SpaceError {
  double error = 0.0;             ///< of the finest mesh
  double order = 1.0;             ///< that was observed; of theory where none could be
  std::optional<double> trusted;  ///< the order that the error relies on
  double effectivity = 1.0;       ///< error / (d / (r^P - 1)), P the order of theory
  bool settles = true;            ///< false where three differences grow and the last two point the same way
};
SpaceError space_error(std::span<const MeshStep> ladder, double theory);

/// The order with which the next mesh of a ladder may be expected to come nearer: the last one observed. Two meshes
/// show none, and 1 is expected.
double expected_order(std::span<const MeshStep> ladder, double theory);

/// The ladder with a mesh that has not been run as its finest one: d falls by that order once more.
std::vector<MeshStep> prolonged(std::vector<MeshStep> ladder, std::size_t elements, double order);

}  // namespace viscobar::accuracy

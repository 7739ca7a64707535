#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <span>

#include "dynamics/contacts.hpp"

namespace viscobar {

/// The row beside a contact at a joint, without the contact itself: that of the end of a bar, or of a rigid body that
/// no other contact meets,
///
///     sign N = inertia . (a_node, a_next, a_beyond) + k (u_node - u_next) + c (w_node - w_next)
///              + k_0 u_node + c_0 w_node - f_0 + (M (k u + c w))_node - (M f)_node,
///
/// with k_0, c_0 and f_0 of a spring to the ground, and M (k u + c w) of resistance along the bar.
struct JointRow {
  std::size_t node, next, beyond;           ///< unknowns, from the joint inwards
  double sign;                              ///< 1 where the row is to the right of the joint, -1 to the left
  double scale;                             ///< E / h, by which the indicator counts N
  double stiffness = 0.0, viscosity = 0.0;  ///< k, c
  double ground_stiffness = 0.0, ground_viscosity = 0.0, ground_force = 0.0;  ///< k_0, c_0, f_0
  std::array<double, 3> inertia{}, side_stiffness{}, side_drag{};             ///< of the three nodes
  /// The row of rho M times v: of velocities the row's momentum, of accelerations its force of inertia.
  double inertia_times(std::span<const double> v) const {
    return inertia[0] * v[node] + inertia[1] * v[next] + inertia[2] * v[beyond];
  }
};
/// Where the contact is by_law it has b and a for nodes, and zeros.
JointRow joint_row(const Contacts& contacts, std::size_t i);
/// N = m a + k_0 u + c_0 w - f_0 - (M f): the row of the lighter rigid body at contact i, a joint, which nothing else
/// holds now, neither a spring to another member nor a closed contact. Absent: both are held. Its error is that of m a.
/// The bar's row is wrong by (E / h) du + (eta / h) dw: that may be more than all that moves a light body.
std::optional<JointRow> row_of_free_body(const Contacts& contacts, std::size_t i);
/// The row that tells N of a closed contact best as the contacts are now: that of a free body, or else joint_row().
inline JointRow holding_row(const Contacts& contacts, std::size_t i) {
  const std::optional<JointRow> of_body = row_of_free_body(contacts, i);
  return of_body ? *of_body : joint_row(contacts, i);
}

/// The unknown beside an end.
inline std::size_t neighbour(std::size_t end) { return end == 0 ? 1 : end - 1; }
/// Off the diagonal of rho M in the row of an end: at its neighbour, and at the next one.
std::array<double, 2> inertia_beside(const BandedMatrix& inertia, std::size_t end);
/// The row of rho M of contact i, whose nodes do not move against each other or the ground, times v: of velocities what
/// it has of momentum, in the direction in which the contact pushes the node.
double held_inertia_times(const Contacts& contacts, std::size_t i, std::span<const double> v);

}  // namespace viscobar

#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <optional>
#include <span>

#include "dynamics/contacts.hpp"

namespace viscobar {

/// The row beside a contact at a joint, or of an end's on a rigid body, without the contact itself: that of the end of
/// a bar, or of a rigid body, with those of what closed contacts hold together with it,
///
///     sign N = inertia . (a_node, a_next, a_beyond) + k (u_node - u_next) + c (w_node - w_next)
///              + k_0 u_node + c_0 w_node - f_0 + (M (k u + c w))_node - (M f)_node,
///
/// with k_0, c_0 and f_0 of a spring to the ground, and M (k u + c w) of resistance along the bar. Of an end N is s R.
struct JointRow {
  std::size_t node, next, beyond;           ///< unknowns, from the joint inwards; the last two of the end of the bar
  double sign;                              ///< 1 where the row is to the right of the joint, -1 to the left
  double scale;                             ///< E / h, by which the indicator counts N
  std::size_t last = node;                  ///< the rows from node to here are added
  double stiffness = 0.0, viscosity = 0.0;  ///< k, c
  double ground_stiffness = 0.0, ground_viscosity = 0.0, ground_force = 0.0;  ///< k_0, c_0, f_0
  std::array<double, 3> inertia{}, side_stiffness{}, side_drag{};             ///< of the three nodes
  /// The row of rho M times v: of velocities the row's momentum, of accelerations its force of inertia.
  double inertia_times(std::span<const double> v) const {
    return inertia[0] * v[node] + inertia[1] * v[next] + inertia[2] * v[beyond];
  }
  /// The sum of of_unknown(j) over the rows that are added.
  double sum_over_rows(auto&& of_unknown) const {
    double sum = 0.0;
    for (std::size_t j = std::min(node, last); j <= std::max(node, last); ++j) sum += of_unknown(j);
    return sum;
  }
};
/// The row as the contacts are now; its unknowns do not depend on that. Of bodies that move as one it has u and w of
/// the first. Where the contact is by_law it has b and a for nodes, and zeros.
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

/// The contact of an end with a rigid body which another contact meets; absent where it has none.
std::optional<std::size_t> contact_of_body(const Contacts& contacts, bool right);
/// The rows whose sum tells the impulse of the obstacle on an end: those of the unknowns from there to `last`. They are
/// that of the end alone, unless it is a rigid body which another contact meets: then those of all that closed rigid
/// contacts hold together with it.
struct EndRows {
  std::size_t last = 0;
  bool strained = true;  ///< an element beyond the last one pulls at it
  bool by_law = false;   ///< the obstacle's law tells its force, and no row is needed
  bool of_body = false;  ///< of such a rigid body
};
/// As the contacts are now, `struck`, one that takes part in an impact, counting as closed.
EndRows end_rows(const Contacts& contacts, std::size_t end, std::optional<std::size_t> struck = std::nullopt);

/// The unknown beside an end.
inline std::size_t neighbour(std::size_t end) { return end == 0 ? 1 : end - 1; }
/// Off the diagonal of rho M in the row of an end: at its neighbour, and at the next one.
std::array<double, 2> inertia_beside(const BandedMatrix& inertia, std::size_t end);
/// The rows of rho M that tell the impulse of contact i, whose nodes do not move against each other or the ground,
/// times changes v of velocities: as an impact of contact `struck` makes them, which changes those of its nodes apart.
double held_inertia_times(const Contacts& contacts, std::size_t i, std::span<const double> v,
                          std::optional<std::size_t> struck = std::nullopt);

}  // namespace viscobar

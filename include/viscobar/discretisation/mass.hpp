#pragma once

#include <string_view>

#include "viscobar/discretisation/mesh.hpp"
#include "viscobar/discretisation/tridiagonal.hpp"

namespace viscobar {

class VaryingSection;

/// How the inertia of the P1 functions is integrated.
enum class Mass {
  consistent,     ///< exact, (h/6) [2 1; 1 2] per element: scheme (2.8)
  lumped,         ///< trapezoidal, weight h, and h/2 at the ends: scheme (3.22) with its end weights corrected
  paper,          ///< weight h at every node, ends too: the product (3.23) as printed
  redistributed,  ///< consistent, but contact nodes are massless; see mass_matrix()
  fourth_order    ///< inner rows h (1, 10, 1) / 12, end rows h (7, 6, -1) / 24: see docs/fourth-order.md
};

/// In the order of the enumeration.
inline constexpr Mass all_masses[] = {Mass::consistent, Mass::lumped, Mass::paper, Mass::redistributed,
                                      Mass::fourth_order};

std::string_view name(Mass mass);     ///< in a scene file
std::string_view meaning(Mass mass);  ///< in half a sentence

/// P1 mass matrix of unit density over all nodes of the mesh, int A phi_i phi_j dx if consistent, contact nodes treated
/// alike: the matrix that weighs the load. `redistributed` gives the consistent matrix here. That of `fourth_order` has
/// end rows: what they are beside the symmetric (5, 1) / 12 is (h / 24) (-3, 4, -1), the difference that tells h^2 / 12
/// times the slope at the end. Where elements differ or the section varies its row i is int A phi_i a dx, a the
/// parabola through three nodes, and the matrix has a skew part, none in its first and last entry.
/// Without a section A = 1.
/// @throws std::invalid_argument for `paper` with a section or on a mesh that is not uniform, and for `fourth_order`
/// on less than three elements.
BandedMatrix mass_matrix(const Mesh& mesh, Mass mass, const VaryingSection* section = nullptr);

/// Inertia of unit density over all nodes when the ends marked are contact nodes. Differs from mass_matrix() only for
/// `redistributed`: the row of a marked end is zero, and the kinetic energy is that of the velocity field extrapolated
/// linearly to the end, v_0 = (1 + a) v_1 - a v_2 with the sizes' ratio a = h_0 / h_1 (2 v_1 - v_2 on a uniform mesh),
/// which keeps the total mass, the centre of mass and the moment of inertia of the end patch and leaves the matrix
/// tridiagonal. With a section sizes are those of VaryingSection.
/// @throws std::invalid_argument when the mesh has too few elements to redistribute: marked ends + 1 are needed.
BandedMatrix inertia_matrix(const Mesh& mesh, Mass mass, bool left_contact, bool right_contact,
                            const VaryingSection* section = nullptr);

}  // namespace viscobar

#pragma once

#include <cstddef>
#include <span>

#include "viscobar/discretisation/mesh.hpp"
#include "viscobar/scene/scene.hpp"

namespace viscobar {

/// Mean stress of element j, whatever its section, (E (u_{j+1} - u_j) + eta (v_{j+1} - v_j)) / h_j, of J+1 nodal
/// values; 0 at a joint of a chain, an element of no length.
inline double element_stress(const Bar& bar, const Mesh& mesh, std::span<const double> u, std::span<const double> v,
                             std::size_t j) {
  const double size = mesh.element(j);
  return size > 0.0 ? (bar.modulus * (u[j + 1] - u[j]) + bar.viscosity * (v[j + 1] - v[j])) / size : 0.0;
}

}  // namespace viscobar

#pragma once

#include <cstddef>
#include <memory>
#include <vector>

#include "discretisation/varying_section.hpp"
#include "viscobar/discretisation/mesh.hpp"
#include "viscobar/scene/scene.hpp"

namespace viscobar {

/// A member of a chain on its part of the mesh: a bar, or a rigid body, which is one node. A bar alone is one piece.
struct Piece {
  Mesh mesh;              ///< its own, from 0 on; a rigid body has no elements
  std::size_t first = 0;  ///< its first node; the element to the right of a node has its number
  double begin = 0.0;     ///< x of its left end
  Bar bar;
  double mass = 0.0;                              ///< of a rigid body
  std::shared_ptr<const VaryingSection> section;  ///< null: A = 1
  SpaceFunction displacement, velocity;           ///< of x from its left end

  bool rigid() const { return mesh.elements == 0; }
  std::size_t last() const { return first + mesh.elements; }  ///< its last node
  /// int dx / A over one of its elements.
  double stretch(std::size_t element) const { return section ? section->stretch(element) : mesh.element(element); }
};

/// Those of a scene on a mesh.
/// @throws std::invalid_argument where the mesh is not that of the chain
std::vector<Piece> pieces_of(const Scene& scene, const Mesh& mesh);

/// The material of each element of a chain, nothing's at joints; empty for a bar alone, whose elements are all alike.
std::vector<Bar> element_bars(const Scene& scene, const Mesh& mesh);

}  // namespace viscobar

#pragma once

#include <cstddef>
#include <memory>
#include <vector>

#include "discretisation/varying_section.hpp"
#include "viscobar/discretisation/mesh.hpp"
#include "viscobar/scene/scene.hpp"

namespace viscobar {

/// A bar of a scene, the only one or a member of a chain.
struct SceneBar {
  std::size_t member;  ///< of the chain
  double begin;        ///< x of its left end
  const Bar& bar;
  const SpaceFunction& section;  ///< empty: A = 1

  double area(double x) const { return section ? section(x) : 1.0; }  ///< x from its left end
};

/// Those of a scene from left to right, without its rigid bodies. It outlives them.
std::vector<SceneBar> scene_bars(const Scene& scene);

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
  bool has(std::size_t node) const { return first <= node && node <= last(); }
  /// int dx / A over one of its elements.
  double stretch(std::size_t element) const { return section ? section->stretch(element) : mesh.element(element); }
  /// A of one of them, as its stiffness has it.
  double area(std::size_t element) const { return mesh.element(element) / stretch(element); }
  std::size_t end_element(bool right) const { return right ? mesh.elements - 1 : 0; }  ///< its last or its first one
};

/// The bar that is nearest to an end.
const Piece& end_bar(const std::vector<Piece>& pieces, bool right);
/// A bar of section 1 with the mass, the stiffness and the viscosity of one of section A.
inline Bar whole_section(Bar bar, double area) {
  bar.density *= area, bar.modulus *= area, bar.viscosity *= area;
  return bar;
}
/// The bar that a node is of, as whole_section() there; of a rigid body alone nothing.
Bar bar_at(const std::vector<Piece>& pieces, std::size_t node);

/// Those of a scene on a mesh.
/// @throws std::invalid_argument where the mesh is not that of the chain
std::vector<Piece> pieces_of(const Scene& scene, const Mesh& mesh);

/// The material of each element of a chain, nothing's at joints; empty for a bar alone, whose elements are all alike.
std::vector<Bar> element_bars(const Scene& scene, const Mesh& mesh);

}  // namespace viscobar

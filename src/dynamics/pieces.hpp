#pragma once

#include <array>
#include <cstddef>
#include <memory>
#include <vector>

#include "discretisation/varying_section.hpp"
#include "viscobar/discretisation/mass.hpp"
#include "viscobar/discretisation/mesh.hpp"
#include "viscobar/discretisation/tridiagonal.hpp"
#include "viscobar/scene/scene.hpp"

namespace viscobar {

/// A member of a chain on its part of the mesh: a bar, or a rigid body, which is one node. A bar alone is one piece.
///
/// Matrices of a chain are sums of those of its pieces: at a bonded joint rows and columns are added, so that each bar
/// has the rows that it has alone, its end rows among them (docs/bars-in-line.md).
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

/// rho M of pieces over all nodes, rigid bodies included; the ends marked have no mass where it is redistributed.
BandedMatrix inertia_of(const std::vector<Piece>& pieces, Mass mass, const std::array<bool, 2>& massless);

/// The material of each element of a chain, nothing's at joints; empty for a bar alone, whose elements are all alike.
std::vector<Bar> element_bars(const Scene& scene, const Mesh& mesh);

/// The rows and columns [first, first + count) of a matrix.
BandedMatrix restrict_to(const BandedMatrix& matrix, std::size_t first, std::size_t count);

/// The sum of of_piece(piece), a matrix of its nodes; a rigid body has none.
template <class OfPiece>
BandedMatrix assembled(const std::vector<Piece>& pieces, OfPiece&& of_piece) {
  if (pieces.size() == 1) return of_piece(pieces.front());
  BandedMatrix all;
  const std::size_t n = pieces.back().last() + 1;
  all.diagonal.assign(n, 0.0);
  for (const Piece& piece : pieces) {
    if (piece.rigid()) continue;
    const BandedMatrix own = of_piece(piece);
    const auto put = [&](const std::vector<double>& from, std::vector<double>& to) {
      if (from.empty()) return;
      to.resize(n - 1);
      std::ranges::copy(from, to.begin() + static_cast<std::ptrdiff_t>(piece.first));
    };
    for (std::size_t i = 0; i < own.size(); ++i) all.diagonal[piece.first + i] += own.diagonal[i];
    put(own.off_diagonal, all.off_diagonal);
    put(own.skew, all.skew);
    for (OneSidedRow row : own.one_sided) {
      row.row += piece.first;
      all.one_sided.push_back(row);
    }
  }
  return all;
}

}  // namespace viscobar

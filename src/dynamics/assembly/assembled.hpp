#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <vector>

#include "dynamics/pieces.hpp"
#include "viscobar/discretisation/mass.hpp"
#include "viscobar/discretisation/tridiagonal.hpp"

// Matrices of a chain are sums of those of its pieces: at a bonded joint rows and columns are added, so that each bar
// has the rows that it has alone, its end rows among them (docs/bars-in-line.md).

namespace viscobar {

/// rho M of pieces over all nodes, rigid bodies included; the ends marked have no mass where it is redistributed.
BandedMatrix inertia_of(const std::vector<Piece>& pieces, Mass mass, const std::array<bool, 2>& massless);

/// The rows and columns [first, first + count) of a matrix.
BandedMatrix restrict_to(const BandedMatrix& matrix, std::size_t first, std::size_t count);

/// The sum of row i of the symmetric part of a matrix.
double row_sum(const BandedMatrix& matrix, std::size_t i);

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

#include "dynamics/assembly/assembled.hpp"

#include <span>

namespace viscobar {

BandedMatrix restrict_to(const BandedMatrix& matrix, std::size_t first, std::size_t count) {
  BandedMatrix part;
  const auto part_of = [](std::span<const double> entries, std::size_t begin, std::size_t length) {
    const auto some = entries.subspan(begin, length);
    return std::vector<double>(some.begin(), some.end());
  };
  part.diagonal = part_of(matrix.diagonal, first, count);
  if (!matrix.off_diagonal.empty() && count > 1) part.off_diagonal = part_of(matrix.off_diagonal, first, count - 1);
  if (!matrix.skew.empty() && count > 1) part.skew = part_of(matrix.skew, first, count - 1);
  const bool with_first = first == 0, with_last = first + count == matrix.size();
  if (matrix.one_sided.empty() || (!(with_first || with_last) && matrix.one_sided_at_ends())) return part;
  for (OneSidedRow row : matrix.one_sided) {
    if (row.row < first || row.row >= first + count) continue;
    row.row -= first;
    part.one_sided.push_back(row);
  }
  // A row of either end is expected; behind a body that is held the bar's own is it.
  std::vector<OneSidedRow>& rows = part.one_sided;
  if (!with_first && (rows.empty() || rows.front().row > 0)) rows.insert(rows.begin(), OneSidedRow{});
  if (!with_last && rows.back().row + 1 < count) rows.push_back({count - 1, true, {}});
  return part;
}

double row_sum(const BandedMatrix& matrix, std::size_t i) {
  double sum = matrix.diagonal[i];
  if (i > 0 && !matrix.is_diagonal()) sum += matrix.off_diagonal[i - 1];
  if (i < matrix.off_diagonal.size()) sum += matrix.off_diagonal[i];
  return sum;
}

BandedMatrix inertia_of(const std::vector<Piece>& pieces, Mass mass, const std::array<bool, 2>& massless) {
  BandedMatrix whole = assembled(pieces, [&](const Piece& piece) {
    BandedMatrix inertia = inertia_matrix(piece.mesh, mass, massless[0], massless[1], piece.section.get());
    return inertia *= piece.bar.density;
  });
  for (const Piece& piece : pieces)
    if (piece.rigid()) whole.diagonal[piece.first] += piece.mass;
  return whole;
}

}  // namespace viscobar

#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <span>

#include "viscobar/discretisation/tridiagonal.hpp"

namespace viscobar {

/// The nodes of a mesh that are unknowns: all J + 1 but those of fixed ends. A field over the unknowns has n entries.
class Unknowns {
 public:
  /// @param nodes of the mesh, J + 1
  /// @param walls displacement of each end that is fixed
  /// @throws std::invalid_argument where no node is left
  Unknowns(std::size_t nodes, const std::array<std::optional<double>, 2>& walls);

  std::size_t size() const { return size_; }                       ///< n
  std::size_t first_node() const { return left_fixed() ? 1 : 0; }  ///< mesh node of unknown 0
  bool left_fixed() const { return walls_[0].has_value(); }        ///< node 0 is no unknown
  bool right_fixed() const { return walls_[1].has_value(); }       ///< node J is no unknown
  /// Displacement of a fixed end, in the frame; absent: it is not fixed.
  const std::optional<double>& wall(bool right) const { return walls_[right]; }
  /// The unknown of an end that is not fixed: the first or the last.
  std::size_t end(bool right) const { return right ? size_ - 1 : 0; }
  /// Which end that is.
  bool is_right(std::size_t end) const { return end > 0 || left_fixed(); }

  /// The entry x of node j, or of a fixed end `left` or `right`: x_j of a field over the unknowns.
  auto at_nodes(std::span<const double> x, double left = 0.0, double right = 0.0) const {
    return [x, left, right, first = first_node()](std::size_t j) {
      return j < first ? left : j - first < x.size() ? x[j - first] : right;
    };
  }
  /// The same of row_values().
  auto at_nodes(RowValues x) const {
    return [x, first = first_node()](std::size_t j) { return j < first || j - first >= x.n ? 0.0 : x(j - first); };
  }
  /// The same of displacements, fixed ends at theirs.
  auto displacement_at_nodes(std::span<const double> u) const {
    return at_nodes(u, walls_[0].value_or(0.0), walls_[1].value_or(0.0));
  }

  /// The unknowns of a field over all mesh nodes.
  template <class Number>
  std::span<Number> part(std::span<Number> nodal) const {
    return nodal.subspan(first_node(), size_);
  }
  /// Copies the unknowns into a field over all mesh nodes (J+1 entries); fixed nodes keep their displacement and stand
  /// still.
  void expand_displacement(std::span<const double> u, std::span<double> nodal) const;
  void expand_velocity(std::span<const double> w, std::span<double> nodal) const;  ///< the same of a velocity

 private:
  std::array<std::optional<double>, 2> walls_;
  std::size_t size_;
};

}  // namespace viscobar

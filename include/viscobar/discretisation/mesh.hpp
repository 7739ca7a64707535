#pragma once

#include <cstddef>

namespace viscobar {

/// Elements that shrink towards the ends marked: the size at the far end (the middle, where both are marked) is `ratio`
/// times that at a marked end, and in between it grows by the same amount from one element to the next.
struct Grading {
  double ratio = 1.0;  ///< >= 1
  bool left = false;   ///< shrink towards x = 0
  bool right = false;  ///< shrink towards x = L

  bool operator==(const Grading&) const = default;  ///< by value
};

/// P1 mesh with nodes x_j = L g(j / J), j = 0 .. J = elements,
///
///     g(s) = s,    or    g(s) = s (2 + (r - 1) s) / (1 + r)    graded towards the left end with ratio r;
///
/// 1 - g(1 - s) towards the right one, g(2 s) / 2 and its mirror image towards both. The nodes of a mesh are nodes of
/// the one with twice its elements.
struct Mesh {
  double length = 1.0;       ///< L
  std::size_t elements = 1;  ///< J
  Grading grading{};         ///< none: all elements alike

  /// True if all elements have the same size.
  bool uniform() const { return grading.ratio == 1.0 || !(grading.left || grading.right); }
  /// h = L / J, the mean; the size of all elements of a uniform mesh.
  double spacing() const { return length / static_cast<double>(elements); }
  std::size_t nodes() const { return elements + 1; }  ///< J + 1

  /// x_j; the last node is exactly at `length`.
  double node(std::size_t j) const {
    if (!uniform()) return graded_node(j);
    return j == elements ? length : length * (static_cast<double>(j) / static_cast<double>(elements));
  }

  /// x_{j+1} - x_j, without its cancellation.
  double element(std::size_t j) const { return uniform() ? spacing() : graded_element(j); }
  /// The smallest element, at a marked end.
  double smallest() const { return uniform() || grading.left ? element(0) : element(elements - 1); }

 private:
  double graded_node(std::size_t j) const;
  double graded_element(std::size_t j) const;
};

/// True if nodes lie in the same places, in parts of the length.
inline bool same_nodes(const Mesh& a, const Mesh& b) {
  return a.elements == b.elements && (a.grading == b.grading || (a.uniform() && b.uniform()));
}

}  // namespace viscobar

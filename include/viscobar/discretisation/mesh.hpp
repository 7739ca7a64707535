#pragma once

#include <cstddef>
#include <memory>
#include <vector>

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
/// 1 - g(1 - s) towards the right one, g(2 s) / 2 and its mirror image towards both; of given nodes, K + 1 of them, g
/// is piecewise linear with the k-th at s = k / K, so that J = K has those nodes. The nodes of a mesh are nodes of the
/// one with twice its elements.
struct Mesh {
  double length = 1.0;       ///< L
  std::size_t elements = 1;  ///< J
  Grading grading{};         ///< none: all elements alike
  /// Given nodes in parts of L, from 0 to 1 and rising; null: none, and then there may be a grading.
  std::shared_ptr<const std::vector<double>> given{};
  /// The mesh of each member of a chain of bars, none of a rigid one. Between two there is an element of no length
  /// where each has a node of its own. Null: one bar.
  std::shared_ptr<const std::vector<Mesh>> members{};

  /// True if all elements have the same size.
  bool uniform() const { return !given && (grading.ratio == 1.0 || !(grading.left || grading.right)); }
  /// Elements that have a length: J, without those of joints.
  std::size_t elements_of_bars() const {
    if (!members) return elements;
    std::size_t sum = 0;
    for (const Mesh& own : *members) sum += own.elements;
    return sum;
  }
  /// h, the mean size of elements that have a length; the size of all elements of a uniform mesh.
  double spacing() const { return length / static_cast<double>(elements_of_bars()); }
  std::size_t nodes() const { return elements + 1; }  ///< J + 1

  /// x_j; the last node is exactly at `length`.
  double node(std::size_t j) const {
    if (!uniform()) return given ? given_node(j) : graded_node(j);
    return j == elements ? length : length * (static_cast<double>(j) / static_cast<double>(elements));
  }

  /// x_{j+1} - x_j, without its cancellation where nodes are not given.
  double element(std::size_t j) const {
    if (uniform()) return spacing();
    return given ? given_node(j + 1) - given_node(j) : graded_element(j);
  }
  /// The smallest element that has a length; at a marked end, if elements shrink towards one.
  double smallest() const;

 private:
  double given_node(std::size_t j) const;
  double graded_node(std::size_t j) const;
  double graded_element(std::size_t j) const;
};

/// True if nodes lie in the same places, in parts of the length.
inline bool same_nodes(const Mesh& a, const Mesh& b) {
  if (a.elements != b.elements || !a.given != !b.given) return false;
  return a.given ? *a.given == *b.given : a.grading == b.grading || (a.uniform() && b.uniform());
}

}  // namespace viscobar

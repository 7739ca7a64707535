#pragma once

#include <cstddef>

namespace viscobar {

/// Uniform P1 mesh: nodes x_j = j h, j = 0 .. elements, h = length / elements.
struct Mesh {
  double length = 1.0;
  std::size_t elements = 1;

  double spacing() const { return length / static_cast<double>(elements); }
  std::size_t nodes() const { return elements + 1; }

  /// x_j; the last node is exactly at `length`.
  double node(std::size_t j) const {
    return j == elements ? length : length * (static_cast<double>(j) / static_cast<double>(elements));
  }
};

}  // namespace viscobar

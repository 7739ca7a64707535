#include "viscobar/discretisation/mesh.hpp"

#include <algorithm>
#include <cmath>

namespace viscobar {

double Mesh::smallest() const {
  if (!given) return uniform() || grading.left ? element(0) : element(elements - 1);
  double least = length;
  for (std::size_t j = 0; j < elements; ++j)
    if (const double size = element(j); size > 0.0) least = std::min(least, size);
  return least;
}

double Mesh::given_node(std::size_t j) const {
  const std::size_t parts = given->size() - 1, k = j * parts / elements;
  if (k == parts) return length;
  const double share = static_cast<double>(j * parts % elements) / static_cast<double>(elements);
  return length * std::lerp((*given)[k], (*given)[k + 1], share);
}

double Mesh::graded_node(std::size_t j) const {
  if (j == 0) return 0.0;
  if (j == elements) return length;
  const bool both = grading.left && grading.right;
  const bool mirrored = both ? 2 * j > elements : grading.right;
  const double whole = static_cast<double>(elements), s = static_cast<double>(mirrored ? elements - j : j) / whole;
  const double rise = both ? 2.0 * s : s;
  const double x = length * s * (2.0 + (grading.ratio - 1.0) * rise) / (1.0 + grading.ratio);
  return mirrored ? length - x : x;
}

double Mesh::graded_element(std::size_t j) const {
  const bool both = grading.left && grading.right;
  if (both && 2 * j + 1 == elements) return length - 2.0 * graded_node(j);  // across the middle
  const bool mirrored = both ? 2 * j + 1 > elements : grading.right;
  const std::size_t from_end = mirrored ? elements - 1 - j : j;
  const double rise = (both ? 2.0 : 1.0) * static_cast<double>(2 * from_end + 1) / static_cast<double>(elements);
  return spacing() * (2.0 + (grading.ratio - 1.0) * rise) / (1.0 + grading.ratio);
}

}  // namespace viscobar

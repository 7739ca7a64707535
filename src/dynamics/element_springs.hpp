#pragma once

#include <cstddef>
#include <utility>
#include <vector>

#include "viscobar/dynamics/unknowns.hpp"

namespace viscobar {

/// Springs k between the neighbouring nodes of a bar, over its unknowns by differences, which keep the digits of what
/// is all but constant:
///
///     (K x)_i = k_{i-1} (x_i - x_{i-1}) + k_i (x_i - x_{i+1}),       k_j that of the element between nodes j and j
///     + 1.
///
/// Fields x(j) are of all nodes j, fixed ends included: numbers, or what is added and multiplied as such.
class ElementSprings {
 public:
  ElementSprings() = default;
  /// @param springs of each element, or empty: there are none
  ElementSprings(const Unknowns& unknowns, std::vector<double> springs)
      : first_(unknowns.first_node()), size_(unknowns.size()), springs_(std::move(springs)) {}

  bool empty() const { return springs_.empty(); }
  double operator[](std::size_t element) const { return empty() ? 0.0 : springs_[element]; }

  /// out = K x, where there are springs
  void multiply(auto&& x, auto&& out) const {
    each(x, [&](std::size_t i, const auto& force) { out[i] = force; });
  }
  /// out -= K x
  void subtract(auto&& x, auto&& out) const {
    if (!empty()) each(x, [&](std::size_t i, const auto& force) { out[i] = out[i] - force; });
  }

 private:
  void each(auto&& x, auto&& use) const {
    auto here = x(first_);
    auto before = 0.0 * here;
    if (first_ > 0) before = springs_[first_ - 1] * (here - x(first_ - 1));
    for (std::size_t i = 0, j = first_; i < size_; ++i, ++j) {
      auto after = 0.0 * here;
      if (j < springs_.size()) {
        const auto next = x(j + 1);
        after = springs_[j] * (next - here);
        here = next;
      }
      use(i, before - after);
      before = after;
    }
  }

  std::size_t first_ = 0, size_ = 0;  // node of unknown 0, unknowns
  std::vector<double> springs_;
};

}  // namespace viscobar

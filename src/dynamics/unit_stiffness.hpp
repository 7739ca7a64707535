#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "viscobar/dynamics/bar_system.hpp"

namespace viscobar {

/// K over the unknowns of a bar, by differences, which keep the digits of what is all but constant:
///
///     (K x)_i = (x_i - x_{i-1}) / h_i + (x_i - x_{i+1}) / h_{i+1},       x = 0 at a fixed end.
class UnitStiffness {
 public:
  explicit UnitStiffness(const BarSystem& bar) {
    const auto of_element = [&](std::size_t e) { return 1.0 / bar.elements().stretch(e); };
    const std::size_t first = bar.unknowns().first_node();
    for (std::size_t i = 0; i + 1 < bar.size(); ++i) coupling_.push_back(of_element(first + i));
    if (bar.unknowns().left_fixed()) ground_[0] = of_element(std::size_t{0});
    if (bar.unknowns().right_fixed()) ground_[1] = of_element(bar.mesh().elements - 1);
  }

  /// out = K x of the values x(i), which are numbers, or what is added and multiplied as such.
  template <class Values, class Out>
  void multiply(Values&& x, Out&& out) const {
    const std::size_t n = coupling_.size() + 1;
    auto here = x(0);
    auto before = ground_[0] * here;
    for (std::size_t i = 0; i + 1 < n; ++i) {
      const auto next = x(i + 1);
      const decltype(before) pull = coupling_[i] * (next - here);
      out[i] = before - pull;
      before = pull;
      here = next;
    }
    out[n - 1] = before + ground_[1] * here;
  }

 private:
  std::vector<double> coupling_;    // 1 / h between an unknown and the next
  std::array<double, 2> ground_{};  // of an element with a fixed end
};

}  // namespace viscobar

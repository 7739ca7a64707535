#include "discretisation/lanes.hpp"

#include <algorithm>
#include <type_traits>

namespace viscobar {

Lanes load_first(const double* x, std::size_t count) noexcept {
  std::array<double, lane_count> values{};
  double* to = values.data();
  // Copies of known sizes are moves of registers.
  const auto copy = [&](auto some) {
    if (count & some) to = std::copy_n(x, some(), to), x += some;
  };
  copy(std::integral_constant<std::size_t, 8>());
  copy(std::integral_constant<std::size_t, 4>());
  copy(std::integral_constant<std::size_t, 2>());
  copy(std::integral_constant<std::size_t, 1>());
  return load_lanes(values.data());
}

}  // namespace viscobar

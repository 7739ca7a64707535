#include "discretisation/gauss.hpp"

#include <array>
#include <boost/math/special_functions/legendre.hpp>
#include <vector>

namespace viscobar {

std::span<const GaussPoint> gauss(std::size_t n) {
  static const std::array<std::vector<GaussPoint>, most_gauss_points + 1> all = [] {
    std::array<std::vector<GaussPoint>, most_gauss_points + 1> list;
    for (int size = 1; size <= static_cast<int>(most_gauss_points); ++size)
      for (const double zero : boost::math::legendre_p_zeros<double>(size)) {
        const double slope = boost::math::legendre_p_prime(size, zero);
        const double weight = 2.0 / ((1.0 - zero * zero) * slope * slope);
        auto& points = list[static_cast<std::size_t>(size)];
        if (zero > 0.0) points.push_back({-zero, weight});
        points.push_back({zero, weight});
      }
    return list;
  }();
  return all[n];
}

}  // namespace viscobar

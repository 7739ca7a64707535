#include "discretisation/gauss.hpp"

#include <array>
#include <boost/math/special_functions/legendre.hpp>
#include <mutex>
#include <vector>

namespace viscobar {

namespace {

std::vector<GaussPoint> made(int n) {
  std::vector<GaussPoint> points;
  for (const double zero : boost::math::legendre_p_zeros<double>(n)) {
    const double slope = boost::math::legendre_p_prime(n, zero);
    const double weight = 2.0 / ((1.0 - zero * zero) * slope * slope);
    if (zero > 0.0) points.push_back({-zero, weight});
    points.push_back({zero, weight});
  }
  return points;
}

}  // namespace

std::span<const GaussPoint> gauss(std::size_t n) {
  // Each by itself when it is wanted first: a process uses three or four of them.
  static std::array<std::once_flag, most_gauss_points + 1> once;
  static std::array<std::vector<GaussPoint>, most_gauss_points + 1> all;
  if (n > 0) std::call_once(once[n], [n] { all[n] = made(static_cast<int>(n)); });
  return all[n];
}

}  // namespace viscobar

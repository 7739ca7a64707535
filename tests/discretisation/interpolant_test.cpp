#include "discretisation/interpolant.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

#include "viscobar/discretisation/mesh.hpp"

namespace viscobar {
namespace {

// Powers of x up to the fifth, or to one less than there are nodes: value and slope everywhere, to the rounding of six
// terms with weights up to ten.
TEST(Interpolant, IsExactForPolynomialsOfItsDegree) {
  const double rounding = 60.0 * std::numeric_limits<double>::epsilon();
  for (const Mesh& mesh : {Mesh{2.0, 1}, Mesh{2.0, 3}, Mesh{2.0, 5}, Mesh{2.0, 40}, Mesh{2.0, 24, {8.0, true, true}}}) {
    std::vector<double> nodes;
    for (std::size_t j = 0; j < mesh.nodes(); ++j) nodes.push_back(mesh.node(j));
    const int degree = std::min<int>(5, static_cast<int>(mesh.elements));
    for (int n = 0; n <= degree; ++n) {
      std::vector<double> u;
      for (const double x : nodes) u.push_back(std::pow(x, n));
      for (const double x : {0.0, 1e-3, 0.31, 1.0, 1.7, 2.0}) {
        const Interpolant at = interpolant(nodes, x);
        const double size = std::pow(2.0, n), slope = n == 0 ? 0.0 : n * std::pow(x, n - 1);
        EXPECT_NEAR(at.value(u), std::pow(x, n), rounding * size) << n << " " << x;
        EXPECT_NEAR(at.slope(u), slope, rounding * size / mesh.smallest()) << n << " " << x;
      }
    }
  }
}

}  // namespace
}  // namespace viscobar

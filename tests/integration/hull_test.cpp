// Bounds of a step from the terms of its interpolant at the end.
#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <vector>

#include "integration/sundials/vector.hpp"

namespace viscobar::sundials::testing_hull {
namespace {

TEST(Hull, BoundsThePolynomialAndIsAttainedWhereItIsTheValueAtTheEnd) {
  const Context context;
  std::mt19937 random(7);
  std::normal_distribution<double> normal;
  const Probed probed({0});
  const Vector hull = make_hull(probed, context);
  std::size_t monotone = 0;
  for (int trial = 0; trial < 2000; ++trial) {
    const std::size_t order = 1 + random() % 12;
    const bool last_first = trial % 2 == 0;  // as CVODE hands the terms over; IDA begins with the value
    std::vector<Vector> terms;
    std::vector<N_Vector> handed;
    std::vector<double> coefficients(order + 1, 0.0), x;
    double scale = 1.0;
    for (std::size_t k = 0; k <= order; ++k, scale *= 0.3) {
      x.push_back(scale * normal(random));
      terms.push_back(make_vector(1, context));
      values(terms.back())[0] = x.back();
      handed.push_back(terms.back().get());
    }
    if (last_first) std::ranges::reverse(handed);
    coefficients[last_first ? order : 0] = 1.0;
    ASSERT_EQ(N_VLinearCombination(static_cast<int>(order + 1), coefficients.data(), handed.data(), hull.get()), 0);
    const double lowest = values(hull)[0], highest = values(hull)[1], last = values(hull)[2];
    EXPECT_EQ(last, x[0]);
    for (int i = 0; i <= 50; ++i) {
      double p = 0.0;
      for (std::size_t k = order + 1; k-- > 0;) p = p * (-0.02 * i) + x[k];
      EXPECT_GE(p, lowest - 1e-14) << trial;
      EXPECT_LE(p, highest + 1e-14) << trial;
    }
    monotone += lowest == last || highest == last ? 1 : 0;
  }
  EXPECT_GT(monotone, 200u);
}

}  // namespace
}  // namespace viscobar::sundials::testing_hull

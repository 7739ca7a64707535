#include "characteristics/chebyshev.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

namespace viscobar::characteristics {
namespace {

template <class Function>
Chebyshev fitted(std::size_t terms, Function&& f) {
  std::vector<double> values;
  for (const double z : Chebyshev::points(terms)) values.push_back(f(z));
  return Chebyshev::through(values);
}

TEST(ChebyshevPolynomial, GoesThroughItsValuesAndIsIntegratedAndDifferentiatedExactly) {
  const Chebyshev p = fitted(7, [](double z) { return 1.0 + z * (2.0 - z * z * (3.0 - z * z * z)); });
  const Chebyshev sum = p.antiderivative();
  for (const double z : {-1.0, -0.4, 0.0, 0.3, 1.0}) {
    const double exact = z + z * z - 0.75 * z * z * z * z + z * z * z * z * z * z * z / 7.0;
    EXPECT_NEAR(sum(z), exact - (-1.0 + 1.0 - 0.75 - 1.0 / 7.0), 1e-15);
    EXPECT_NEAR(sum.derivative()(z), p(z), 4e-15);
  }
  EXPECT_NEAR(p.integral(), 2.0 + 2.0 / 7.0, 1e-15);
  EXPECT_EQ(sum(-1.0), 0.0);
}

TEST(ChebyshevPolynomial, IsTheSameOnAPartAndMirrored) {
  const Chebyshev p = fitted(33, [](double z) { return std::sin(9.0 * z) + z; });
  const Chebyshev part = p.restricted(-0.2, 0.5), mirror = p.mirrored();
  for (double z = -1.0; z <= 1.0; z += 0.125) {
    EXPECT_NEAR(part(z), p(0.15 + 0.35 * z), 1e-14);
    EXPECT_NEAR(mirror(z), p(-z), 1e-15);
  }
}

TEST(ChebyshevPolynomial, ItsFirstDescentIsFoundThoughItComesBackAtOnce) {
  // Below zero on a stretch of 2e-6 only.
  const Chebyshev p = fitted(5, [](double z) { return (z - 0.3) * (z - 0.3) - 1e-12; });
  const auto z = first_descent(p, 1e-13);
  ASSERT_TRUE(z);
  EXPECT_NEAR(*z, 0.3 - 1e-6, 1e-9);
  EXPECT_FALSE(first_descent(p, 1e-11)) << "a graze within the band";
}

TEST(ChebyshevPolynomial, ItsFirstDescentIsTheFirst) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> place(-1.0, 1.0);
  for (int run = 0; run < 300; ++run) {
    const double a = place(random), b = place(random), c = place(random);
    const Chebyshev p = fitted(4, [&](double z) { return -(z - a) * (z - b) * (z - c); });
    double first = 2.0;
    for (const double root : {a, b, c})
      if (root < first && p(root + 1e-7) < 0.0) first = root;
    if (p(-1.0) < 0.0) first = -1.0;
    const auto z = first_descent(p, 1e-15);
    ASSERT_TRUE(z) << run;
    EXPECT_NEAR(*z, first, 1e-6 * (1.0 + 1e-6 / (1e-6 + std::abs(a - b) + std::abs(b - c)))) << run;
  }
}

TEST(ChebyshevPolynomial, ItsMaximumIsKnownToRounding) {
  const Chebyshev p = fitted(33, [](double z) { return std::cos(8.0 * (z - 0.123)); });
  EXPECT_NEAR(maximum(p, 0.0, 1e-14), 1.0, 3e-14);
  EXPECT_EQ(maximum(p, 2.0, 1e-14), 2.0);
}

}  // namespace
}  // namespace viscobar::characteristics

#include "integration/bernstein.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <random>
#include <vector>

namespace viscobar {
namespace {

Bernstein polynomial(std::size_t degree, const std::function<double(double)>& p) {
  std::vector<double> samples;
  for (std::size_t j = 0; j <= degree; ++j) samples.push_back(p(static_cast<double>(j) / static_cast<double>(degree)));
  return Bernstein::through(samples);
}

TEST(Bernstein, ReproducesPolynomialsOfItsDegree) {
  for (std::size_t degree = 1; degree <= Bernstein::max_degree; ++degree) {
    const auto p = [degree](double s) { return std::pow(2 * s - 1, static_cast<double>(degree)) - 0.3 * s; };
    const Bernstein b = polynomial(degree, p);
    // The inverse of the sampling matrix grows like 4^degree / degree at most.
    const double tolerance = 2.3e-16 * std::pow(4.0, static_cast<double>(degree));
    for (const double s : {0.0, 0.123, 0.5, 0.777, 1.0}) EXPECT_NEAR(b(s), p(s), tolerance) << degree;
  }
}

TEST(Bernstein, FindsTwoCrossingsBetweenSamples) {
  // Below zero only within (0.449, 0.451): every equidistant sample of a quintic is positive.
  const auto p = [](double s) { return (s - 0.449) * (s - 0.451); };
  const auto root = polynomial(5, p).first_descent(0.0);
  ASSERT_TRUE(root.has_value());
  EXPECT_NEAR(*root, 0.449, 1e-15 / 0.002 * 4);  // rounding over slope
}

TEST(Bernstein, SeesNoCrossingInATouch) {
  const auto p = [](double s) { return (s - 0.3) * (s - 0.3) + 1e-9; };
  EXPECT_FALSE(polynomial(4, p).first_descent(0.0).has_value());
}

TEST(Bernstein, FindsTheFirstOfManyDescents) {
  std::mt19937 generator(7);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  for (int trial = 0; trial < 2000; ++trial) {
    std::vector<double> samples(6);
    for (double& sample : samples) sample = uniform(generator);
    samples[0] = std::abs(samples[0]);
    const Bernstein p = Bernstein::through(samples);
    // Reference: a fine scan, whose resolution bounds what can be asserted.
    const int count = 20000;
    double scanned = 2.0;
    for (int i = 1; i <= count && scanned > 1.0; ++i)
      if (p(static_cast<double>(i) / count) < 0.0) scanned = static_cast<double>(i) / count;
    const auto root = p.first_descent(0.0);
    if (scanned <= 1.0) {
      ASSERT_TRUE(root.has_value());
      EXPECT_LE(*root, scanned + 1e-12);
      EXPECT_NEAR(p(*root), 0.0, 1e-13);
    } else if (root) {
      EXPECT_GT(p(*root), -1e-6);  // a dip narrower than the scan's spacing
    }
  }
}

TEST(Bernstein, StartsBelowAtZero) {
  EXPECT_EQ(polynomial(3, [](double s) { return s - 0.1; }).first_descent(0.0), 0.0);
}

}  // namespace
}  // namespace viscobar

#include "integration/bernstein.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <random>
#include <utility>
#include <vector>

#include "run/step_failure.hpp"

namespace viscobar::testing_bernstein {
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

// A derivative at equidistant points magnifies roundings of the samples as the entries of its matrix do, by less than
// q 2^q.
TEST(Bernstein, HasTheSlopesOfPolynomialsOfItsDegreeAtItsSamples) {
  for (std::size_t degree = 1; degree <= Bernstein::max_degree; ++degree) {
    const double q = static_cast<double>(degree);
    std::vector<double> samples;
    for (std::size_t j = 0; j <= degree; ++j) samples.push_back(std::pow(2.0 * static_cast<double>(j) / q - 1.0, q));
    const auto slopes = Bernstein::slopes(samples);
    for (std::size_t j = 0; j <= degree; ++j)
      EXPECT_NEAR(slopes[j], 2.0 * q * std::pow(2.0 * static_cast<double>(j) / q - 1.0, q - 1.0),
                  2.3e-16 * q * std::pow(2.0, q))
          << degree << " " << j;
  }
}

TEST(Bernstein, IsTheSamePolynomialOnAPartOfItsInterval) {
  for (std::size_t degree = 1; degree <= Bernstein::max_degree; ++degree) {
    const Bernstein p = polynomial(degree, [](double s) { return std::cos(4.0 * s); });
    for (const auto& [from, to] : {std::pair{0.0, 0.3}, {0.25, 0.5}, {0.6, 1.0}, {1.0, 1.0}}) {
      const Bernstein part = p.between(from, to);
      for (const double s : {0.0, 0.4, 1.0}) EXPECT_NEAR(part(s), p(from + s * (to - from)), 1e-14) << degree;
      EXPECT_NEAR(part.end(), p(to), 1e-14) << degree;
      EXPECT_EQ(part.negative()(0.4), -part(0.4));
    }
  }
}

TEST(Bernstein, FindsItsExtremesBetweenSamplesAndItsMean) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> coefficient(-1.0, 1.0);
  for (std::size_t degree = 1; degree <= Bernstein::max_degree; ++degree) {
    std::vector<double> c(degree + 1), samples;
    for (double& value : c) value = coefficient(random);
    const auto p = [&](double s) {
      double sum = 0.0;
      for (std::size_t k = c.size(); k-- > 0;) sum = sum * s + c[k];
      return sum;
    };
    double mean = 0.0, most = p(0.0), least = most;
    for (std::size_t k = 0; k < c.size(); ++k) mean += c[k] / static_cast<double>(k + 1);
    for (int k = 0; k <= 100'000; ++k) most = std::max(most, p(1e-5 * k)), least = std::min(least, p(1e-5 * k));
    for (std::size_t j = 0; j <= degree; ++j)
      samples.push_back(p(static_cast<double>(j) / static_cast<double>(degree)));
    const Bernstein b = Bernstein::through(samples);
    // Rounding as above, of values up to 13; between two of the points a maximum is p'' / 8 (1e-5)^2 higher.
    const double tolerance = 13 * 2.3e-16 * std::pow(4.0, static_cast<double>(degree)) + 13 * 144 * 1e-10;
    EXPECT_NEAR(b.largest(-100.0), most, tolerance) << degree;
    EXPECT_NEAR(b.smallest(100.0), least, tolerance) << degree;
    EXPECT_EQ(b.largest(100.0), 100.0);
    EXPECT_NEAR(Bernstein::mean(samples), mean, tolerance) << degree;
    EXPECT_NEAR(Bernstein::through(samples).mean(), mean, tolerance) << degree;
    const auto [low, high] = std::ranges::minmax(samples);
    EXPECT_LE(most, high + Bernstein::excess(degree) * (high - low) + tolerance);
    EXPECT_GE(least, low - Bernstein::excess(degree) * (high - low) - tolerance);
  }
}

// The function that takes the values 1 and -1 in turn at the samples, with signs that add up at a point, attains it.
TEST(Bernstein, ExcessIsThatOfTheWorstSamples) {
  for (std::size_t degree = 1; degree <= Bernstein::max_degree; ++degree) {
    double lebesgue = 0.0;
    for (int k = 0; k <= 20'000; ++k) {
      const double s = static_cast<double>(degree) * k / 20'000.0;
      double sum = 0.0;
      for (std::size_t i = 0; i <= degree; ++i) {
        double product = 1.0;
        for (std::size_t j = 0; j <= degree; ++j)
          if (j != i) product *= (s - static_cast<double>(j)) / (static_cast<double>(i) - static_cast<double>(j));
        sum += std::abs(product);
      }
      lebesgue = std::max(lebesgue, sum);
    }
    EXPECT_GE(Bernstein::excess(degree), 0.5 * (lebesgue - 1.0) - 1e-12) << degree;
    EXPECT_LE(Bernstein::excess(degree), 0.5 * (lebesgue - 1.0) + 0.01) << degree;
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

// Where all coefficients fall Newton's method finds what halving would: the last place, to 2^-52, that is not below.
TEST(Bernstein, AFallingPolynomialDescendsAtItsRoot) {
  for (std::size_t degree = 1; degree <= 12; ++degree)
    for (const double root : {1e-9, 0.1, 0.5, 0.93, 1.0 - 1e-9}) {
      // -(s - r) (1 + s^(degree - 1)), and flat at its root: -(s - r)^3.
      std::vector<double> samples, flat;
      for (std::size_t j = 0; j <= degree; ++j) {
        const double s = static_cast<double>(j) / static_cast<double>(degree);
        samples.push_back((root - s) * (1.0 + (degree > 1 ? std::pow(s, degree - 1) : 0.0)));
        flat.push_back(std::pow(root - s, 3));
      }
      const auto found = Bernstein::through(samples).first_descent(0.0);
      ASSERT_TRUE(found);
      // The coefficients have some 1e3 roundings at degree 12; the slope is 1 at least.
      EXPECT_NEAR(*found, root, 1e-12) << degree;
      EXPECT_FALSE(Bernstein::through(samples).first_descent(0.0, 0x1p-52, 0.5 * root));
      if (degree < 3) continue;
      const auto flat_root = Bernstein::through(flat).first_descent(0.0);
      ASSERT_TRUE(flat_root);
      EXPECT_NEAR(*flat_root, root, std::cbrt(1e-12)) << degree;
    }
}

TEST(Bernstein, OfWhatIsNoNumberIsNotHalvedForEver) {
  for (const double wrong : {NAN, INFINITY, -INFINITY}) {
    const Bernstein p = Bernstein::through(std::vector{0.0, wrong, 1.0, -1.0});
    EXPECT_THROW(p.largest(-1.0), StepFailure);
    EXPECT_THROW(p.smallest(1.0), StepFailure);
    EXPECT_THROW((void)p.first_descent(0.0), StepFailure);
  }
}

}  // namespace
}  // namespace viscobar::testing_bernstein

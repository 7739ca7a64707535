#include <gtest/gtest.h>

#include <cmath>

#include "integration/exponential/contact_distance.hpp"

namespace viscobar::exponential::testing_passage {
namespace {

Eigen::VectorXd polynomial(std::initializer_list<double> coefficients) {
  Eigen::VectorXd c = Eigen::VectorXd::Zero(23);
  std::copy(coefficients.begin(), coefficients.end(), c.begin());
  return c;
}

TEST(FirstPassage, IsTheFirstOfTwoCrossingsInsideAStep) {
  // (s - 0.3) (s - 0.30001): positive at both ends.
  const auto found = first_passage(polynomial({0.3 * 0.30001, -0.60001, 1.0}), 1e-15);
  ASSERT_TRUE(found.has_value());
  EXPECT_NEAR(*found, 0.3, 1e-16 / 1e-5 * 10);  // rounding of the coefficients over the slope
}

TEST(FirstPassage, IsNoTouchWithinTheBand) {
  EXPECT_FALSE(first_passage(polynomial({0.25, -1.0, 1.0}), 1e-15).has_value());
  EXPECT_FALSE(first_passage(polynomial({0.25 - 1e-9, -1.0, 1.0}), 2e-9).has_value());
  EXPECT_TRUE(first_passage(polynomial({0.25 - 1e-9, -1.0, 1.0}), 1e-10).has_value());
}

TEST(FirstPassage, FromZeroIsAtOnceWhenTheDistanceFallsAndNeverWhenItGrows) {
  EXPECT_EQ(first_passage(polynomial({0.0, -1.0}), 1e-15), 0.0);
  EXPECT_FALSE(first_passage(polynomial({0.0, 1.0, -0.5}), 1e-15).has_value());
}

TEST(FirstPassage, IsTheZeroAndNotTheEdgeOfTheBand) {
  const auto found = first_passage(polynomial({0.5, -1.0}), 1e-6);
  ASSERT_TRUE(found.has_value());
  EXPECT_DOUBLE_EQ(*found, 0.5);
}

TEST(LargestValue, IsFoundInsideTheStep) {
  EXPECT_NEAR(largest_value(polynomial({0.0, 1.0, -1.0}), 1.0), 0.25, 1e-16);
  EXPECT_NEAR(largest_value(polynomial({0.0, 1.0, -1.0}), 0.4), 0.24, 1e-16);
}

TEST(SampledRange, EnclosesOscillationsAndTransientsHoweverBadlyTheyAreResolved) {
  for (const double rate : {0.0, 1.0, 30.0, 1000.0})
    for (double frequency = 0.1; frequency < 40.0; frequency *= 1.07)
      for (double phase = 0.0; phase < 6.3; phase += 0.1) {
        const auto f = [&](double s) { return std::exp(-rate * s) * std::cos(frequency * s + phase); };
        const auto slope = [&](double s) {
          return -0.5 * std::exp(-rate * s) *
                 (rate * std::cos(frequency * s + phase) + frequency * std::sin(frequency * s + phase));
        };
        const SampledRange range({{f(0), f(0.25), f(0.5), f(0.75), f(1)}, {slope(0), slope(0.5), slope(1)}});
        double lowest = f(0), highest = f(0);
        bool up = true, down = true;
        for (int i = 1; i <= 1000; ++i) {
          const double before = f((i - 1) / 1000.0), now = f(i / 1000.0);
          lowest = std::min(lowest, now);
          highest = std::max(highest, now);
          up &= now >= before - 1e-15;
          down &= now <= before + 1e-15;
        }
        ASSERT_LE(range.lowest(), lowest + 1e-14) << rate << ", " << frequency << ", " << phase;
        ASSERT_GE(range.highest(), highest - 1e-14) << rate << ", " << frequency << ", " << phase;
        if (range.monotone()) {
          ASSERT_TRUE(up || down) << rate << ", " << frequency << ", " << phase;
        }
      }
}

TEST(SampledRange, IsTightForWhatIsResolved) {
  const auto f = [](double s) { return 1.0 + std::sin(0.5 * s); };
  const SampledRange range(
      {{f(0), f(0.25), f(0.5), f(0.75), f(1)}, {0.25, 0.25 * std::cos(0.25), 0.25 * std::cos(0.5)}});
  EXPECT_TRUE(range.monotone());
  EXPECT_NEAR(range.lowest(), f(0), 1e-12);
  EXPECT_NEAR(range.highest(), f(1), 1e-12);
}

}  // namespace
}  // namespace viscobar::exponential::testing_passage

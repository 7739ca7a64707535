// Motion of an end by a function that is known by its values alone.
#include "characteristics/function_of_time.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace viscobar::characteristics {
namespace {

constexpr double end = 7.0, window = 0.9, omega = 5.0;

// n = 32 or less over a window: n^2 and n^4 roundings, of the size of the function, over powers of half a piece.
TEST(FunctionOfTime, IsDifferentiatedToItsRoundings) {
  const FunctionOfTime f = function_through([](double t) { return 0.3 + std::sin(omega * t); }, end, window);
  EXPECT_DOUBLE_EQ(f.start, 0.3);
  EXPECT_FALSE(f.motion.breaks);
  EXPECT_EQ(f.motion.displacement(0.0), 0.0);
  const double piece = window / 4.0, rounding = 1.3 * std::numeric_limits<double>::epsilon();
  for (double t = 0.0; t <= end; t += 0.0137) {
    EXPECT_NEAR(f.motion.displacement(t), std::sin(omega * t), 16.0 * rounding);
    EXPECT_NEAR(f.motion.velocity(t), omega * std::cos(omega * t), std::pow(32.0, 2) * rounding / piece);
    EXPECT_NEAR(f.motion.acceleration(t), -omega * omega * std::sin(omega * t),
                std::pow(32.0, 4) * rounding / (piece * piece));
  }
}

TEST(FunctionOfTime, BreaksWhereItHasAKinkAndNowhereElse) {
  const FunctionOfTime f = function_through([](double t) { return std::min(0.4 * t, 0.2); }, end, window);
  ASSERT_TRUE(f.motion.breaks);
  const auto at = f.motion.breaks(0.0, end);
  ASSERT_TRUE(at);
  EXPECT_NEAR(*at, 0.5, 1e-13);
  EXPECT_FALSE(f.motion.breaks(*at, end));
  EXPECT_NEAR(f.motion.velocity(0.499), 0.4, 1e-10);
  EXPECT_NEAR(f.motion.velocity(0.501), 0.0, 1e-10);
}

}  // namespace
}  // namespace viscobar::characteristics

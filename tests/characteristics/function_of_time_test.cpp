// What a function that is known by its values alone becomes as the motion of an end.
#include "characteristics/function_of_time.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

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

// h^4 for the spline, h^2 for its second derivative; a cubic it gives back.
TEST(FunctionOfTime, OfSamplesIsACubicSpline) {
  const auto through = [](std::size_t n, auto&& f) {
    std::vector<double> t, y;
    for (std::size_t i = 0; i <= n; ++i)
      t.push_back(end * std::pow(static_cast<double>(i) / static_cast<double>(n), 1.1)), y.push_back(f(t.back()));
    return spline_through(t, y);
  };
  const auto cubic = [](double t) { return 1.0 + t * (2.0 - t * (0.5 - 0.1 * t)); };
  const FunctionOfTime same = through(9, cubic);
  EXPECT_NEAR(same.start, 1.0, 1e-14);
  const auto off = [&](std::size_t n, bool curvature) {
    const FunctionOfTime f = through(n, [](double t) { return std::sin(t); });
    double most = 0.0;
    for (double t = 0.0; t < end; t += 0.01)
      most = std::max(most, curvature ? std::abs(f.motion.acceleration(t) + std::sin(t))
                                      : std::abs(f.motion.displacement(t) - std::sin(t)));
    return most;
  };
  for (double t = 0.0; t < end; t += 0.01) EXPECT_NEAR(same.motion.displacement(t), cubic(t) - 1.0, 1e-12);
  EXPECT_NEAR(std::log2(off(40, false) / off(80, false)), 4.0, 0.5);
  EXPECT_NEAR(std::log2(off(40, true) / off(80, true)), 2.0, 0.5);
  EXPECT_FALSE(same.motion.breaks);
}

// Between two samples it keeps between their values, and where they stay it stays, whatever jumps beside them.
TEST(FunctionOfTime, OfSamplesDoesNotSwingBesideAJump) {
  struct Samples {
    std::vector<double> t, y;
  };
  for (const Samples& samples :
       {Samples{{0, .5, 1, 1.001, 2, 2.5, 3}, {0, 0, 0, 1, 1, 1, 1}}, Samples{{0, .001, 1, 2, 3}, {0, 5, 5, 5, 5}},
        Samples{{0, 1, 2, 2.999, 3}, {2, 2, 2, 2, -1}}, Samples{{0, 1, 2, 3, 4, 5, 6}, {0, 0, 1, 1, 0, 0, 0}},
        Samples{{0, 1, 1.01, 2, 2.01, 3}, {0, 1, 11, 12, 2, 3}},
        Samples{{0, 1, 1.0001, 1.0002, 2, 3}, {0, 0, 1e6, 0, 0, 0}}}) {
    const FunctionOfTime f = spline_through(samples.t, samples.y);
    // Of the polynomial pieces, whose coefficients are as large as the samples.
    const double rounding = 1e-14 * (1.0 + *std::ranges::max_element(samples.y));
    for (std::size_t i = 0; i + 1 < samples.t.size(); ++i)
      for (double s = 0.0; s <= 1.0; s += 1.0 / 64.0) {
        const auto [low, high] = std::minmax(samples.y[i], samples.y[i + 1]);
        const double value = f.start + f.motion.displacement(samples.t[i] + s * (samples.t[i + 1] - samples.t[i]));
        EXPECT_GE(value, low - rounding) << samples.y[1] << " " << i << " " << s;
        EXPECT_LE(value, high + rounding) << samples.y[1] << " " << i << " " << s;
      }
  }
}

// Steps of any height at any time, once among samples that are near, between others that are far: none leaves the range
// of its samples.
TEST(FunctionOfTime, OfRandomStepsKeepsToTheirRange) {
  std::mt19937_64 engine(1);
  const auto draw = [&] { return static_cast<double>(engine() >> 11) * 0x1p-53; };
  for (int k = 0; k < 300; ++k) {
    std::vector<double> t{0.0}, y{0.0};
    while (t.size() < 12) {
      t.push_back(t.back() + std::pow(10.0, -4.0 * draw()));
      y.push_back(draw() < 0.6 ? y.back() : y.back() + std::pow(10.0, 3.0 * draw()) * (draw() < 0.5 ? -1.0 : 1.0));
    }
    const FunctionOfTime f = spline_through(t, y);
    const auto [low, high] = std::ranges::minmax(y);
    for (double at = 0.0; at <= t.back(); at += t.back() / 997.0) {
      EXPECT_GE(f.start + f.motion.displacement(at), low - 1e-13 * (high - low)) << k << " " << at;
      EXPECT_LE(f.start + f.motion.displacement(at), high + 1e-13 * (high - low)) << k << " " << at;
    }
  }
}

}  // namespace
}  // namespace viscobar::characteristics

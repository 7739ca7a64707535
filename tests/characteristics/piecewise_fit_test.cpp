#include "characteristics/piecewise_fit.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "run/step_failure.hpp"

namespace viscobar::characteristics {
namespace {

double largest_difference(const Piecewise& f, const std::function<double(double)>& exact) {
  Cursor cursor(f);
  double largest = 0.0;
  for (int k = 1; k < 1000; ++k) {
    const double s = (k + 0.123) / 1001.0;
    largest = std::max(largest, std::abs(cursor.value(s) - exact(s)));
  }
  return largest;
}

TEST(PiecewiseFit, TakesAPolynomialAsOnePieceOfItsDegree) {
  PiecewiseFit fit;
  const Piecewise& f = fit.of([](double s) { return 1.0 + s * (2.0 - s); });
  ASSERT_EQ(f.size(), 1u);
  EXPECT_EQ(f[0].terms, 3u);
  EXPECT_LT(fit.error(), 1e-15);
}

TEST(PiecewiseFit, FindsAKinkAndAJumpToTheNumberNextToThem) {
  for (const double at : {0.25, 1.0 / 3.0, 0.9999, 1e-5}) {
    PiecewiseFit fit;
    const auto kink = [at](double s) { return std::abs(s - at) + s * s; };
    EXPECT_LT(largest_difference(fit.of(kink), kink), 8e-15);
    ASSERT_EQ(fit.of(kink).size(), 2u) << at;
    EXPECT_NEAR(fit.of(kink)[0].end, at, 1e-14);
    const auto jump = [at](double s) { return s < at ? std::cos(s) : -std::sin(3.0 * s); };
    ASSERT_LE(fit.of(jump).size(), 3u) << at;
    const Piecewise& f = fit.of(jump);
    double nearest = 1.0;
    for (std::size_t i = 0; i + 1 < f.size(); ++i) nearest = std::min(nearest, std::abs(f[i].end - at));
    EXPECT_LE(nearest, 2.3e-16) << at;
    EXPECT_LT(fit.error(), 1e-13);
  }
}

// A kink beyond the last point of a trial polynomial had been taken for its end.
TEST(PiecewiseFit, SeesAKinkCloseToTheEndOfAPiece) {
  for (double at = 0.5 - 1e-3; at < 0.5; at += 3.7e-5) {
    PiecewiseFit fit;
    const auto f = [at](double s) { return std::max(0.0, s - at); };
    EXPECT_LT(largest_difference(fit.of(f), f), 1e-15) << at;
  }
}

// Their values are multiples of the smallest number, and no polynomial is within a part of that.
TEST(PiecewiseFit, TakesDenormalNumbersAsOnePiece) {
  for (const double size : {5e-324, 1e-310, 1e-307}) {
    PiecewiseFit fit;
    const auto tiny = [size](double s) { return size * std::sin(3.0 * s); };
    EXPECT_LE(fit.of(tiny).size(), 2u) << size;
    EXPECT_LE(largest_difference(fit.of(tiny), tiny), 2.0 * std::numeric_limits<double>::min());
  }
}

TEST(PiecewiseFit, FollowsWigglesAndSaysWhatItCannotFollow) {
  PiecewiseFit fit;
  const auto wiggles = [](double s) { return std::sin(300.0 * s); };
  EXPECT_LT(largest_difference(fit.of(wiggles), wiggles), 300 * 1e-14);
  EXPECT_LT(fit.error(), 300 * 1e-14);
  const auto root = [](double s) { return std::sqrt(std::abs(s - 0.3)); };
  EXPECT_LT(largest_difference(fit.of(root), root), 1e-11);
  EXPECT_GT(fit.error(), 1e-15);
}

// |s|^(-1/2) has an integral that is known to 1e-8, a jump and a brief pulse between breaks one to rounding; that of a
// pole is what roundings make of it.
TEST(PiecewiseFit, RefusesAPoleAndNothingElseThatIsLarge) {
  PiecewiseFit fit;
  const auto at = [](double s) { return s - 0.3; };
  for (const double power : {-1.0, -2.0, -0.9})
    EXPECT_THROW(fit.of([&](double s) { return std::pow(std::abs(at(s)), power); }), StepFailure) << power;
  EXPECT_THROW(fit.of([&](double s) { return 1e-9 / at(s) + 1.0; }), StepFailure);
  const double brief[] = {1e-10};
  EXPECT_NO_THROW(fit.of([](double s) { return s < 1e-10 ? 1e10 : 0.0; }, {.breaks = brief}));
  EXPECT_NO_THROW(fit.of([&](double s) { return 1.0 / std::sqrt(std::abs(at(s))); }));
  EXPECT_NO_THROW(fit.of([&](double s) { return at(s) > 0.0 ? 1e12 : 1.0; }));
  EXPECT_NO_THROW(fit.of([](double s) { return 1.0 / (1.00001 - s); }));
}

}  // namespace
}  // namespace viscobar::characteristics

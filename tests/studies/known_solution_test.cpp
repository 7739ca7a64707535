#include "viscobar/studies/exact/known_solution.hpp"

#include <gtest/gtest.h>

#include <limits>

#include "viscobar/studies/exact/exact_solutions.hpp"

namespace viscobar {
namespace {

constexpr double eps = std::numeric_limits<double>::epsilon();

Scene mirrored(const Scene& scene) {
  Scene other = scene;
  std::swap(other.left, other.right);
  const double length = scene.bar.length;
  other.displacement = [=](double x) { return scene.displacement(length - x); };
  other.velocity = [=](double x) { return scene.velocity(length - x); };
  return other;
}

/// The period-3 bar in units of its own: length 2, wave speed 2, gap 0.3, strain 0.4.
Scene period_three() {
  Scene scene;
  scene.bar = {2.0, 3.0, 12.0, 0.0};
  scene.left = Obstacle{0.3};
  scene.right = Fixed{};
  scene.displacement = [](double x) { return 0.4 * (2.0 - x) - 0.3; };
  scene.velocity = [](double) { return 0.0; };
  return scene;
}

TEST(KnownSolution, OfABarThatFliesIsRigidUntilTheFirstTouch) {
  const exact::RigidFlight flight{{1.0, 1.0, 1.0, 0.7}, 2.0, 0.5};
  const auto known = known_solution(flight.scene(), flight.closing());
  ASSERT_TRUE(known);
  EXPECT_DOUBLE_EQ(known->u(0.3, 0.2), flight.u(0.3, 0.2));
  EXPECT_FALSE(known_solution(flight.scene(), 1.01 * flight.closing())) << "a viscous impact has no closed form here";
}

TEST(KnownSolution, OfAnElasticImpactIsTheWaveAtEitherEnd) {
  const exact::ElasticImpact impact{{2.0, 3.0, 12.0, 0.0}, 0.5, 0.1};
  const auto left = known_solution(impact.scene(), 10.0), right = known_solution(mirrored(impact.scene()), 10.0);
  ASSERT_TRUE(left && right);
  for (const double t : {0.1, 0.9, 1.7, 3.0})
    for (const double x : {0.0, 0.3, 1.1, 2.0}) {
      EXPECT_DOUBLE_EQ(left->u(x, t), impact.u(x, t));
      EXPECT_DOUBLE_EQ(right->u(2.0 - x, t), impact.u(x, t));
    }
}

TEST(KnownSolution, OfThePeriodThreeBarHasItsEndTrace) {
  const auto known = known_solution(exact::PeriodThree::scene(), 100.0);
  ASSERT_TRUE(known);
  for (double t = 0.05; t < 7.0; t += 0.1)
    EXPECT_NEAR(known->u(0.0, t), exact::PeriodThree::end_displacement(t), 10 * eps) << t;
}

// Every solution of u_tt = c^2 u_xx has u(x, t + s) + u(x, t - s) = u(x + cs, t) + u(x - cs, t).
TEST(KnownSolution, OfThePeriodThreeBarSolvesTheWaveEquationAndKeepsItsEnds) {
  const Scene scene = period_three();
  const auto known = known_solution(scene, 100.0), other = known_solution(mirrored(scene), 100.0);
  ASSERT_TRUE(known && other);
  const auto u = known->u;
  for (double t = 0.13; t < 7.0; t += 0.11) {
    EXPECT_NEAR(u(2.0, t), -0.3, 10 * eps);
    EXPECT_GE(u(0.0, t), -0.3 - 10 * eps);
    for (const double x : {0.3, 0.9, 1.4}) {
      EXPECT_NEAR(u(x, t + 0.1) + u(x, t - 0.1), u(x + 0.2, t) + u(x - 0.2, t), 100 * eps) << x << " " << t;
      EXPECT_NEAR(other->u(2.0 - x, t), u(x, t), 100 * eps);
    }
  }
  for (const double x : {0.0, 0.7, 2.0}) EXPECT_DOUBLE_EQ(u(x, 0.0), scene.displacement(x));
}

TEST(KnownSolution, IsNotGuessedWhereTheDataAreOthers) {
  const Scene scene = period_three();
  const auto unknown = [&](auto change) {
    Scene other = scene;
    change(other);
    return !known_solution(other, 10.0);
  };
  EXPECT_TRUE(unknown([](Scene& s) { s.bar.viscosity = 1e-6; }));
  EXPECT_TRUE(unknown([](Scene& s) { s.load = SteadyLoad{[](double) { return 0.0; }}; }));
  EXPECT_TRUE(unknown([](Scene& s) { s.span = Obstacle{5.0}; }));
  EXPECT_TRUE(unknown([](Scene& s) { s.left = Obstacle{0.31}; }));
  EXPECT_TRUE(unknown([](Scene& s) { s.right = Free{}; }));
  EXPECT_TRUE(unknown([](Scene& s) { s.velocity = [](double x) { return 1e-9 * x; }; }));
  EXPECT_TRUE(
      unknown([](Scene& s) { s.displacement = [](double x) { return 0.4 * (2.0 - x) - 0.3 + 1e-9 * x * (2 - x); }; }));
}

}  // namespace
}  // namespace viscobar

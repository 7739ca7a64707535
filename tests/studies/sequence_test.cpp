#include <gtest/gtest.h>

#include <cmath>

#include "viscobar/studies/orders/observed_order.hpp"

namespace viscobar {
namespace {

Sequence sequence_of(double (*distance)(double), double floor, int values = 8) {
  Sequence sequence;
  for (int k = 0; k < values; ++k) {
    const double x = std::pow(10.0, -k);
    sequence.add(x, distance(x), floor);
  }
  return sequence;
}

TEST(Sequence, HasThePowerOfTheRangeThatLiesTenfoldAboveItsFloor) {
  // 0.01 below the floor of 1e-4 the distances are the floor's own: x^(1/2) is told down to 1e-6.
  const auto order = sequence_of([](double x) { return std::sqrt(x) + 1e-4; }, 1e-4).order();
  ASSERT_TRUE(order);
  EXPECT_LE(std::abs(order->order - 0.5), order->bound);
}

TEST(Sequence, TellsNoOrderWhereThePowersFromValueToValueDrift) {
  // As the differences of a penalised bar to a scheme whose step is in them: from power 1 to none.
  EXPECT_FALSE(sequence_of([](double x) { return x / (1.0 + 1e3 * x) + 1e-4; }, 1e-6, 5).order());
}

TEST(Sequence, KeepsTwoRegimesApart) {
  const Sequence both =
      sequence_of([](double x) { return x > 3e-4 ? std::pow(x, 2.0 / 3.0) : 14.938 * x; }, 0.0);  // they meet at 3e-4
  const auto ranges = both.settled();
  ASSERT_EQ(ranges.size(), 2u);
  EXPECT_NEAR(ranges[0].order, 2.0 / 3.0, ranges[0].bound + 1e-12);
  EXPECT_NEAR(ranges[1].order, 1.0, ranges[1].bound + 1e-12);
  EXPECT_NEAR(both.order()->order, 1.0, both.order()->bound + 1e-12);
}

TEST(Sequence, TellsNoPowerWhereALogarithmHidesIt) {
  // A contact that may pull lets go after log(1/x) of its time sqrt(x). Over seven decades the powers come to
  // 1/2 - 1/ln(1/x), 0.43, and the last three differ by 0.03 only.
  EXPECT_FALSE(sequence_of([](double x) { return std::sqrt(x) * std::log(3.0 / x); }, 0.0).order());
}

TEST(Sequence, TellsThePowerThatADriftLeavesAndABoundThatHasTheLimit) {
  // x^(1/2) (1 + x^(1/4)): powers from 0.63 to 0.51, each nearer to 1/2 by a factor of 1.8.
  const auto order = sequence_of([](double x) { return std::sqrt(x) * (1.0 + std::pow(x, 0.25)); }, 0.0, 10).order();
  ASSERT_TRUE(order);
  EXPECT_LE(std::abs(order->order - 0.5), order->bound);
}

TEST(Sequence, WantsMoreThanTwoPowersBehindAnother) {
  // 1/3 while bounces are still out of step, as of chatter that loses no speed, then 1/2: two powers near 1/2 alone
  // may be on their way.
  Sequence sequence;
  for (const double distance : {2.2e-2, 1.1e-2, 5.4e-3, 2.4e-3, 8.2e-4, 2.8e-4})
    sequence.add(std::pow(10.0, -static_cast<double>(sequence.x.size())), distance, 0.0);
  EXPECT_FALSE(sequence.order());
  for (const double power : {0.49, 0.497})
    sequence.add(0.1 * sequence.x.back(), sequence.distance.back() * std::pow(10.0, -power), 0.0);
  ASSERT_TRUE(sequence.order());
  EXPECT_NEAR(sequence.order()->order, 0.5, 0.03);
}

TEST(Sequence, OfDistancesToANeighbourOfTheLimitHasTheOrderOfThoseToTheLimitOrNone) {
  // A neighbour 3e-5 away, above which x^(1/2) is told down to 1e-6; of a sequence that does not settle it has none.
  const Sequence limit = sequence_of([](double x) { return std::sqrt(x); }, 0.0),
                 neighbour = sequence_of([](double x) { return std::sqrt(x) - 3e-5; }, 3e-5);
  const auto order = neighbour.order_within(limit.order());
  ASSERT_TRUE(order);
  EXPECT_NEAR(order->order, 0.5, order->bound);
  EXPECT_EQ(order->last, 6u);
  EXPECT_FALSE(neighbour.order_within({}));
}

TEST(Sequence, FallsToItsLimitOrDoesNot) {
  EXPECT_TRUE(sequence_of([](double x) { return std::sqrt(x); }, 0.0).falls(0.5));
  EXPECT_FALSE(sequence_of([](double x) { return 1e-2 + x; }, 0.0).falls(0.5));
  EXPECT_TRUE(sequence_of([](double) { return 1e-9; }, 1e-9).falls(0.5)) << "all of it is the floor";
  EXPECT_FALSE(sequence_of([](double x) { return x; }, 0.0, 2).falls(1.0)) << "two values show no order";
}

TEST(Sequence, FindsWhereADistanceIsReachedByThePowerBetweenItsNeighbours) {
  EXPECT_NEAR(*sequence_of([](double x) { return 3.0 * std::sqrt(x); }, 0.0).where(3e-2), 1e-4, 1e-12);
  EXPECT_FALSE(sequence_of([](double x) { return x; }, 0.0).where(2.0));
}

TEST(Sequence, OfFewMeshesTellsAnOrderToAFifthOrNone) {
  // Errors h^2 (1 + h) have powers 2.07 to 2.01 on five meshes, and h^(1/2) (1 + 30 h) 1.18 to 0.71: not settled.
  const auto order_of = [](double (*error)(double)) {
    Sequence sequence;
    sequence.within = Sequence::by_few;
    for (const double n : {10.0, 20.0, 40.0, 80.0, 160.0}) sequence.add(1.0 / n, error(1.0 / n), 0.0);
    return sequence.order();
  };
  const auto settles = order_of([](double h) { return h * h * (1.0 + h); });
  ASSERT_TRUE(settles);
  EXPECT_LE(std::abs(settles->order - 2.0), settles->bound);
  EXPECT_FALSE(order_of([](double h) { return std::sqrt(h) * (1.0 + 30.0 * h); }));
}

TEST(PowerOfChanges, IsThatOfTheErrorsOnMeshesOfAnyRatios) {
  for (const double p : {0.5, 1.0, 2.0, 4.0})
    for (const double last : {0.5, 0.3, 0.8}) {
      const double x[] = {1.0, 0.6, 0.6 * last};
      const auto error = [&](double at) { return 3.0 * std::pow(at, p); };
      const auto found =
          power_of_changes(x[0] / x[1], x[1] / x[2], error(x[0]) - error(x[1]), error(x[1]) - error(x[2]));
      ASSERT_TRUE(found);
      EXPECT_NEAR(*found, p, 1e-6);  // it is enclosed that closely
    }
  EXPECT_FALSE(power_of_changes(2.0, 2.0, 0.0, 1.0));
}

}  // namespace
}  // namespace viscobar

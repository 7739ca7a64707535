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

}  // namespace
}  // namespace viscobar

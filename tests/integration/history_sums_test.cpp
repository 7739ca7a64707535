#include <gtest/gtest.h>

#include <random>
#include <vector>

#include "integration/sundials/vector.hpp"

namespace viscobar::sundials::testing_history_sums {
namespace {

using History = std::vector<std::vector<double>>;

History random_history(std::size_t order, std::size_t n, std::mt19937& random) {
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  History history(order + 1, std::vector<double>(n));
  for (auto& vector : history)
    for (double& value : vector) value = uniform(random);
  return history;
}

// One after the other, as asked for.
void add(History& z, std::size_t j) {
  for (std::size_t i = 0; i < z[j].size(); ++i) z[j - 1][i] += z[j][i];
}

void put_off(HistorySums& sums, History& z, std::size_t j) {
  if (!sums.put_off(z[j - 1].data(), z[j].data(), z[j].size())) FAIL() << "no room";
}

TEST(HistorySums, AreThoseOfPascalsTriangleAndOfOneCascadeToTheLastBit) {
  std::mt19937 random(1);
  for (std::size_t order = 1; order <= 12; ++order)
    for (const std::size_t n : {1u, 7u, 8u, 43u})
      for (const bool whole : {false, true}) {
        History expected = random_history(order, n, random), z = expected;
        HistorySums sums;
        for (std::size_t k = 1; k <= (whole ? order : 1); ++k)
          for (std::size_t j = order; j >= k; --j) {
            add(expected, j);
            put_off(sums, z, j);
          }
        EXPECT_FALSE(sums.empty());
        sums.carry_out();
        EXPECT_TRUE(sums.empty());
        EXPECT_EQ(z, expected) << order << " " << n;
      }
}

TEST(HistorySums, OfNoPatternAreCarriedOutInTheirOrder) {
  std::mt19937 random(2);
  std::uniform_int_distribution<std::size_t> pick(1, 5);
  for (int trial = 0; trial < 200; ++trial) {
    History expected = random_history(5, 9, random), z = expected;
    HistorySums sums;
    for (int k = trial % 20; k >= 0; --k) {
      const std::size_t j = pick(random);
      add(expected, j);
      put_off(sums, z, j);
    }
    sums.carry_out();
    ASSERT_EQ(z, expected);
  }
}

TEST(HistorySums, OfTwoVectorsInTurnsReadWhatWasWritten) {
  double x = 1.0, y = 2.0;
  HistorySums sums;
  sums.put_off(&x, &y, 1);
  sums.put_off(&y, &x, 1);
  sums.put_off(&x, &y, 1);
  sums.carry_out();
  EXPECT_EQ(y, 5.0);
  EXPECT_EQ(x, 8.0);
}

TEST(HistorySums, HaveRoomForOrderTwelveAndForOneSize) {
  double x = 0.0, y = 1.0;
  HistorySums sums;
  for (int k = 0; k < 78; ++k) EXPECT_TRUE(sums.put_off(&x, &y, 1));
  EXPECT_FALSE(sums.put_off(&x, &y, 1));
  sums.carry_out();
  EXPECT_EQ(x, 78.0);
  EXPECT_TRUE(sums.put_off(&x, &y, 1));
  EXPECT_FALSE(sums.put_off(&x, &y, 2));
}

}  // namespace
}  // namespace viscobar::sundials::testing_history_sums

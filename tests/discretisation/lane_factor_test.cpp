#include "discretisation/lane_factor.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <random>

#include "support/random_vector.hpp"

namespace viscobar::testing_lane_factor {
namespace {

constexpr double eps = std::numeric_limits<double>::epsilon();

// tridiag(off, diagonal, off) with `odd` rows at either end that are unlike the rest.
BandedMatrix uniform_matrix(std::size_t n, double diagonal, double off, std::size_t odd) {
  BandedMatrix matrix;
  matrix.diagonal.assign(n, diagonal);
  matrix.off_diagonal.assign(n - 1, off);
  for (std::size_t i = 0; i < odd; ++i) {
    matrix.diagonal[i] *= 1.5 + static_cast<double>(i);
    matrix.diagonal[n - 1 - i] *= 2.0;
    if (i > 0) matrix.off_diagonal[i - 1] *= 0.5;
  }
  return matrix;
}

// A^{-1} b by both sweeps and a factor of the condensed matrix, in the order of the nodes.
std::vector<double> solve(const LaneFactor& factor, const std::vector<double>& b, double scale = 1.0) {
  const LaneOrder& order = factor.order();
  std::vector<double> ordered(b.size()), y(b.size()), interface(order.interface_size()), x(b.size());
  order.from_nodes(b, ordered);
  for (std::size_t i = 0; i < interface.size(); ++i) interface[i] = ordered[order.stored(i)];
  factor.eliminate([&](std::size_t k) { return load_lanes(&ordered[order.row(k)]) / scale; }, y, interface);
  TridiagonalFactor(factor.condensed()).solve(interface);
  factor.substitute(interface, y, [&](std::size_t k, const Lanes& row) { store_lanes(row, &ordered[order.row(k)]); });
  EXPECT_TRUE(std::ranges::equal(std::span(y).subspan(order.first, order.rows * lane_count),
                                 std::span(ordered).subspan(order.first, order.rows * lane_count)));
  for (std::size_t i = 0; i < interface.size(); ++i) ordered[order.stored(i)] = interface[i];
  order.to_nodes([&](std::size_t i) { return ordered[i]; }, x);
  return x;
}

// One order whatever the width of registers: 1e17 takes all that is added to it before it goes.
TEST(LaneFactor, SumsLanesByHalves) {
  for (std::size_t i = 0; i < lane_count; ++i)
    for (std::size_t j = 0; j < lane_count; ++j) {
      if (i == j) continue;
      std::array<double, lane_count> values;
      values.fill(1.0);
      values[i] = 1e17, values[j] = -1e17;
      // The lanes whose sums meet that of i before that of j does; both together are l = i mod `apart`.
      std::size_t apart = lane_count / 2;
      while (i % apart != j % apart) apart /= 2;
      const std::size_t lost = lane_count / apart;
      EXPECT_EQ(sum_of(load_lanes(values.data())), static_cast<double>(lane_count - lost)) << i << " " << j;
    }
}

// |A x - b| <= C eps |A| max|x| row by row, whatever the length, the coupling (also positive, as of a consistent mass
// at small steps) and the dominance, down to a matrix within 1e-9 of a singular one.
TEST(LaneFactor, SolvesWithABackwardErrorOfRoundingAtEveryLengthAndDominance) {
  std::mt19937 random(1);
  for (std::size_t n : {1u, 2u, 65u, 66u, 67u, 80u, 81u, 97u, 200u, 1001u, 5003u})
    for (const double off : {-1.0, 0.7})
      for (const double dominance : {10.0, 1.0, 1e-3, 1e-9})
        for (const std::size_t odd : {0u, 1u, 3u}) {
          if (2 * odd > n) continue;
          const BandedMatrix matrix = uniform_matrix(n, 2 * std::abs(off) + dominance, off, odd);
          const LaneFactor factor(matrix);
          EXPECT_EQ(factor.order().rows > 0, n >= 64 + 2 + (odd > 1 ? 2 * odd : 0)) << n << " " << odd;
          EXPECT_EQ(factor.order().size, n);
          const auto b = random_vector(n, random);
          const auto x = solve(factor, b);
          std::vector<double> residual(n);
          matrix.multiply(x, residual);
          double largest = 1.0;
          for (const double value : x) largest = std::max(largest, std::abs(value));
          for (std::size_t i = 0; i < n; ++i)
            ASSERT_NEAR(residual[i], b[i], 20 * eps * (8.0 + dominance) * largest) << n << " " << dominance << " " << i;
        }
}

TEST(LaneFactor, SolvesNothingByZero) {
  const LaneFactor factor(uniform_matrix(300, 2.5, -1.0, 1));
  for (const double x : solve(factor, std::vector<double>(300, 0.0))) EXPECT_EQ(x, 0.0);
}

TEST(LaneFactor, KeepsARowThatIsUnlikeItsNeighboursInTheInterface) {
  BandedMatrix matrix = uniform_matrix(400, 2.5, -1.0, 0);
  matrix.diagonal[150] += 1e6;  // a contact in the middle
  std::mt19937 random(2);
  const auto b = random_vector(400, random);
  auto x = b;
  TridiagonalFactor(matrix).solve(x);
  const auto y = solve(LaneFactor(matrix), b);
  for (std::size_t i = 0; i < x.size(); ++i) EXPECT_NEAR(y[i], x[i], 100 * eps);
}

TEST(LaneFactor, RefusesWhatIsNotPositiveDefinite) {
  const BandedMatrix inside = uniform_matrix(200, 1.0, -1.0, 0);
  EXPECT_THROW(LaneFactor{inside}, std::domain_error);
  BandedMatrix end = uniform_matrix(200, 2.5, -1.0, 0);
  end.diagonal[0] = -1.0;
  EXPECT_THROW(TridiagonalFactor(LaneFactor(end).condensed()), std::domain_error);
}

// Chains of bars of every length, down to three nodes, that are bonded, uncoupled, or share a node, whose rows at the
// joints have entries for nodes two away, and whose other rows have a skew part. Each equation holds to rounding, and
// nodes that are kept are in the interface. Where none is the order is even, joints lying in its lanes.
TEST(LaneFactor, TakesBarsOfUnlikeRowsWithABackwardErrorOfRounding) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  std::size_t taken = 0, even = 0;
  for (const double dominance : {1.0, 1e-3})
    for (std::size_t trial = 0; trial < 200; ++trial) {
      BandedMatrix matrix;
      std::vector<std::size_t> kept;
      const double longest = trial % 2 == 0 ? 20.0 + 300.0 * unit(random) : 20.0 * unit(random);
      const bool one_sided = trial % 3 != 2;
      for (std::size_t bar = 0; bar < 2 + trial % 29; ++bar) {
        const std::size_t count = 3 + static_cast<std::size_t>(longest * unit(random));
        const double stiffness = std::pow(10.0, 2.0 * unit(random) - 1.0);
        for (std::size_t i = 0; i < count; ++i) {
          const double uneven = stiffness * (1.0 + 0.3 * unit(random));
          if (!matrix.diagonal.empty()) {
            const bool joint = i == 0, uncoupled = joint && bar % 3 == 1;
            const double off = uncoupled ? 0.0 : uneven;
            matrix.off_diagonal.push_back(-off);
            matrix.diagonal.back() += off;
            const std::size_t node = matrix.size() - 1;
            const auto entries = [&](double of) { return std::array{0.3 * of, -0.3 * of * unit(random), 0.1 * of}; };
            if (joint && bar % 3 > 0 && trial % 4 > 0) kept.insert(kept.end(), {node, node + 1});
            if (joint && one_sided) {
              matrix.one_sided.push_back({node, true, entries(stiffness)});
              matrix.one_sided.push_back({bar % 3 > 0 ? node + 1 : node, false, entries(stiffness)});
            }
            matrix.diagonal.push_back(dominance * stiffness + off);
          } else {
            matrix.diagonal.push_back(dominance * stiffness);
          }
        }
      }
      const std::size_t n = matrix.size();
      const bool skew = trial % 5 > 2;
      for (std::size_t i = 0; skew && i + 1 < n; ++i)
        matrix.skew.push_back(0.3 * (2.0 * unit(random) - 1.0) * matrix.off_diagonal[i]);
      const LaneFactor factor(matrix, 2.0, kept);
      const LaneOrder& order = factor.order();
      ASSERT_EQ(factor.condensed().size(), order.interface_size());
      EXPECT_TRUE(one_sided || skew || factor.condensed().skew.empty());
      std::vector<double> b = random_vector(n, random), residual(n);
      if (order.rows > 0) {
        ++taken;
        even += order.even() && std::ranges::any_of(matrix.one_sided, [&](const OneSidedRow& one) {
                  return order.place(one.row) != order.stored(order.interface_index(one.row));
                });
        for (const std::size_t node : kept) EXPECT_EQ(order.place(node), order.stored(order.interface_index(node)));
      }
      const auto x = solve(factor, b, 2.0);
      matrix.multiply(x, residual);
      double largest = 1.0, size = 0.0;
      for (std::size_t i = 0; i < n; ++i) {
        largest = std::max(largest, std::abs(x[i]));
        size = std::max(size, matrix.diagonal[i]);
      }
      for (std::size_t i = 0; i < n; ++i)
        ASSERT_NEAR(residual[i], b[i], 20 * eps * 8.0 * size * largest) << trial << " " << i;
    }
  EXPECT_GT(taken, 200u);
  EXPECT_GT(even, 50u);
}

// Ten bars of a hundred nodes each have lanes as one bar of their nodes has. Where a node is kept their interface is
// it, the nodes of the joints, those between and behind lanes, and the ends.
TEST(LaneFactor, HasJointsInItsLanesOrTheirNodesAloneInTheInterface) {
  BandedMatrix matrix;
  matrix.diagonal.assign(1000, 3.0);
  matrix.off_diagonal.assign(999, -1.0);
  for (std::size_t node = 100; node < 1000; node += 100)
    for (const bool leftwards : {true, false}) matrix.one_sided.push_back({node, leftwards, {0.1, -0.2, 0.1}});
  const LaneOrder joints_in_lanes = LaneFactor(matrix, 1.0, {}).order();
  EXPECT_TRUE(joints_in_lanes.even());
  EXPECT_LE(joints_in_lanes.interface_size(), 2 * lane_count + 2);
  const LaneOrder kept = LaneFactor(matrix, 1.0, {50}).order();
  EXPECT_FALSE(kept.even());
  EXPECT_LE(kept.interface_size(), 10 + 2 * lane_count + 3);
}

TEST(LaneOrder, GoesThereAndBack) {
  std::vector<LaneOrder::Run> one_a_lane, several;
  for (std::size_t l = 0; l < lane_count; ++l) {
    one_a_lane.push_back({3 + 6 * l, l, 0, 5});
    several.push_back({2 + 9 * l, l, 0, 1});
    several.push_back({5 + 9 * l, l, 1, 4});
  }
  for (const LaneOrder& order : {LaneOrder{102, 3, 5, one_a_lane}, LaneOrder{150, 2, 5, several}}) {
    std::vector<double> nodal(order.size), ordered(order.size), back(order.size);
    std::iota(nodal.begin(), nodal.end(), 0.0);
    order.from_nodes(nodal, ordered);
    for (std::size_t i = 0; i < order.size; ++i) EXPECT_EQ(ordered[order.place(i)], nodal[i]);
    for (const std::size_t i : {0, 1}) {
      EXPECT_EQ(ordered[i], nodal[i]);
      EXPECT_EQ(ordered[order.size - 1 - i], nodal[order.size - 1 - i]);
    }
    order.to_nodes([&](std::size_t i) { return ordered[i]; }, back);
    EXPECT_EQ(back, nodal);
  }
}

TEST(LaneFields, BeginTheirRowsOnCacheLinesAndDoNotOverlap) {
  for (const std::size_t first : {1u, 2u, 9u}) {
    const LaneOrder order{first + 30 * lane_count + 2, first, 30};
    LaneFields fields(order, 5);
    for (std::size_t f = 0; f < 5; ++f) {
      EXPECT_EQ(fields[f].size(), order.size);
      EXPECT_EQ(reinterpret_cast<std::uintptr_t>(&fields[f][order.row(0)]) % 64, 0u);
      if (f > 0) {
        EXPECT_GE(fields[f].data(), fields[f - 1].data() + order.size);
      }
    }
  }
}

}  // namespace
}  // namespace viscobar::testing_lane_factor

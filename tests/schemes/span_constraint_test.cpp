#include "schemes/span_constraint.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numeric>
#include <random>

#include "support/maximum_norm.hpp"
#include "support/random_vector.hpp"

namespace viscobar::testing_span_constraint {
namespace {

constexpr double eps = std::numeric_limits<double>::epsilon();

enum class Signs { negative, positive, any };

// Smallest eigenvalue at least `dominance`, largest row sum at most 4 + dominance.
BandedMatrix random_matrix(std::size_t n, Signs signs, double dominance, std::mt19937& random) {
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  BandedMatrix matrix;
  matrix.diagonal.assign(n, dominance);
  matrix.off_diagonal.resize(n - 1);
  for (std::size_t i = 0; i + 1 < n; ++i) {
    double off = uniform(random);
    if (signs != Signs::any) off = signs == Signs::positive ? std::abs(off) : -std::abs(off);
    matrix.off_diagonal[i] = off;
    matrix.diagonal[i] += std::abs(off);
    matrix.diagonal[i + 1] += std::abs(off);
  }
  return matrix;
}

// The bounds bitwise, the rows and complementarity to rounding: these conditions have one solution only.
void expect_solution(const BandedMatrix& matrix, std::span<const double> b, std::span<const double> bound,
                     std::span<const double> x, std::span<const double> multiplier) {
  const std::size_t n = matrix.size();
  std::vector<double> row(n);
  matrix.multiply(x, row);
  const double rounding = 64 * eps * (largest(matrix.diagonal) * largest(x) + largest(b));
  for (std::size_t i = 0; i < n; ++i) {
    ASSERT_GE(x[i], bound[i]);
    ASSERT_GE(multiplier[i], 0.0);
    ASSERT_TRUE(multiplier[i] == 0.0 || x[i] == bound[i]);
    ASSERT_NEAR(row[i], b[i] + multiplier[i], rounding);
  }
}

// Bounded from below only.
void solve(SpanConstraint& constraint, std::span<const double> b, std::span<const double> bound, std::span<double> x,
           std::span<double> multiplier) {
  constraint.solve(b, bound, std::vector<double>(b.size(), std::numeric_limits<double>::infinity()), x, multiplier);
}

// Between two bounds: these conditions, too, have one solution only, and the mirror image of a problem has the mirror
// image of its solution.
TEST(SpanConstraint, HoldsEveryEntryBetweenItsTwoBounds) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> width(0.0, 0.7);
  std::size_t held[3] = {};
  for (int trial = 0; trial < 3000; ++trial) {
    const std::size_t n = 1 + random() % 12;
    const auto matrix = random_matrix(n, static_cast<Signs>(random() % 3), 0.05, random);
    const auto b = random_vector(n, random);
    auto lower = random_vector(n, random), upper = lower;
    for (double& bound : upper) bound += width(random);
    SpanConstraint constraint(matrix);
    std::vector<double> x(n), multiplier(n), row(n);
    constraint.solve(b, lower, upper, x, multiplier);
    matrix.multiply(x, row);
    const double rounding = 64 * eps * (largest(matrix.diagonal) * largest(x) + largest(b));
    for (std::size_t i = 0; i < n; ++i) {
      ASSERT_GE(x[i], lower[i]);
      ASSERT_LE(x[i], upper[i]);
      ASSERT_NEAR(row[i], b[i] + multiplier[i], rounding);
      ASSERT_TRUE(multiplier[i] <= 0.0 || x[i] == lower[i]) << i;
      ASSERT_TRUE(multiplier[i] >= 0.0 || x[i] == upper[i]) << i;
      ++held[constraint.active()[i]];
    }
    std::vector<double> turned_b(b), turned_lower(n), turned_upper(n), turned(n), turned_multiplier(n);
    for (std::size_t i = 0; i < n; ++i) {
      turned_b[i] = -b[i];
      turned_lower[i] = -upper[i];
      turned_upper[i] = -lower[i];
    }
    SpanConstraint mirrored(matrix);
    mirrored.solve(turned_b, turned_lower, turned_upper, turned, turned_multiplier);
    for (std::size_t i = 0; i < n; ++i) ASSERT_EQ(turned[i], -x[i]);
  }
  for (const std::size_t count : held) EXPECT_GT(count, 1000u);
}

TEST(SpanConstraint, FindsTheOneActiveSetOfAllThatFits) {
  std::mt19937 random(1);
  for (int trial = 0; trial < 3000; ++trial) {
    const std::size_t n = 1 + random() % 8;
    const double dominance = 0.05;
    const auto matrix = random_matrix(n, static_cast<Signs>(random() % 3), dominance, random);
    const auto b = random_vector(n, random), bound = random_vector(n, random);
    SpanConstraint constraint(matrix);
    std::vector<double> x(n), multiplier(n);
    solve(constraint, b, bound, x, multiplier);
    expect_solution(matrix, b, bound, x, multiplier);

    const double rounding = 64 * eps * 5.0 / dominance * (largest(x) + 1.0);
    int fitting = 0;
    for (unsigned set = 0; set < (1u << n); ++set) {
      BandedMatrix held = matrix;
      std::vector<double> y(b), row(n);
      for (std::size_t i = 0; i < n; ++i)
        if (set >> i & 1) {
          held.diagonal[i] = 1e20;  // a spring that is stiff beyond rounding
          y[i] = 1e20 * bound[i];
        }
      TridiagonalFactor(held).solve(y);
      matrix.multiply(y, row);
      bool fits = true, same = true;
      for (std::size_t i = 0; i < n; ++i) {
        const bool active = set >> i & 1;
        fits &= active ? row[i] >= b[i] - rounding : y[i] >= bound[i] - rounding;
        same &= active == static_cast<bool>(constraint.active()[i]);
      }
      fitting += fits;
      if (same) {
        EXPECT_TRUE(fits);
      }
    }
    EXPECT_EQ(fitting, 1) << trial;
  }
}

TEST(SpanConstraint, EndsFromEveryActiveSetItIsStartedFrom) {
  std::mt19937 random(2);
  for (int trial = 0; trial < 2000; ++trial) {
    const std::size_t n = 2 + random() % 60;
    const double dominance = std::pow(10.0, -static_cast<double>(random() % 9));
    const auto matrix = random_matrix(n, static_cast<Signs>(random() % 3), dominance, random);
    SpanConstraint constraint(matrix);
    std::vector<double> x(n), multiplier(n);
    for (int problem = 0; problem < 5; ++problem) {
      const auto b = random_vector(n, random);
      auto bound = random_vector(n, random, problem % 2 ? 1e3 : 1e-3);
      if (problem > 2)  // entries that were held may have no bound now
        for (double& value : bound)
          if (random() % 3 == 0) value = -std::numeric_limits<double>::infinity();
      solve(constraint, b, bound, x, multiplier);
      expect_solution(matrix, b, bound, x, multiplier);
    }
  }
}

TEST(SpanConstraint, EndsForPositiveCouplingCloseToSingular) {
  std::mt19937 random(3);
  for (int trial = 0; trial < 3000; ++trial) {
    const std::size_t n = 3 + random() % 40;
    BandedMatrix matrix;
    matrix.diagonal.assign(n, 1.0 + 1e-6);
    matrix.off_diagonal.assign(n - 1, trial % 2 ? 0.5 : 0.5 * (1.0 - 1e-3));
    const auto b = random_vector(n, random);
    const std::vector<double> bound(n, 0.0);
    SpanConstraint constraint(matrix);
    std::vector<double> x(n), multiplier(n);
    solve(constraint, b, bound, x, multiplier);
    expect_solution(matrix, b, bound, x, multiplier);
  }
}

// A string that lies on the ground and is lifted at one end comes off entry by entry, always with one wrong entry. The
// positive coupling at its other end takes away the proof that this goes on to the solution.
TEST(SpanConstraint, ChangesOneEntryAtATimeWhereTheNumberOfWrongOnesDoesNotFall) {
  const std::size_t n = 200, lifted = 50;
  BandedMatrix matrix{std::vector<double>(n, 2.0 + 1e-9), std::vector<double>(n - 1, -1.0)};
  matrix.off_diagonal.back() = 1.0;
  std::vector<double> b(n, -1.0), x(n), multiplier(n);
  const std::vector<double> bound(n, 0.0);
  SpanConstraint constraint(matrix);
  solve(constraint, b, bound, x, multiplier);
  ASSERT_EQ(std::accumulate(constraint.active().begin(), constraint.active().end(), 0u), n);
  const std::size_t before = constraint.solves();
  // x_i = (m - i)(m - 1 - i) / 2, i < m, has second difference 1 and meets x = 0 at entries m - 1 and m.
  const double m = static_cast<double>(lifted);
  b[0] = 2 * (m * (m - 1) / 2) - (m - 1) * (m - 2) / 2;
  solve(constraint, b, bound, x, multiplier);
  expect_solution(matrix, b, bound, x, multiplier);
  for (std::size_t i = 0; i + 2 < lifted; ++i) EXPECT_GT(x[i], 0.0);
  for (std::size_t i = lifted; i < n; ++i) EXPECT_EQ(x[i], 0.0);
  EXPECT_GT(constraint.solves() - before, 20u);
  EXPECT_LE(constraint.solves() - before, n);
}

TEST(SpanConstraint, NeedsAtMostAPivotAnEntryForAnMMatrix) {
  std::mt19937 random(4);
  for (int trial = 0; trial < 500; ++trial) {
    const std::size_t n = 2 + random() % 100;
    const auto matrix = random_matrix(n, Signs::negative, 1e-4, random);
    const auto b = random_vector(n, random), bound = random_vector(n, random);
    SpanConstraint constraint(matrix);
    std::vector<double> x(n), multiplier(n);
    solve(constraint, b, bound, x, multiplier);
    EXPECT_LE(constraint.solves(), n + 1);
  }
}

TEST(SpanConstraint, RestartsFromTheLastActiveSetWithASingleSolveAndNoFactorisation) {
  std::mt19937 random(5);
  const std::size_t n = 50;
  const auto matrix = random_matrix(n, Signs::any, 0.1, random);
  auto b = random_vector(n, random);
  const auto bound = random_vector(n, random);
  SpanConstraint constraint(matrix);
  std::vector<double> x(n), multiplier(n);
  solve(constraint, b, bound, x, multiplier);
  const std::size_t solves = constraint.solves(), factorisations = constraint.factorisations();
  for (double& value : b) value *= 1 + 4 * eps;
  solve(constraint, b, bound, x, multiplier);
  EXPECT_EQ(constraint.solves(), solves + 1);
  EXPECT_EQ(constraint.factorisations(), factorisations);
}

TEST(SpanConstraint, TiesInEveryEntryEnd) {
  for (const double off : {-0.49, 0.49}) {
    const std::size_t n = 101;
    BandedMatrix matrix{std::vector<double>(n, 1.0), std::vector<double>(n - 1, off)};
    std::vector<double> bound(n, 0.1), b(n), x(n), multiplier(n);
    matrix.multiply(bound, b);  // the unconstrained solution is the bound
    SpanConstraint constraint(matrix);
    solve(constraint, b, bound, x, multiplier);
    expect_solution(matrix, b, bound, x, multiplier);
  }
}

}  // namespace
}  // namespace viscobar::testing_span_constraint

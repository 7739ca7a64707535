#include "viscobar/discretisation/tridiagonal.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include "support/random_vector.hpp"

namespace viscobar::testing_tridiagonal {
namespace {

constexpr double eps = std::numeric_limits<double>::epsilon();

// Off-diagonals of either sign, `dominance` above the row sum on the diagonal.
BandedMatrix random_matrix(std::size_t n, double dominance, std::mt19937& random) {
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  BandedMatrix matrix;
  matrix.off_diagonal.resize(n - 1);
  for (double& off : matrix.off_diagonal) off = uniform(random);
  matrix.diagonal.assign(n, dominance);
  for (std::size_t i = 0; i + 1 < n; ++i) {
    matrix.diagonal[i] += std::abs(matrix.off_diagonal[i]);
    matrix.diagonal[i + 1] += std::abs(matrix.off_diagonal[i]);
  }
  return matrix;
}

double entry(const BandedMatrix& matrix, std::size_t i, std::size_t j) {
  if (i == j) return matrix.diagonal[i];
  const bool neighbours = i + 1 == j || j + 1 == i;
  return neighbours && !matrix.off_diagonal.empty() ? matrix.off_diagonal[std::min(i, j)] : 0.0;
}

// Zeros behind a vector move its last terms from what is left of a loop into its wide part, where a compiler contracts
// other operations of a sum that it keeps in order. Registers of another width do the same.
TEST(Tridiagonal, ZerosBehindAVectorChangeNoBitOfItsQuadraticForm) {
  std::mt19937 random(2);
  for (std::size_t n = 2; n < 40; ++n)
    for (std::size_t zeros = 1; zeros <= 16; ++zeros) {
      const BandedMatrix matrix = random_matrix(n + zeros, 1.0, random);
      BandedMatrix part = matrix;
      part.diagonal.resize(n), part.off_diagonal.resize(n - 1);
      std::vector<double> x = random_vector(n, random);
      const double alone = part.quadratic_form(x);
      x.resize(n + zeros);
      EXPECT_EQ(matrix.quadratic_form(x), alone) << n << " " << zeros;
    }
}

TEST(Tridiagonal, MultiplyAndQuadraticFormAreThoseOfTheFullMatrix) {
  std::mt19937 random(1);
  for (std::size_t n = 1; n < 20; ++n)
    for (const bool diagonal : {false, true}) {
      BandedMatrix matrix = random_matrix(n, 1.0, random);
      if (diagonal) matrix.off_diagonal.clear();
      const auto x = random_vector(n, random);
      std::vector<double> product(n);
      matrix.multiply(x, product);
      double form = 0.0;
      for (std::size_t i = 0; i < n; ++i) {
        double row = 0.0;
        for (std::size_t j = 0; j < n; ++j) row += entry(matrix, i, j) * x[j];
        EXPECT_NEAR(product[i], row, 20 * eps);
        form += x[i] * row;
      }
      EXPECT_NEAR(matrix.quadratic_form(x), form, 20 * static_cast<double>(n) * eps);
    }
}

TEST(TridiagonalFactor, SolvesWithABackwardErrorOfRoundingAtEverySizeAndDominance) {
  std::mt19937 random(2);
  for (std::size_t n = 1; n < 70; ++n)
    for (const double dominance : {10.0, 1.0, 1e-3, 1e-9})
      for (const bool diagonal : {false, true}) {
        BandedMatrix matrix = random_matrix(n, dominance, random);
        if (diagonal) matrix.off_diagonal.clear();
        const auto b = random_vector(n, random);
        auto x = b;
        TridiagonalFactor(matrix).solve(x);
        std::vector<double> residual(n);
        matrix.multiply(x, residual);
        double largest = 1.0;
        for (const double value : x) largest = std::max(largest, std::abs(value));
        const double norm = 4.0 + dominance;
        for (std::size_t i = 0; i < n; ++i)
          EXPECT_NEAR(residual[i], b[i], 20 * eps * norm * largest) << n << " " << dominance;
      }
}

TEST(TridiagonalFactor, IsRebuiltInPlaceForAnotherSizeAndStructure) {
  std::mt19937 random(3);
  TridiagonalFactor factor(random_matrix(9, 1.0, random));
  BandedMatrix diagonal;
  diagonal.diagonal = {2.0, 4.0, 8.0};
  factor.factorise(diagonal);
  std::vector<double> x{2.0, 2.0, 2.0};
  factor.solve(x);
  EXPECT_EQ(x, (std::vector<double>{1.0, 0.5, 0.25}));
}

TEST(TridiagonalFactor, RefusesWhatIsNotPositiveDefinite) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(TridiagonalFactor(BandedMatrix{{1.0, 1.0}, {1.0}}), std::domain_error);
  EXPECT_THROW(TridiagonalFactor(BandedMatrix{{1.0, -1.0}, {}}), std::domain_error);
  EXPECT_THROW(TridiagonalFactor(BandedMatrix{{0.0}, {}}), std::domain_error);
  EXPECT_THROW(TridiagonalFactor(BandedMatrix{{2.0, nan, 2.0}, {0.1, 0.1}}), std::domain_error);
  const double infinite = std::numeric_limits<double>::infinity();
  EXPECT_TRUE((BandedMatrix{{infinite, -1.0}, {0.0}}.finite()));  // a node that is held
  EXPECT_FALSE((BandedMatrix{{2.0, nan}, {0.1}}.finite()));
  EXPECT_FALSE((BandedMatrix{{2.0, 2.0}, {infinite}}.finite()));
}

TEST(InverseDiagonal, HoldsTheDiagonalEntriesOfTheColumnsOfTheInverse) {
  std::mt19937 random(4);
  for (std::size_t n = 1; n < 20; ++n) {
    const BandedMatrix matrix = random_matrix(n, 0.5, random);
    const TridiagonalFactor factor(matrix);
    const auto diagonal = inverse_diagonal(matrix);
    const double condition = 4.5 / 0.5;  // largest row sum over smallest eigenvalue
    for (std::size_t i = 0; i < n; ++i) {
      std::vector<double> column(n, 0.0);
      column[i] = 1.0;
      factor.solve(column);
      EXPECT_NEAR(diagonal[i], column[i], 10 * condition * eps * column[i]);
    }
  }
}

TEST(InverseDiagonal, OfOneSidedRowsAtEndsAndJointsIsThatOfTheColumns) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> uniform(-0.2, 0.2);
  for (std::size_t n = 6; n < 40; ++n)
    for (const bool skew : {false, true}) {
      BandedMatrix matrix = random_matrix(n, 1.0, random);
      const auto entries = [&] { return std::array{uniform(random), uniform(random), uniform(random)}; };
      matrix.one_sided.push_back({0, false, entries()});
      for (std::size_t joint = 3; joint + 3 < n; joint += 3 + joint % 2)
        matrix.one_sided.push_back({joint, true, entries()}), matrix.one_sided.push_back({joint, false, entries()});
      matrix.one_sided.push_back({n - 1, true, entries()});
      for (std::size_t i = 0; skew && i + 1 < n; ++i) matrix.skew.push_back(uniform(random));
      const TridiagonalFactor factor(matrix);
      const auto diagonal = inverse_diagonal(matrix);
      for (std::size_t i = 0; i < n; ++i) {
        std::vector<double> column(n, 0.0);
        column[i] = 1.0;
        factor.solve(column);
        EXPECT_NEAR(diagonal[i], column[i], 1000 * eps) << n << " " << i;
      }
    }
}

}  // namespace
}  // namespace viscobar::testing_tridiagonal

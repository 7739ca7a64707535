// The mass fourth_order and the factor of matrices with end rows; docs/fourth-order.md derives what is claimed.
#include <gtest/gtest.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <utility>
#include <vector>

#include "discretisation/lane_factor.hpp"
#include "support/decompositions.hpp"
#include "viscobar/discretisation/mass.hpp"

namespace viscobar::testing_fourth_order {
namespace {

constexpr double eps = std::numeric_limits<double>::epsilon();
using Matrix = Eigen::Matrix<long double, Eigen::Dynamic, Eigen::Dynamic>;
using Vector = Eigen::Matrix<long double, Eigen::Dynamic, 1>;

// int phi_i x^p: the hat function of node i, one-sided at the ends.
double moment(const Mesh& mesh, std::size_t i, int p) {
  const double h = mesh.spacing();
  double sum = 0.0;
  // Gauss' three points on each element beside, exact for degree five.
  for (const int side : {-1, 1}) {
    if ((side < 0 && i == 0) || (side > 0 && i == mesh.elements)) continue;
    for (const auto& [s, weight] :
         {std::pair{0.5 - std::sqrt(0.15), 5.0 / 18}, {0.5, 8.0 / 18}, {0.5 + std::sqrt(0.15), 5.0 / 18}})
      sum += weight * h * (1 - s) * std::pow(mesh.node(i) + side * s * h, p);
  }
  return sum;
}

std::vector<double> times_power(const Mesh& mesh, int p) {
  std::vector<double> x(mesh.nodes()), product(mesh.nodes());
  for (std::size_t j = 0; j < x.size(); ++j) x[j] = std::pow(mesh.node(j), p);
  mass_matrix(mesh, Mass::fourth_order).multiply(x, product);
  return product;
}

TEST(FourthOrderMass, HasInnerRowsExactForCubicsAndEndRowsExactForQuadratics) {
  for (const std::size_t elements : {3u, 4u, 17u}) {
    const Mesh mesh{1.5, elements};
    for (int p = 0; p <= 3; ++p) {
      const auto product = times_power(mesh, p);
      for (std::size_t i = 0; i < mesh.nodes(); ++i) {
        if (p == 3 && (i == 0 || i == elements)) continue;
        EXPECT_NEAR(product[i], moment(mesh, i, p), 20 * eps * std::pow(1.5, p + 1))
            << elements << " " << p << " " << i;
      }
    }
  }
}

TEST(FourthOrderMass, HasEndRowsWhoseErrorIsOfOrderFour) {
  const auto error = [](std::size_t elements) {
    const Mesh mesh{1.0, elements};
    return std::abs(times_power(mesh, 3).back() - moment(mesh, elements, 3));
  };
  // h (7, 6, -1) / 24 on x^3 from the end: h^4 (6 - 8) / 24 = -h^4 / 12 for h^4 / 20.
  for (const std::size_t elements : {8u, 16u}) {
    const double h = 1.0 / static_cast<double>(elements);
    EXPECT_NEAR(error(elements), (1.0 / 12 + 1.0 / 20) * std::pow(h, 4), 10 * eps) << elements;
  }
}

TEST(FourthOrderMass, HasTheColumnSumsOfGregorysRuleSoThatMomentumIsOfOrderFour) {
  const Mesh mesh{2.0, 12};
  const auto matrix = mass_matrix(mesh, Mass::fourth_order);
  const double expected[] = {3.0 / 8, 7.0 / 6, 23.0 / 24, 1.0, 1.0};
  std::vector<double> unit(mesh.nodes()), column(mesh.nodes());
  for (std::size_t j = 0; j < mesh.nodes(); ++j) {
    std::ranges::fill(unit, 0.0);
    unit[j] = 1.0;
    matrix.multiply(unit, column);
    double sum = 0.0;
    for (const double entry : column) sum += entry;
    const std::size_t from_end = std::min({j, mesh.elements - j, std::size_t{4}});
    EXPECT_NEAR(sum / mesh.spacing(), expected[from_end], 10 * eps) << j;
  }
}

TEST(FourthOrderMass, RefusesLessThanThreeElements) {
  EXPECT_THROW(mass_matrix({1.0, 2}, Mass::fourth_order), std::invalid_argument);
  EXPECT_NO_THROW(mass_matrix({1.0, 3}, Mass::fourth_order));
}

Matrix dense(const BandedMatrix& matrix) {
  const auto n = static_cast<Eigen::Index>(matrix.size());
  Matrix full(n, n);
  std::vector<double> unit(matrix.size()), column(matrix.size());
  for (std::size_t j = 0; j < matrix.size(); ++j) {
    std::ranges::fill(unit, 0.0);
    unit[j] = 1.0;
    matrix.multiply(unit, column);
    full.col(static_cast<Eigen::Index>(j)) = Eigen::Map<const Eigen::VectorXd>(column.data(), n).cast<long double>();
  }
  return full;
}

// Proved in docs/fourth-order.md: real and not negative; the largest h^2 omega^2 is 7.968 on long bars with a free end,
// more on less than nine elements with two. Rounding of the eigenvalues: eps times the largest and the condition of the
// eigenvectors, some ten.
TEST(FourthOrderMass, HasRealEigenvaluesThatAreNotNegativeWhateverTheEnds) {
  for (const bool left_fixed : {false, true})
    for (const bool right_fixed : {false, true})
      for (const std::size_t elements : {3u, 4u, 5u, 8u, 21u, 100u}) {
        const Mesh mesh{static_cast<double>(elements), elements};  // h = 1
        const Eigen::Index first = left_fixed, n = static_cast<Eigen::Index>(mesh.nodes()) - first - right_fixed;
        const Matrix mass = dense(mass_matrix(mesh, Mass::fourth_order)).block(first, first, n, n);
        BandedMatrix laplacian{std::vector<double>(mesh.nodes(), 2.0), std::vector<double>(elements, -1.0)};
        laplacian.diagonal.front() = laplacian.diagonal.back() = 1.0;
        const Matrix stiffness = dense(laplacian).block(first, first, n, n);
        const Matrix schur = testing_support::schur_form(testing_support::quotient(mass, stiffness));
        const Vector values = schur.diagonal();
        const double rounding = 1e3 * eps * static_cast<double>(n);
        // A pair of complex values would be a block with an entry below the diagonal.
        EXPECT_EQ(schur.diagonal<-1>().cwiseAbs().maxCoeff(), 0.0) << elements;
        EXPECT_GE(values.minCoeff(), -rounding) << elements;
        const double longest = left_fixed && right_fixed ? 6.0 : elements < 9 ? 9.17 : 7.97;
        EXPECT_LE(values.maxCoeff(), longest) << elements;
      }
}

BandedMatrix random_with_end_rows(std::size_t n, std::mt19937& random) {
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  BandedMatrix matrix{std::vector<double>(n, 3.5), std::vector<double>(n - 1)};
  for (double& off : matrix.off_diagonal) off = uniform(random);
  for (const bool last : {false, true}) {
    OneSidedRow& row = matrix.one_sided.emplace_back(OneSidedRow{last ? n - 1 : 0, last, {}});
    for (double& entry : row.entries) entry = 0.5 * uniform(random);
  }
  return matrix;
}

// As bars in line have them: nodes inside have rows to both sides, or two neighbours one each, with nothing between.
BandedMatrix random_chain(std::size_t n, std::size_t joint, bool apart, std::mt19937& random) {
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  BandedMatrix matrix = random_with_end_rows(n, random);
  const OneSidedRow last = matrix.one_sided.back();
  matrix.one_sided.pop_back();
  for (const bool leftwards : {true, false}) {
    OneSidedRow row{leftwards || !apart ? joint : joint + 1, leftwards, {}};
    for (double& entry : row.entries) entry = 0.4 * uniform(random);
    matrix.one_sided.push_back(row);
  }
  matrix.one_sided.push_back(last);
  if (apart) matrix.off_diagonal[joint] = 0.0;
  return matrix;
}

TEST(TridiagonalFactor, SolvesWithRowsOfBarsInLine) {
  std::mt19937 random(15);
  for (const bool apart : {false, true})
    for (std::size_t n = 7; n < 40; ++n)
      for (std::size_t joint = 3; joint + 4 < n; ++joint)
        for (const bool skew : {false, true}) {
          BandedMatrix matrix = random_chain(n, joint, apart, random);
          if (skew) matrix.skew.assign(n - 1, 0.1);
          if (skew && apart) matrix.skew[joint] = 0.0;
          const Matrix full = dense(matrix);
          std::vector<double> x(n);
          for (std::size_t i = 0; i < n; ++i) x[i] = std::sin(static_cast<double>(i * i + n));
          const Vector b =
              Eigen::Map<const Eigen::VectorXd>(x.data(), static_cast<Eigen::Index>(n)).cast<long double>();
          TridiagonalFactor(matrix).solve(x);
          const Vector solved =
              Eigen::Map<const Eigen::VectorXd>(x.data(), static_cast<Eigen::Index>(n)).cast<long double>();
          EXPECT_LE((full * solved - b).cwiseAbs().maxCoeff(), 200 * eps) << n << ' ' << joint << apart << skew;
          const Matrix inverse = testing_support::inverse(full);
          const std::vector<double> diagonal = inverse_diagonal(matrix);
          for (std::size_t i = 0; i < n; ++i)
            EXPECT_NEAR(diagonal[i],
                        static_cast<double>(inverse(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(i))),
                        1000 * eps);
        }
}

// The sum of two rows that are tied counts, and they have one value.
TEST(TridiagonalFactor, TiesTwoRows) {
  std::mt19937 random(16);
  for (const auto& [rows, symmetric] : {std::pair{true, false}, {false, false}, {false, true}})
    for (std::size_t n = 8; n < 30; ++n)
      for (std::size_t joint = 3; joint + 4 < n; ++joint) {
        BandedMatrix matrix = random_chain(n, joint, true, random);
        if (!rows) matrix.one_sided.clear();
        if (symmetric) matrix.skew.clear();
        const Matrix full = dense(matrix);
        matrix.tie(joint);
        std::vector<double> x(n);
        for (std::size_t i = 0; i < n; ++i) x[i] = std::sin(static_cast<double>(i * i + n));
        const Vector b = Eigen::Map<const Eigen::VectorXd>(x.data(), static_cast<Eigen::Index>(n)).cast<long double>();
        TridiagonalFactor(matrix).solve(x);
        EXPECT_EQ(x[joint], x[joint + 1]);
        const Vector solved =
            Eigen::Map<const Eigen::VectorXd>(x.data(), static_cast<Eigen::Index>(n)).cast<long double>();
        Vector left = full * solved - b;
        const auto a = static_cast<Eigen::Index>(joint);
        left(a) = left(a + 1) = left(a) + left(a + 1);
        EXPECT_LE(left.cwiseAbs().maxCoeff(), 200 * eps) << n << ' ' << joint;
      }
}

TEST(TridiagonalFactor, SolvesWithEndRowsAtEverySize) {
  std::mt19937 random(5);
  for (std::size_t n = 3; n < 40; ++n) {
    const BandedMatrix matrix = random_with_end_rows(n, random);
    const Matrix full = dense(matrix);
    std::vector<double> x(n);
    for (std::size_t i = 0; i < n; ++i) x[i] = std::sin(static_cast<double>(i * i + n));
    const Vector b = Eigen::Map<const Eigen::VectorXd>(x.data(), static_cast<Eigen::Index>(n)).cast<long double>();
    TridiagonalFactor(matrix).solve(x);
    const Vector solved = Eigen::Map<const Eigen::VectorXd>(x.data(), static_cast<Eigen::Index>(n)).cast<long double>();
    EXPECT_LE((full * solved - b).cwiseAbs().maxCoeff(), 100 * eps) << n;
  }
}

TEST(TridiagonalFactor, HoldsANodeOfInfiniteMassWithEndRows) {
  std::mt19937 random(6);
  for (const std::size_t n : {3u, 4u, 9u}) {
    for (const std::size_t held : {std::size_t{0}, n - 1}) {
      BandedMatrix matrix = random_with_end_rows(n, random);
      const Matrix full = dense(matrix);
      matrix.diagonal[held] = std::numeric_limits<double>::infinity();
      std::vector<double> x(n, 1.0);
      TridiagonalFactor(matrix).solve(x);
      EXPECT_EQ(x[held], 0.0);
      const Vector solved =
                       Eigen::Map<const Eigen::VectorXd>(x.data(), static_cast<Eigen::Index>(n)).cast<long double>(),
                   product = full * solved;
      for (std::size_t i = 0; i < n; ++i)
        if (i != held) {
          EXPECT_NEAR(static_cast<double>(product[static_cast<Eigen::Index>(i)]), 1.0, 100 * eps);
        }
    }
  }
}

TEST(Tridiagonal, DiagonalOfTheInverseKnowsEndRows) {
  std::mt19937 random(7);
  for (std::size_t n = 3; n < 20; ++n) {
    const BandedMatrix matrix = random_with_end_rows(n, random);
    const Matrix inverse = testing_support::inverse(dense(matrix));
    const std::vector<double> diagonal = inverse_diagonal(matrix);
    for (std::size_t i = 0; i < n; ++i)
      EXPECT_NEAR(diagonal[i], static_cast<double>(inverse(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(i))),
                  100 * eps)
          << n;
  }
}

TEST(LaneFactor, KeepsTheColumnsOfEndRowsInTheInterface) {
  BandedMatrix matrix = mass_matrix({1.0, 150}, Mass::fourth_order);
  const LaneFactor factor(matrix);
  ASSERT_GT(factor.order().rows, 0u);
  EXPECT_GE(factor.order().first, 3u);
  EXPECT_LE(factor.order().runs.back().node_behind() + 3, 150u);
  EXPECT_EQ(factor.condensed().one_sided.back().row, factor.condensed().size() - 1);
}

}  // namespace
}  // namespace viscobar::testing_fourth_order

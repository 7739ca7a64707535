#include "viscobar/discretisation/mass.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

namespace viscobar::testing_mass {
namespace {

constexpr double eps = std::numeric_limits<double>::epsilon();
constexpr Mass all_masses[] = {Mass::consistent, Mass::lumped, Mass::paper, Mass::redistributed, Mass::fourth_order};

std::vector<double> power_of_x(const Mesh& mesh, int power) {
  std::vector<double> values(mesh.nodes(), 1.0);
  for (std::size_t j = 0; j < values.size(); ++j)
    for (int k = 0; k < power; ++k) values[j] *= mesh.node(j);
  return values;
}

double product(const BandedMatrix& m, const std::vector<double>& a, const std::vector<double>& b) {
  std::vector<double> mb(b.size());
  m.multiply(b, mb);
  double sum = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += a[i] * mb[i];
  return sum;
}

TEST(Mass, KeepsTheMassOfTheBarButForThePapersProduct) {
  for (const Mass mass : all_masses)
    for (const std::size_t elements : {3u, 4u, 50u}) {
      const Mesh mesh{2.0, elements};
      const auto one = power_of_x(mesh, 0);
      const double surplus = mass == Mass::paper ? mesh.spacing() : 0.0;  // h at each end instead of h / 2
      EXPECT_NEAR(product(inertia_matrix(mesh, mass, true, true), one, one), 2.0 + surplus,
                  10 * static_cast<double>(elements) * eps)
          << name(mass) << " " << elements;
    }
}

TEST(Mass, RedistributedKeepsCentreOfMassAndMomentOfInertiaAndFreesContactNodes) {
  for (const bool left : {false, true})
    for (const bool right : {false, true}) {
      const Mesh mesh{3.0, 7};
      const auto matrix = inertia_matrix(mesh, Mass::redistributed, left, right);
      const auto one = power_of_x(mesh, 0), x = power_of_x(mesh, 1);
      EXPECT_NEAR(product(matrix, one, x), 4.5, 100 * eps);
      EXPECT_NEAR(product(matrix, x, x), 9.0, 300 * eps);
      EXPECT_EQ(matrix.diagonal.front() == 0.0 && matrix.off_diagonal.front() == 0.0, left);
      EXPECT_EQ(matrix.diagonal.back() == 0.0 && matrix.off_diagonal.back() == 0.0, right);
    }
}

TEST(Mass, RedistributedIsPositiveDefiniteOnTheSmallestMeshes) {
  const auto massive = [](const BandedMatrix& m, std::size_t first, std::size_t count) {
    BandedMatrix part;
    for (std::size_t i = 0; i < count; ++i) part.diagonal.push_back(m.diagonal[first + i]);
    for (std::size_t i = 0; i + 1 < count; ++i) part.off_diagonal.push_back(m.off_diagonal[first + i]);
    return part;
  };
  EXPECT_NO_THROW(TridiagonalFactor(massive(inertia_matrix({1.0, 2}, Mass::redistributed, true, false), 1, 2)));
  EXPECT_NO_THROW(TridiagonalFactor(massive(inertia_matrix({1.0, 3}, Mass::redistributed, true, true), 1, 2)));
  EXPECT_THROW(inertia_matrix({1.0, 1}, Mass::redistributed, true, false), std::invalid_argument);
  EXPECT_THROW(inertia_matrix({1.0, 2}, Mass::redistributed, true, true), std::invalid_argument);
}

TEST(Mass, ConsistentIntegratesProductsOfLinearFunctionsExactly) {
  const Mesh mesh{3.0, 11};
  const auto x = power_of_x(mesh, 1);
  EXPECT_NEAR(product(mass_matrix(mesh, Mass::consistent), x, x), 9.0, 100 * eps);
}

TEST(Mass, DiagonalMassesStoreNoOffDiagonal) {
  EXPECT_TRUE(mass_matrix({1.0, 5}, Mass::lumped).off_diagonal.empty());
  EXPECT_TRUE(mass_matrix({1.0, 5}, Mass::paper).off_diagonal.empty());
}

// (3.24b) holds as <u,v> - (u,v) = h^2/6 a(u,v) with the trapezoidal product, at any boundary values; the printed
// (h/2) u_J v_J, and its missing twin at x = 0, are what the printed weights add.
TEST(Mass, LumpedMinusConsistentIsASixthOfTheStiffnessAndThePapersProductAddsHalfAnElementAtEachEnd) {
  const Mesh mesh{1.0, 6};
  const double h = mesh.spacing();
  const std::vector<double> u{0.3, -1.0, 2.0, 0.7, 0.1, -0.4, 1.5}, v{1.1, 0.2, -0.6, 0.9, 1.3, 0.8, -2.0};
  double a = 0.0;
  for (std::size_t i = 0; i < mesh.elements; ++i) a += (u[i + 1] - u[i]) * (v[i + 1] - v[i]) / h;
  const double exact = product(mass_matrix(mesh, Mass::consistent), u, v);
  const double lumped = product(mass_matrix(mesh, Mass::lumped), u, v);
  const double paper = product(mass_matrix(mesh, Mass::paper), u, v);
  EXPECT_NEAR(lumped - exact, h * h / 6 * a, 50 * eps);
  EXPECT_NEAR(paper - lumped, h / 2 * (u.front() * v.front() + u.back() * v.back()), 50 * eps);
}

// On unequal elements the extrapolation to the end has other weights; what it keeps is the same.
TEST(Mass, OnAGradedMeshKeepsTotalCentreAndMomentOfInertia) {
  for (const Mass mass : {Mass::consistent, Mass::lumped, Mass::redistributed})
    for (const bool left : {false, true})
      for (const bool right : {false, true})
        for (const std::size_t elements : {3u, 8u, 51u}) {
          const Mesh mesh{3.0, elements, {16.0, left, right}};
          const auto matrix = inertia_matrix(mesh, mass, left, right);
          const auto one = power_of_x(mesh, 0), x = power_of_x(mesh, 1);
          const double rounding = 10 * static_cast<double>(elements) * eps;
          EXPECT_NEAR(product(matrix, one, one), 3.0, 3.0 * rounding) << name(mass) << " " << elements;
          EXPECT_NEAR(product(matrix, one, x), 4.5, 4.5 * rounding) << name(mass) << " " << elements;
          // The trapezoidal rule adds h^3 / 6 an element.
          double surplus = 0.0;
          if (mass == Mass::lumped)
            for (std::size_t j = 0; j < elements; ++j) surplus += std::pow(mesh.element(j), 3) / 6;
          EXPECT_NEAR(product(matrix, x, x), 9.0 + surplus, 30.0 * rounding) << name(mass) << " " << elements;
          if (mass != Mass::redistributed) continue;
          EXPECT_EQ(matrix.diagonal.front() == 0.0 && matrix.off_diagonal.front() == 0.0, left);
          EXPECT_EQ(matrix.diagonal.back() == 0.0 && matrix.off_diagonal.back() == 0.0, right);
        }
}

TEST(Mass, OfThePaperRefusesUnequalElements) {
  EXPECT_THROW(mass_matrix({1.0, 5, {2.0, true, false}}, Mass::paper), std::invalid_argument);
}

}  // namespace
}  // namespace viscobar::testing_mass

// The semi-discrete bar on elements of unequal size.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>

#include "viscobar/dynamics/bar_system.hpp"

namespace viscobar::testing_graded_system {
namespace {

constexpr double eps = std::numeric_limits<double>::epsilon();

EndCondition end_condition(char kind) {
  if (kind == 'o') return Obstacle{0.1};
  if (kind == 'x') return Fixed{};
  return Free{};
}

Scene scene(const std::string& ends, double viscosity) {
  Scene scene;
  scene.bar = {2.0, 3.0, 5.0, viscosity};
  scene.left = end_condition(ends[0]);
  scene.right = end_condition(ends[1]);
  scene.displacement = [](double x) { return 0.3 + 0.2 * x; };
  scene.velocity = [](double x) { return std::sin(x); };
  scene.load = SteadyLoad{[](double x) { return std::cos(x); }};
  return scene;
}

struct Fields {
  std::vector<double> u, w;
};

Fields fields(const BarSystem& system) {
  Fields fields;
  for (std::size_t i = 0; i < system.size(); ++i) {
    const double x = system.mesh().node(i + system.unknowns().first_node());
    fields.u.push_back(0.3 + std::sin(3 * x));
    fields.w.push_back(std::cos(5 * x));
  }
  return fields;
}

class GradedSystem : public testing::TestWithParam<std::tuple<const char*, double, Mass>> {
 protected:
  Scene scene_ = scene(std::get<0>(GetParam()), std::get<1>(GetParam()));
  Mass mass_ = std::get<2>(GetParam());
  BarSystem on(double ratio) const { return BarSystem(scene_, {2.0, 12, {ratio, true, true}}, mass_); }
};

// The formulas for unequal elements at a ratio that differs from 1 by rounding, against those for equal ones.
TEST_P(GradedSystem, TendsToTheUniformOneAsTheRatioTendsToOne) {
  const BarSystem uniform = on(1.0), graded = on(1.0 + 8 * eps);
  ASSERT_TRUE(uniform.mesh().uniform());
  ASSERT_FALSE(graded.mesh().uniform());
  const auto [u, w] = fields(uniform);
  const std::size_t n = uniform.size();
  std::vector<double> force(n), expected(n);
  graded.internal_force(u, w, force);
  uniform.internal_force(u, w, expected);
  BandedMatrix matrix, other;
  graded.dynamic_stiffness(1.0, 0.5, 0.25, matrix);
  uniform.dynamic_stiffness(1.0, 0.5, 0.25, other);
  // Sizes differ by 8 eps, differences of neighbours carry eps |u|, each over h = 1/6.
  const double rounding = 100 * eps * 5.0 * 6.0;
  for (std::size_t i = 0; i < n; ++i) {
    EXPECT_NEAR(force[i], expected[i], rounding) << i;
    EXPECT_NEAR(matrix.diagonal[i], other.diagonal[i], rounding) << i;
    EXPECT_NEAR(graded.elements().stiffness_diagonal(i), uniform.elements().stiffness_diagonal(i), rounding) << i;
  }
  for (std::size_t i = 0; i + 1 < n; ++i) EXPECT_NEAR(matrix.off_diagonal[i], other.off_diagonal[i], rounding) << i;
  EXPECT_NEAR(graded.energy(u, w), uniform.energy(u, w), rounding * 10);
  EXPECT_NEAR(graded.elements().squared_strain_rate(w), uniform.elements().squared_strain_rate(w), rounding * 10);
}

TEST_P(GradedSystem, ForcesAreThoseOfItsStiffnessAndItsEnergy) {
  const BarSystem system = on(16.0);
  const auto [u, w] = fields(system);
  const std::size_t n = system.size();
  const std::vector<double> still(n, 0.0);
  BandedMatrix K;
  system.dynamic_stiffness(0.0, 0.0, 1.0 / system.bar().modulus, K);
  std::vector<double> at_rest(n), moved(n), Ku(n), force(n);
  system.internal_force(still, still, at_rest);  // pull of the fixed ends
  system.internal_force(u, w, force);
  K.multiply(u, Ku);
  system.dynamic_stiffness(0.0, 1.0, 0.0, K);
  std::vector<double> Cw(n, 0.0);
  if (system.bar().damped()) K.multiply(w, Cw);
  const double largest = 5.0 / system.mesh().smallest();
  for (std::size_t i = 0; i < n; ++i) EXPECT_NEAR(force[i] - at_rest[i], -5.0 * Ku[i] - Cw[i], 20 * eps * largest) << i;
  // dE/du along w, by a difference that is exact for a quadratic.
  std::vector<double> ahead = u, behind = u;
  for (std::size_t i = 0; i < n; ++i) ahead[i] += w[i], behind[i] -= w[i];
  const double rise =
      0.5 * 5.0 * (system.elements().squared_strain(ahead) - system.elements().squared_strain(behind)) / 2;
  system.internal_force(u, still, force);
  double work = 0.0;
  for (std::size_t i = 0; i < n; ++i) work -= force[i] * w[i];
  EXPECT_NEAR(rise, work, 100 * eps * largest * 5.0);
}

INSTANTIATE_TEST_SUITE_P(Bars, GradedSystem,
                         testing::Combine(testing::Values("oo", "ox", "xo", "xx"), testing::Values(0.0, 0.5),
                                          testing::Values(Mass::consistent, Mass::lumped, Mass::redistributed)));

TEST(GradedBar, ARigidMotionHasNoInternalForceAtAll) {
  for (const double viscosity : {0.0, 0.5}) {
    const BarSystem system(scene("oo", viscosity), {2.0, 12, {64.0, true, true}}, Mass::consistent);
    const std::vector<double> u(system.size(), 0.7), w(system.size(), -1.3);
    std::vector<double> force(system.size(), 1.0);
    system.internal_force(u, w, force);
    for (const double f : force) EXPECT_EQ(f, 0.0);
  }
}

}  // namespace
}  // namespace viscobar::testing_graded_system

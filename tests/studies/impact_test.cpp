// The semi-discrete bars against the laws of impact.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <tuple>

#include "viscobar/case/recording.hpp"
#include "viscobar/studies/exact/exact_solutions.hpp"
#include "viscobar/studies/orders/observed_order.hpp"

namespace viscobar {
namespace {

Case penalised(const exact::ImpactLaw& law, Mass mass, std::size_t elements, double contact) {
  Case run;
  run.scene = law.scene();
  run.elements = elements;
  run.mass = mass;
  run.method = mass == Mass::redistributed ? MethodName::ida : MethodName::cvode;
  run.epsilon = law.epsilon;
  run.tolerance = {1e-8, 1e-11};
  run.end = law.closing() + contact;
  run.output_every = contact / 400.0;
  return run;
}

// max over the contact of |d - d_exact|, per the largest d.
double curve_error(const exact::ImpactLaw& law, Mass mass, std::size_t elements, double contact) {
  const Recording recording = record(penalised(law, mass, elements, contact));
  double worst = 0.0, deepest = 0.0;
  for (std::size_t k = 0; k < recording.times.size(); ++k) {
    const double since = recording.times[k] - law.closing();
    if (since < 0.0) continue;
    const double d = -(recording.displacement(k).front() + law.gap), exact = law.penetration(since);
    worst = std::max(worst, std::abs(d - exact));
    deepest = std::max(deepest, exact);
  }
  return worst / deepest;
}

class ImpactOnThePenalty : public testing::TestWithParam<Mass> {};

TEST_P(ImpactOnThePenalty, FollowsTheWholeCurveOfTheLaw) {
  struct Impact {
    double viscosity, epsilon;
    std::size_t elements;
  };
  // The layer sqrt(eta t) at the peak, t = 1.6 (epsilon sqrt(eta))^(2/3), is ten elements or more.
  for (const auto [viscosity, epsilon, elements] : {Impact{1.0, 1e-3, 216}, {1.0, 1e-4, 432}, {0.1, 1e-3, 864}}) {
    const exact::ImpactLaw law{.bar = {1.0, 1.0, 1.0, viscosity}, .speed = 0.7, .epsilon = epsilon, .gap = 0.05};
    const double contact = 10.0 * std::pow(epsilon * std::sqrt(viscosity), 2.0 / 3.0);
    EXPECT_LT(curve_error(law, GetParam(), elements, contact), 0.01) << viscosity << " " << epsilon;
  }
}

TEST_P(ImpactOnThePenalty, WithoutViscosityRisesExponentially) {
  const exact::ImpactLaw law{.bar = {1.0, 1.0, 1.0, 0.0}, .speed = 0.7, .epsilon = 0.1, .gap = 0.05};
  // d'' jumps by V / epsilon at first touch: the mesh follows to O(h / epsilon).
  for (const std::size_t elements : {100u, 200u, 400u})
    EXPECT_LT(curve_error(law, GetParam(), elements, 1.5), 0.5 / (0.1 * static_cast<double>(elements))) << elements;
}

INSTANTIATE_TEST_SUITE_P(Masses, ImpactOnThePenalty,
                         testing::Values(Mass::consistent, Mass::lumped, Mass::redistributed));

TEST(ImpactOnThePenalty, GoesAsThePowerTwoThirdsWithTheConstantOfTheLaw) {
  std::vector<double> epsilons, depths;
  for (const double epsilon : {1e-4, 1e-5, 1e-6}) {
    const exact::ImpactLaw law{.bar = {1.0, 1.0, 1.0, 1.0}, .speed = 0.7, .epsilon = epsilon, .gap = 0.05};
    const double tau = std::pow(epsilon, 2.0 / 3.0);
    const auto elements = static_cast<std::size_t>(10.0 / std::sqrt(tau));
    const Recording recording = record(penalised(law, Mass::redistributed, elements, 4.0 * tau));
    const double depth = recording.statistics.max_penetration;
    EXPECT_NEAR(depth / (0.7 * tau), 0.8580, 0.0086) << epsilon;
    epsilons.push_back(epsilon);
    depths.push_back(depth);
  }
  EXPECT_NEAR(observed_order(epsilons, depths)->order, 2.0 / 3.0, 0.02);
}

TEST(ImpactOnThePenalty, WithoutViscosityThePowerIsOne) {
  std::vector<double> epsilons, depths;
  for (const double epsilon : {0.08, 0.04, 0.02, 0.01}) {
    const exact::ImpactLaw law{.bar = {1.0, 1.0, 1.0, 0.0}, .speed = 0.7, .epsilon = epsilon, .gap = 0.05};
    const Recording recording = record(penalised(law, Mass::redistributed, 2000, 12 * epsilon));
    epsilons.push_back(epsilon);
    depths.push_back(recording.statistics.max_penetration);
  }
  EXPECT_NEAR(observed_order(epsilons, depths)->order, 1.0, 0.02);
}

// A bar that falls flat on a span obstacle: u uniform in x.
Case flat_fall(MethodName method, std::optional<double> restitution) {
  Case run;
  run.scene.span = Obstacle{0.2};
  run.scene.displacement = [](double) { return 0.0; };
  run.scene.velocity = [](double) { return -0.5; };
  run.elements = 20;
  run.mass = Mass::consistent;
  run.method = method;
  run.epsilon = 1e-6;
  run.restitution = restitution;
  run.tolerance = {1e-9, 1e-12};
  run.step = 1e-4;
  run.end = 1.0;
  run.output_every = 0.05;
  return run;
}

class FlatFall : public testing::TestWithParam<std::tuple<MethodName, double>> {};

TEST_P(FlatFall, LeavesTheSpanWithItsRestitution) {
  const auto [method, restitution] = GetParam();
  const Recording recording = record(flat_fall(method, restitution));
  // It falls for 0.4 with 0.5 and goes back with the restitution's share. The penalty holds it for pi sqrt(epsilon)
  // or so, the scheme for a step or two.
  const double back = -0.2 + 0.5 * restitution * (1.0 - 0.4);
  for (const double u : recording.displacement(recording.times.size() - 1)) EXPECT_NEAR(u, back, 0.5 * 5e-3);
  for (const double v : recording.velocity(recording.times.size() - 1)) EXPECT_NEAR(v, 0.5 * restitution, 1e-3);
}

INSTANTIATE_TEST_SUITE_P(Methods, FlatFall,
                         testing::Combine(testing::Values(MethodName::cvode, MethodName::ida, MethodName::arkode,
                                                          MethodName::odeint, MethodName::exponential,
                                                          MethodName::fully_discrete),
                                          testing::Values(0.0, 0.25, 0.5, 1.0)));

TEST(FlatFall, ThePapersPairDisagreesTheUndampedPenaltyReboundsAndTheConstraintHolds) {
  const Recording penalised = record(flat_fall(MethodName::cvode, std::nullopt));
  const Recording scheme = record(flat_fall(MethodName::fully_discrete, std::nullopt));
  EXPECT_NEAR(penalised.velocity(20)[7], 0.5, 1e-6);
  EXPECT_NEAR(scheme.velocity(20)[7], 0.0, 1e-12);
}

}  // namespace
}  // namespace viscobar

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "support/run_trace.hpp"
#include "viscobar/schemes/schemes.hpp"

namespace viscobar::testing_paper {
namespace {

constexpr double eps = std::numeric_limits<double>::epsilon();

// Section 4: [0, 26], 702 elements, dt = 0.125, T = 40, alpha = 1; gaps are not printed, u_0(26) = -650.
Scene section_four() {
  Scene scene;
  scene.bar = {26.0, 1.0, 1.0, 1.0};
  scene.displacement = scene.velocity = [](double x) { return x * (1 - x); };
  return scene;
}

Load figures_two_and_three() {
  return SeparableLoad{[](double x) { return std::cos(2 * x); }, [](double t) { return std::sin(t * std::sqrt(2.0)); }};
}

RunTrace run_section_four(const Scene& scene) {
  return record(BarSystem(scene, {26.0, 702}, Mass::consistent), uniform_times(0.125, 320), FullyDiscrete{0.125});
}

TEST(Paper, FigureOneTouchesOnTheLeftFrom1125To26AndOnTheRightFromTheStartTo23875) {
  Scene scene = section_four();
  scene.left = Obstacle{1.0};
  scene.right = Obstacle{650.0};
  const auto run = run_section_four(scene);
  ASSERT_EQ(run.events.size(), 4u);
  const auto expect = [&](std::size_t k, double time, Where where, Change change) {
    EXPECT_EQ(run.events[k].time, time);
    EXPECT_EQ(run.events[k].where, where);
    EXPECT_EQ(run.events[k].change, change);
  };
  expect(0, 0.0, Where::right, Change::closing);  // where the data touch
  expect(1, 1.125, Where::left, Change::closing);
  expect(2, 23.875, Where::right, Change::opening);
  expect(3, 26.0, Where::left, Change::opening);
  // An end rests at -c exactly, not at the printed max(c, .).
  for (std::size_t k = 0; k < run.times.size(); ++k) {
    if (run.times[k] >= 1.125 && run.times[k] <= 26.0) {
      EXPECT_EQ(run.u[k].front(), -1.0);
    }
    if (run.times[k] <= 23.875) {
      EXPECT_EQ(run.u[k].back(), -650.0);
    }
  }
}

TEST(Paper, TheSixPanelsRunAndKeepTheirConstraintsAndEnergyBalance) {
  for (const bool loaded : {false, true})
    for (const int figure : {1, 2, 3}) {
      Scene scene = section_four();
      if (figure != 3) scene.left = Obstacle{1.0};
      if (figure == 1) scene.right = Obstacle{650.0};
      if (figure == 3) scene.span = Obstacle{650.0};
      if (loaded) scene.load = figures_two_and_three();
      const auto run = run_section_four(scene);
      const EnergyAccount& energy = *run.statistics.energy;
      EXPECT_NEAR(energy.balance_error(), 0.0, 320 * 703 * eps * energy.initial);
      EXPECT_GT(run.statistics.events, 0u);
      for (std::size_t k = 0; k < run.times.size(); ++k) {
        if (figure != 3) {
          EXPECT_GE(run.u[k].front(), -1.0);
        }
        if (figure == 1) {
          EXPECT_GE(run.u[k].back(), -650.0);
        }
        if (figure == 3) {
          EXPECT_GE(*std::min_element(run.u[k].begin(), run.u[k].end()), -650.0);
        }
        EXPECT_GE(run.reaction_left[k], 0.0);
        EXPECT_GE(run.reaction_right[k], 0.0);
      }
    }
}

// docs/paper.md. At the paper's step some energy is left, and the bar drifts off.
TEST(Paper, TheSpanPanelDriftsOffAtThePapersStepAndRestsAtATenthOfIt) {
  Scene scene = section_four();
  scene.span = Obstacle{650.0};
  const auto drifts = run_section_four(scene);
  EXPECT_EQ(drifts.events.back().change, Change::opening);
  EXPECT_EQ(drifts.events.back().time, 11.75);
  EXPECT_EQ(std::ranges::count(drifts.events, Change::opening, &Event::change),
            std::ranges::count(drifts.events, Change::closing, &Event::change));
  const auto [low, high] = std::ranges::minmax(drifts.u.back());
  EXPECT_GT(low, -649.976);
  EXPECT_LT(high, -649.952);
  const auto rests =
      record(BarSystem(scene, {26.0, 702}, Mass::consistent), std::vector<double>{0.0, 40.0}, FullyDiscrete{0.0125});
  EXPECT_EQ(rests.events.size(), 703u);
  EXPECT_EQ(rests.u.back(), std::vector<double>(703, -650.0));
}

Scene unit_bar(double velocity_sign) {
  Scene scene;
  scene.bar.viscosity = 1.0;
  scene.left = scene.right = Obstacle{0.1};
  scene.displacement = [](double x) { return x * (1 - x); };
  scene.velocity = [=](double x) { return velocity_sign * x * (1 - x); };
  return scene;
}

TEST(Paper, OnTheUnitIntervalTheBarFliesOff) {
  const BarSystem system(unit_bar(1.0), {1.0, 27}, Mass::consistent);
  EXPECT_EQ(record(system, std::vector<double>{0.0, 40.0}, FullyDiscrete{1e-3}).statistics.events, 0u);
}

TEST(Paper, OnTheUnitIntervalThrownAtTheObstaclesBothEndsHitTogether) {
  const BarSystem system(unit_bar(-1.0), {1.0, 27}, Mass::consistent);
  const double dt = 1e-4, digits = 5e-5;
  const auto run = record(system, std::vector<double>{0.0, 1.5}, FullyDiscrete{dt});
  ASSERT_GE(run.events.size(), 2u);
  EXPECT_NEAR(run.events[0].time, 1.3466, dt + digits);
  EXPECT_EQ(run.events[0].time, run.events[1].time);
  EXPECT_NE(run.events[0].where, run.events[1].where);
}

// The rows of (3.22) with: 1/dt^2 + 1/(2 dx^2) + alpha/(2 dt dx^2) for c_Delta, f in the end rows, u_2^{n-1} -
// u_1^{n-1} where (1.7) has u_2 twice, max(-c, .), and both ends alike. `end` is the weight of an end relative to dx: 1
// in (3.23) as printed, 1/2 for the trapezoidal product.
void expect_difference_scheme(Mass mass, double end) {
  const double alpha = 0.7, dt = 0.02, c = 0.1;
  Scene scene = unit_bar(-1.0);
  scene.bar.viscosity = alpha;
  const auto f = [](double x, double t) { return std::cos(3 * x + t) - 1.0; };
  scene.load = GeneralLoad{f};
  const Mesh mesh{1.0, 12};
  const double dx = mesh.spacing();
  const auto run = record(BarSystem(scene, mesh, mass), uniform_times(dt, 200), FullyDiscrete{dt});
  const double laplacian = 1 / (2 * dx * dx), damping = alpha / (2 * dt * dx * dx);
  const double rounding = 200 * eps / (dt * dt);  // of second differences of |u| <= 1
  int held = 0, open = 0;
  double printed_constant_misses = 0.0;
  for (std::size_t n = 1; n + 1 < run.times.size(); ++n) {
    const auto &up = run.u[n + 1], &u = run.u[n], &um = run.u[n - 1];
    for (std::size_t j = 1; j < mesh.elements; ++j) {
      const auto d2 = [&](const std::vector<double>& w) { return w[j + 1] - 2 * w[j] + w[j - 1]; };
      EXPECT_NEAR((up[j] - 2 * u[j] + um[j]) / (dt * dt) - laplacian * (d2(up) + d2(um)) - damping * (d2(up) - d2(um)),
                  f(mesh.node(j), run.times[n]), rounding);
    }
    for (const bool left : {true, false}) {
      const std::size_t j = left ? 0 : mesh.elements, in = left ? 1 : mesh.elements - 1;
      const double terms = end * (2 * u[j] - um[j]) / (dt * dt) + laplacian * (up[in] + um[in] - um[j]) +
                           damping * (up[in] - (um[in] - um[j])) + end * f(mesh.node(j), run.times[n]);
      const double constant = end / (dt * dt) + laplacian + damping;
      EXPECT_NEAR(up[j], std::max(-c, terms / constant), rounding / constant);
      up[j] == -c ? ++held : ++open;
      const double printed = end / (dt * dt) - laplacian - damping;
      printed_constant_misses = std::max(printed_constant_misses, std::abs(up[j] - std::max(c, terms / printed)));
    }
  }
  EXPECT_GT(held, 10);
  EXPECT_GT(open, 10);
  EXPECT_GT(printed_constant_misses, c);
}

TEST(Paper, SchemeThreeTwentyTwoCorrectedIsThePapersProductRowByRow) { expect_difference_scheme(Mass::paper, 1.0); }

TEST(Paper, SchemeThreeTwentyTwoWithHalfWeightsAtTheEndsIsTheLumpedProductRowByRow) {
  expect_difference_scheme(Mass::lumped, 0.5);
}

}  // namespace
}  // namespace viscobar::testing_paper

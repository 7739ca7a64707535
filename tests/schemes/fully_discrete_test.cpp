#include <gtest/gtest.h>

#include <array>
#include <chrono>
#include <cmath>
#include <limits>

#include "support/exact_solutions.hpp"
#include "support/run_trace.hpp"
#include "viscobar/dynamics/bar_system.hpp"
#include "viscobar/schemes/schemes.hpp"

namespace viscobar::testing_fully_discrete {
namespace {

constexpr double eps = std::numeric_limits<double>::epsilon();

struct Error {
  double l2, h1;
};

// Norms over the bar of the P1 field minus a smooth one, by two Gauss points an element: exact up to O(h^4) for the
// square of what matters here.
template <class Exact>
Error error_of(const std::vector<double>& u, const Mesh& mesh, const Exact& exact, double t) {
  const double h = mesh.spacing(), offset = h / 2 / std::sqrt(3.0);
  Error squared{};
  for (std::size_t j = 0; j < mesh.elements; ++j)
    for (const double x : {mesh.node(j) + h / 2 - offset, mesh.node(j) + h / 2 + offset}) {
      const double local = (x - mesh.node(j)) / h;
      squared.l2 += h / 2 * std::pow((1 - local) * u[j] + local * u[j + 1] - exact.u(x, t), 2);
      squared.h1 += h / 2 * std::pow((u[j + 1] - u[j]) / h - exact.u_x(x, t), 2);
    }
  return {std::sqrt(squared.l2), std::sqrt(squared.h1)};
}

template <class Exact>
Error run_error(const Exact& exact, std::size_t elements, Mass mass, double step_ratio, Start start) {
  const Mesh mesh{exact.shape.length, elements};
  const BarSystem system(exact.scene(), mesh, mass);
  const std::vector<double> times{0.0, 1.3};
  const auto run = record(system, times, FullyDiscrete{step_ratio * mesh.spacing(), start});
  return error_of(run.u.back(), mesh, exact, times.back());
}

constexpr std::array<std::array<bool, 2>, 4> all_fixings{{{false, false}, {true, false}, {false, true}, {true, true}}};

TEST(FullyDiscrete, IsSecondOrderInL2AndFirstInH1ForADampedModeUnderFreeFixedAndMixedEnds) {
  for (const auto& [left, right] : all_fixings)
    for (const Mass mass : {Mass::consistent, Mass::lumped, Mass::redistributed}) {
      const exact::DampedMode mode{{1.5, 1.2, 0.8, 0.05}, {1.5, left, right, 1}, 0.7};
      const Error coarse = run_error(mode, 60, mass, 0.5, Start::second_order);
      const Error fine = run_error(mode, 120, mass, 0.5, Start::second_order);
      EXPECT_NEAR(std::log2(coarse.l2 / fine.l2), 2.0, 0.1) << name(mass) << left << right;
      EXPECT_NEAR(std::log2(coarse.h1 / fine.h1), 1.0, 0.1) << name(mass) << left << right;
    }
}

TEST(FullyDiscrete, IsSecondOrderForADrivenModeUnderFreeFixedAndMixedEnds) {
  for (const auto& [left, right] : all_fixings)
    for (const double viscosity : {0.0, 0.3}) {
      const exact::DrivenMode mode{{1.0, 1.3, 0.9, viscosity}, {1.0, left, right, 0}, 2.0};
      const Error coarse = run_error(mode, 40, Mass::consistent, 0.5, Start::second_order);
      const Error fine = run_error(mode, 80, Mass::consistent, 0.5, Start::second_order);
      EXPECT_NEAR(std::log2(coarse.l2 / fine.l2), 2.0, 0.1) << viscosity << left << right;
    }
}

// The weights of (3.23) make the bar h too heavy where an end is free.
TEST(FullyDiscrete, IsFirstOrderOnThePapersMassAndSecondOnceItsEndWeightsAreHalved) {
  const exact::DampedMode mode{{1.0, 1.0, 1.0, 0.05}, {1.0, false, false, 0}, 0.0};
  const auto order = [&](Mass mass) {
    return std::log2(run_error(mode, 80, mass, 0.25, Start::second_order).l2 /
                     run_error(mode, 160, mass, 0.25, Start::second_order).l2);
  };
  EXPECT_NEAR(order(Mass::paper), 1.0, 0.1);
  EXPECT_NEAR(order(Mass::lumped), 2.0, 0.1);
}

// The mode of a mesh moves like one of the bar with kappa_h^2 = (6 / h^2) (1 - cos kappa h) / (2 + cos kappa h), so the
// error in time is seen alone.
TEST(FullyDiscrete, IsSecondOrderInTimeFromASecondOrderStartAndFirstFromThePapers) {
  for (const double viscosity : {0.0, 0.05, 1.0}) {
    const exact::DampedMode mode{{1.0, 1.0, 1.0, viscosity}, {1.0, true, false, 0}, 0.5};
    const Mesh mesh{1.0, 10};
    const BarSystem system(mode.scene(), mesh, Mass::consistent);
    const double h = mesh.spacing(), c = std::cos(mode.shape.kappa() * h);
    const auto [u, v] = exact::damped_amplitude(mode.bar, 6 / (h * h) * (1 - c) / (2 + c), mode.speed, 1.0);
    const auto error = [&, exact_u = u, exact_v = v](double dt, Start start) {
      const auto run = record(system, std::vector<double>{0.0, 1.0}, FullyDiscrete{dt, start});
      const double shape = mode.shape(1.0);
      return std::hypot(run.u.back().back() - exact_u * shape, run.v.back().back() - exact_v * shape);
    };
    for (const Start start : {Start::first_order, Start::second_order}) {
      const double order = std::log2(error(1.0 / 400, start) / error(1.0 / 800, start));
      EXPECT_NEAR(order, start == Start::first_order ? 1.0 : 2.0, 0.1) << viscosity;
    }
  }
}

TEST(FullyDiscrete, TakesHugeStepsFromASecondOrderStartWithoutExciting) {
  const exact::DampedMode mode{{1.0, 1.0, 1.0, 1.0}, {1.0, false, false, 0}, 0.0};
  const BarSystem system(mode.scene(), {1.0, 1000}, Mass::consistent);
  const auto run = record(system, uniform_times(0.5, 40), FullyDiscrete{0.5, Start::second_order});
  for (const auto& u : run.u)
    for (const double value : u) EXPECT_LE(std::abs(value), 1.0 + 1e3 * eps);
}

TEST(FullyDiscrete, CarriesARigidMotionExactly) {
  Scene scene;
  scene.bar = {3.0, 2.0, 7.0, 0.4};
  scene.displacement = [](double) { return 0.3; };
  scene.velocity = [](double) { return -0.7; };
  for (const Mass mass : {Mass::consistent, Mass::lumped, Mass::paper}) {
    const BarSystem system(scene, {3.0, 50}, mass);
    const auto run = record(system, uniform_times(1.0, 10), FullyDiscrete{1e-3});
    for (std::size_t k = 0; k < run.times.size(); ++k)
      for (std::size_t j = 0; j < run.u[k].size(); ++j) {
        EXPECT_EQ(run.v[k][j], -0.7);
        EXPECT_NEAR(run.u[k][j], 0.3 - 0.7 * run.times[k], 1e4 * eps * 7.0);  // one rounding of |u| <= 7 a step
      }
  }
}

TEST(FullyDiscrete, KeepsAnEquilibriumBetweenFixedEndsThatAreApartAndReportsTheirTraction) {
  Scene scene;
  scene.bar = {2.0, 1.0, 3.0, 0.5};
  scene.left = scene.right = Fixed{};
  scene.displacement = [](double x) { return 0.25 * x - 1.0; };
  scene.velocity = [](double) { return 0.0; };
  for (const std::size_t elements : {2u, 3u, 16u}) {
    const BarSystem system(scene, {2.0, elements}, Mass::consistent);
    const auto run = record(system, uniform_times(0.3, 10), FullyDiscrete{0.01, Start::second_order});
    const double rounding = 100 * eps * 3.0 * static_cast<double>(elements);
    for (std::size_t k = 0; k < run.times.size(); ++k) {
      EXPECT_EQ(run.u[k].front(), -1.0);
      EXPECT_EQ(run.u[k].back(), -0.5);
      EXPECT_NEAR(run.reaction_left[k], -0.75, rounding);
      EXPECT_NEAR(run.reaction_right[k], 0.75, rounding);
    }
  }
}

TEST(FullyDiscrete, OutputTimesDoNotChangeTheTrajectoryAndAreInterpolatedLinearly) {
  exact::DampedMode mode{{1.0, 1.0, 1.0, 0.1}, {1.0, false, true, 0}, 0.3};
  const BarSystem system(mode.scene(), {1.0, 12}, Mass::consistent);
  const double dt = 0.0625;  // exact in binary
  const auto steps = record(system, uniform_times(dt, 17), FullyDiscrete{dt});
  const auto between =
      record(system, std::vector<double>{0.0, 0.25 * dt, 3.5 * dt, 3.75 * dt, 4 * dt, 16.5 * dt}, FullyDiscrete{dt});
  EXPECT_EQ(between.statistics.steps, 17u);
  EXPECT_EQ(between.times.back(), 16.5 * dt);
  for (std::size_t k = 0; k < between.times.size(); ++k) {
    const double at = between.times[k] / dt;
    const auto n = static_cast<std::size_t>(std::min(at, 16.0));
    const double theta = at - static_cast<double>(n);
    for (std::size_t j = 0; j < 13; ++j) {
      EXPECT_NEAR(between.u[k][j], (1 - theta) * steps.u[n][j] + theta * steps.u[n + 1][j], 10 * eps);
      EXPECT_NEAR(between.v[k][j], (1 - theta) * steps.v[n][j] + theta * steps.v[n + 1][j], 10 * eps / dt);
    }
  }
}

TEST(FullyDiscrete, StartsFromTheInitialDataAtAnyInitialTime) {
  exact::DampedMode mode{{1.0, 1.0, 1.0, 0.1}, {1.0, false, false, 0}, 0.3};
  const BarSystem system(mode.scene(), {1.0, 12}, Mass::consistent);
  const auto early = record(system, uniform_times(0.125, 8), FullyDiscrete{0.0625});
  const auto late = record(system, uniform_times(0.125, 8, 32.0), FullyDiscrete{0.0625});
  EXPECT_EQ(early.u.front(), system.initial_state().u);
  EXPECT_EQ(early.v.front(), system.initial_state().v);
  EXPECT_EQ(early.u, late.u);
  EXPECT_EQ(late.times.front(), 32.0);
  EXPECT_EQ(late.statistics.reached_time, 33.0);
}

TEST(FullyDiscrete, CountsWhatItDoesAndDoesOnlyWhatTheSceneNeeds) {
  exact::DampedMode mode{{1.0, 1.0, 1.0, 0.1}, {1.0, false, false, 0}, 0.3};
  const auto plain =
      record(BarSystem(mode.scene(), {1.0, 12}, Mass::consistent), uniform_times(0.5, 4), FullyDiscrete{0.125});
  const Statistics& s = plain.statistics;
  EXPECT_EQ(s.unknowns, 13u);
  EXPECT_EQ(s.steps, 16u);
  EXPECT_EQ(s.rhs_evaluations, 16u);
  EXPECT_EQ(s.linear_solves, 16u);
  EXPECT_EQ(s.matrix_factorisations, 1u);
  EXPECT_EQ(s.load_evaluations, 0u);
  EXPECT_EQ(s.event_evaluations, 0u);
  EXPECT_EQ(s.events, 0u);
  EXPECT_TRUE(s.completed);
  EXPECT_EQ(plain.progress.size(), 16u);
  EXPECT_EQ(plain.progress.back(), 2.0);

  Scene scene = mode.scene();
  scene.left = Obstacle{100.0};
  int calls = 0;
  scene.load = SeparableLoad{[](double) { return 1.0; }, [&](double) { return ++calls, 0.0; }};
  const auto full = record(BarSystem(scene, {1.0, 12}, Mass::consistent), uniform_times(0.5, 4), FullyDiscrete{0.125});
  EXPECT_EQ(full.statistics.linear_solves, 17u);  // one for the column of the end
  EXPECT_EQ(full.statistics.matrix_factorisations, 1u);
  EXPECT_EQ(full.statistics.event_evaluations, 15u);  // the last step's contact is beyond the end
  EXPECT_EQ(full.statistics.load_evaluations, 16u);
  EXPECT_EQ(calls, 16);
}

TEST(FullyDiscrete, DoesNotCountTheTimeOfObservers) {
  exact::DampedMode mode{{1.0, 1.0, 1.0, 0.1}, {1.0, false, false, 0}, 0.3};
  const BarSystem system(mode.scene(), {1.0, 12}, Mass::consistent);
  Observers slow;
  double spent = 0.0;
  slow.snapshot = [&](const Snapshot&) {
    const auto begin = std::chrono::steady_clock::now();
    while (std::chrono::steady_clock::now() - begin < std::chrono::milliseconds(5)) continue;
    spent += 5e-3;
  };
  const auto statistics = integrate(system, system.initial_state(), uniform_times(0.5, 4), FullyDiscrete{0.125}, slow);
  EXPECT_LT(statistics.integration_seconds, spent / 2);
}

TEST(FullyDiscrete, KeepsWhatItReachedWhenTheLoadFails) {
  Scene scene = exact::DampedMode{{1.0, 1.0, 1.0, 0.1}, {1.0, false, false, 0}, 0.3}.scene();
  scene.load = GeneralLoad{[](double, double t) { return std::sqrt(1.0 - t); }};
  const BarSystem system(scene, {1.0, 12}, Mass::consistent);
  std::vector<double> seen;
  Observers observers;
  observers.snapshot = [&](const Snapshot& now) { seen.push_back(now.time); };
  observers.energy = true;
  try {
    integrate(system, system.initial_state(), uniform_times(0.25, 8), FullyDiscrete{0.125}, observers);
    FAIL() << "no exception";
  } catch (const IntegrationError& error) {
    EXPECT_EQ(error.statistics.steps, 8u);
    EXPECT_EQ(error.statistics.reached_time, 1.0);
    EXPECT_FALSE(error.statistics.completed);
    const EnergyAccount& energy = *error.statistics.energy;
    EXPECT_NEAR(energy.balance_error(), 0.0, 1e3 * eps * (energy.initial + std::abs(energy.work)));
    EXPECT_NE(std::string(error.what()).find("scheme (2.8) at t = 1.125"), std::string::npos) << error.what();
  }
  EXPECT_EQ(seen.back(), 1.0);
}

TEST(FullyDiscrete, StopsWhenTheSolutionIsNoLongerFinite) {
  Scene scene;
  scene.displacement = scene.velocity = [](double) { return 0.0; };
  scene.load = SteadyLoad{[](double x) { return 1 / x; }};
  for (const bool span : {false, true}) {
    if (span) scene.span = Obstacle{1.0};
    const BarSystem system(scene, {1.0, 12}, Mass::consistent);
    EXPECT_THROW(record(system, uniform_times(0.25, 8), FullyDiscrete{0.125}), IntegrationError);
  }
}

TEST(FullyDiscrete, RefusesArgumentsThatMakeNoSense) {
  const BarSystem system(exact::PeriodThree::scene(), {1.0, 12}, Mass::consistent);
  const std::vector<double> times{0.0, 1.0}, one{0.0}, back{1.0, 0.0};
  for (const double step : {0.0, -1.0, std::nan(""), std::numeric_limits<double>::infinity(), 1e-200})
    EXPECT_THROW(record(system, times, FullyDiscrete{step}), std::invalid_argument) << step;
  for (const double e : {-0.1, 1.1, std::nan("")})
    EXPECT_THROW(record(system, times, FullyDiscrete{0.1, Start::first_order, e}), std::invalid_argument) << e;
  EXPECT_THROW(record(system, one, FullyDiscrete{0.1}), std::invalid_argument);
  EXPECT_THROW(record(system, back, FullyDiscrete{0.1}), std::invalid_argument);
  EXPECT_THROW(integrate(system, State{}, times, FullyDiscrete{0.1}, {}), std::invalid_argument);
}

}  // namespace
}  // namespace viscobar::testing_fully_discrete

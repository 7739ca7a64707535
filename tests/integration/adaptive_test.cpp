// Claims on every adaptive method. Agreement with the reference is in agreement_test.cpp.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <type_traits>
#include <vector>

#include "support/falling_bar.hpp"
#include "support/run_trace.hpp"
#include "viscobar/integration/integrate.hpp"

namespace viscobar::testing_adaptive {
namespace {

constexpr double constant = 100.0;  // the multiple of the requested tolerance that errors stay below (docs/methods.md)

template <class Method>
RunTrace record(const Scene& scene, const Mesh& mesh, Mass mass, const Method& method,
                const std::vector<double>& times) {
  return record(BarSystem(scene, mesh, mass), times, method);
}

template <class Method>
struct Adaptive : testing::Test {};
template <Stepper chosen>
struct OdeintBy : Odeint {
  OdeintBy(const Penalty& given = {}, const Tolerance& wanted = {}) : Odeint{given, wanted, chosen} {}
};
using Methods = testing::Types<Cvode, Ida, Arkode, OdeintBy<Stepper::dopri5>, OdeintBy<Stepper::rosenbrock4>>;
TYPED_TEST_SUITE(Adaptive, Methods);

TYPED_TEST(Adaptive, RigidFlightMeetsTheObstacleAtGapOverSpeed) {
  for (const double viscosity : {0.0, 0.1, 10.0}) {
    for (const double gap : {0.3, 1e-3, 7.0}) {
      const double speed = 0.7, time = gap / speed;
      const auto run = record(falling_bar(gap, speed, viscosity), Mesh{1.0, 9}, Mass::consistent,
                              TypeParam{Penalty{1e-3}, {}}, grid(1.5 * time, 3));
      ASSERT_FALSE(run.events.empty());
      // No strain, no error: a few roundings a step remain, of some hundred steps, of more where stability asks for
      // them.
      const double rounding = 2.3e-16 * std::max(1000.0, static_cast<double>(run.statistics.steps));
      EXPECT_NEAR(run.events[0].time, time, rounding * time) << viscosity << ", " << gap;
      EXPECT_NEAR(run.events[0].velocity, -speed, rounding) << viscosity << ", " << gap;
      EXPECT_EQ(run.events[0].change, Change::closing);
      EXPECT_EQ(run.events[0].where, Where::left);
    }
  }
}

TYPED_TEST(Adaptive, FollowsADampedMode) {
  // Free bar, P1 and consistent mass: cos(pi x) is an eigenvector at the nodes with
  // omega^2 = (6 / h^2) (1 - cos(pi h)) / (2 + cos(pi h)), and u'' + alpha omega^2 u' + omega^2 u = 0.
  const double alpha = 0.05;
  const Mesh mesh{1.0, 16};
  Scene scene;
  scene.bar = {1.0, 1.0, 1.0, alpha};
  scene.displacement = [](double x) { return std::cos(std::numbers::pi * x); };
  scene.velocity = [](double) { return 0.0; };
  const double h = mesh.spacing(), c = std::cos(std::numbers::pi * h);
  const double square = 6 / (h * h) * (1 - c) / (2 + c);
  const double decay = alpha * square / 2, frequency = std::sqrt(square - decay * decay);
  for (const double tolerance : {1e-6, 1e-8, 1e-10}) {
    const auto run = record(scene, mesh, Mass::consistent, TypeParam{{}, {tolerance, tolerance * 1e-3}}, grid(5.0, 20));
    for (std::size_t k = 0; k < run.times.size(); ++k) {
      const double t = run.times[k];
      const double amplitude =
          std::exp(-decay * t) * (std::cos(frequency * t) + decay / frequency * std::sin(frequency * t));
      EXPECT_NEAR(run.u[k][0], amplitude, constant * tolerance) << "t = " << t;
    }
  }
}

TYPED_TEST(Adaptive, WithoutObstacleNothingIsSearchedAndWithoutLoadNothingIsEvaluated) {
  Scene scene = falling_bar(1.0, 1.0, 0.1);
  scene.left = Free{};
  const auto run = record(scene, Mesh{1.0, 5}, Mass::lumped, TypeParam{}, grid(1.0, 2));
  EXPECT_EQ(run.statistics.event_evaluations, 0u);
  EXPECT_EQ(run.statistics.load_evaluations, 0u);
  EXPECT_EQ(run.statistics.events, 0u);
}

TYPED_TEST(Adaptive, OutputTimesLeaveTheTrajectoryUnchangedBitwise) {
  const Scene scene = falling_bar(0.2, 1.0, 0.02);
  const Mesh mesh{1.0, 12};
  const TypeParam method{Penalty{1e-4}, {}};
  const auto coarse = record(scene, mesh, Mass::consistent, method, grid(3.0, 2));
  const auto fine = record(scene, mesh, Mass::consistent, method, grid(3.0, 200));
  EXPECT_EQ(coarse.u.back(), fine.u.back());
  EXPECT_EQ(coarse.v.back(), fine.v.back());
  EXPECT_EQ(coarse.u[1], fine.u[100]);
  ASSERT_EQ(coarse.events.size(), fine.events.size());
  for (std::size_t i = 0; i < coarse.events.size(); ++i) EXPECT_EQ(coarse.events[i].time, fine.events[i].time);
}

TYPED_TEST(Adaptive, ElasticImpactLastsTwoTransitTimes) {
  // alpha = 0: d = V eps (1 - exp(-t/eps)) until the wave is back from the free end at 2 L / c, then
  // d = V eps (2 exp(-(t - 2)/eps) - 1): contact for 2 L / c + eps ln 2, with reaction E V / c meanwhile. epsilon is
  // chosen well above h / E, where the end node does not bounce by itself; the mesh smears the front over (h^2
  // t)^(1/3).
  const double speed = 0.5, epsilon = 0.02;
  const Scene scene = falling_bar(0.1, speed, 0.0);
  const Mesh mesh{1.0, 400};
  const auto run = record(scene, mesh, Mass::lumped, TypeParam{Penalty{epsilon}, {}}, grid(3.0, 60));
  ASSERT_GE(run.events.size(), 2u);
  EXPECT_NEAR(run.events[0].time, 0.2, 1e-12);
  const double front = std::cbrt(mesh.spacing() * mesh.spacing() * 2.0);
  EXPECT_NEAR(run.events[1].time - run.events[0].time, 2.0 + epsilon * std::numbers::ln2, front);
  for (std::size_t k = 0; k < run.times.size(); ++k) {
    // Ten epsilon after the impact and until the wave is back; the mesh resolves the front of width epsilon to O(h^2).
    if (run.times[k] < 0.2 + 10 * epsilon || run.times[k] > 2.1) continue;
    const double resolution = mesh.spacing() / epsilon;
    EXPECT_NEAR(run.reaction_left[k], speed, speed * resolution * resolution) << run.times[k];
  }
}

TYPED_TEST(Adaptive, EnergyBalancesWithinTheTolerance) {
  for (const double viscosity : {0.0, 0.01, 1.0}) {
    for (const bool loaded : {false, true}) {
      for (const double tolerance : {1e-6, 1e-8}) {
        Scene scene = falling_bar(0.2, 1.0, viscosity);
        scene.right = Obstacle{0.3};
        if (loaded)
          scene.load = SeparableLoad{[](double x) { return std::cos(2 * x); }, [](double t) { return std::sin(t); }};
        const auto run = record(scene, Mesh{1.0, 10}, Mass::consistent,
                                TypeParam{Penalty{1e-4}, {tolerance, tolerance * 1e-3}}, grid(3.0, 2));
        ASSERT_TRUE(run.statistics.energy.has_value());
        const EnergyAccount& energy = *run.statistics.energy;
        // Energy is quadratic: relative errors of displacement and velocity count twice.
        EXPECT_LE(std::abs(energy.balance_error()), 2 * constant * tolerance * (energy.initial + std::abs(energy.work)))
            << viscosity << (loaded ? ", loaded" : "") << ", " << tolerance;
        EXPECT_EQ(energy.dissipated > 0.0, viscosity > 0.0);
      }
    }
  }
}

TYPED_TEST(Adaptive, MirroredScenesGiveMirroredRuns) {
  Scene scene = falling_bar(0.2, 1.0, 0.03);
  scene.displacement = [](double x) { return 0.1 * x * x; };
  Scene mirrored = scene;
  std::swap(mirrored.left, mirrored.right);
  mirrored.displacement = [](double x) { return 0.1 * (1 - x) * (1 - x); };
  const TypeParam method{Penalty{1e-3}, {1e-9, 1e-12}};
  const auto run = record(scene, Mesh{1.0, 10}, Mass::consistent, method, grid(2.0, 8));
  const auto image = record(mirrored, Mesh{1.0, 10}, Mass::consistent, method, grid(2.0, 8));
  ASSERT_EQ(run.events.size(), image.events.size());
  for (std::size_t k = 0; k < run.u.size(); ++k)
    for (std::size_t j = 0; j < run.u[k].size(); ++j)
      EXPECT_NEAR(run.u[k][j], image.u[k][run.u[k].size() - 1 - j], constant * 1e-9);
}

TYPED_TEST(Adaptive, FlatBarHitsASpanObstacleEverywhereAtOnceAndRebounds) {
  Scene scene = falling_bar(0.0, 1.0, 0.0);
  scene.left = Free{};
  scene.span = Obstacle{0.5};
  const auto run = record(scene, Mesh{1.0, 8}, Mass::lumped, TypeParam{Penalty{1e-4}, {1e-8, 1e-11}}, grid(1.0, 4));
  ASSERT_EQ(run.events.size(), 2 * 9u);
  for (std::size_t i = 0; i < 9; ++i) EXPECT_NEAR(run.events[i].time, 0.5, 1e-12);
  // Lumped mass and trapezoidal springs: every node bounces alike, for pi sqrt(epsilon rho), and leaves at +V.
  for (std::size_t i = 9; i < 18; ++i) EXPECT_NEAR(run.events[i].time, 0.5 + std::numbers::pi * 1e-2, constant * 1e-8);
  for (double v : run.v.back()) EXPECT_NEAR(v, 1.0, constant * 1e-8);
}

TYPED_TEST(Adaptive, RestitutionIsThatOfTheDashpot) {
  // One falling node pair: a two-node bar so stiff that it moves as one body would still deform; a single unknown does
  // not. Right end fixed far away is not free flight either. So: the flat bar on a span obstacle, every node alike.
  for (const double restitution : {0.25, 0.5, 1.0}) {
    Scene scene = falling_bar(0.0, 1.0, 0.0);
    scene.left = Free{};
    scene.span = Obstacle{0.5};
    const auto run =
        record(scene, Mesh{1.0, 6}, Mass::lumped, TypeParam{Penalty{1e-4, restitution}, {1e-8, 1e-11}}, grid(1.0, 4));
    for (double v : run.v.back()) EXPECT_NEAR(v, restitution, constant * 1e-8) << restitution;
  }
}

TYPED_TEST(Adaptive, ALoadThatIsNotFiniteStopsTheRunAndSaysWhen) {
  Scene scene = falling_bar(0.2, 1.0, 0.1);
  scene.load = SeparableLoad{[](double) { return 1.0; }, [](double t) { return std::sqrt(0.5 - t); }};
  try {
    record(scene, Mesh{1.0, 6}, Mass::consistent, TypeParam{Penalty{1e-4}, {}}, grid(1.0, 4));
    FAIL() << "ran through";
  } catch (const IntegrationError& error) {
    EXPECT_FALSE(error.statistics.completed);
    EXPECT_GT(error.statistics.reached_time, 0.1);
    EXPECT_LE(error.statistics.reached_time, 0.5);
    EXPECT_NE(std::string(error.what()).find("history of the load"), std::string::npos) << error.what();
  }
}

TYPED_TEST(Adaptive, AnObserversExceptionComesThrough) {
  const BarSystem system(falling_bar(0.2, 1.0, 0.1), Mesh{1.0, 6}, Mass::consistent);
  Observers observers;
  observers.snapshot = [](const Snapshot& s) {
    if (s.time > 0.4) throw std::runtime_error("disk full");
  };
  EXPECT_THROW(integrate(system, system.initial_state(), grid(1.0, 10), TypeParam{Penalty{1e-4}, {}}, observers),
               std::runtime_error);
}

TYPED_TEST(Adaptive, OneUnknownIsEnough) {
  // One element, right end fixed: u'' rho h/3 + E/h u = 0 with the consistent mass.
  Scene scene;
  scene.bar = {1.0, 1.0, 1.0, 0.0};
  scene.right = Fixed{};
  scene.displacement = [](double x) { return 1 - x; };
  scene.velocity = [](double) { return 0.0; };
  const auto run = record(scene, Mesh{1.0, 1}, Mass::consistent, TypeParam{{}, {1e-9, 1e-12}}, grid(4.0, 8));
  for (std::size_t k = 0; k < run.times.size(); ++k)
    EXPECT_NEAR(run.u[k][0], std::cos(std::sqrt(3.0) * run.times[k]), constant * 1e-9);
}

TYPED_TEST(Adaptive, StartsFromRestUnderALoadThatGrowsFromZero) {
  // u'' = 0 at the start as well: nothing there tells an integrator how long its first step may be.
  Scene scene = falling_bar(10.0, 0.0, 0.5);
  scene.load = SeparableLoad{[](double) { return 1.0; }, [](double t) { return 1e3 * t; }};
  for (const double relative : {1e-8, 1e-10, 1e-12}) {
    TypeParam method;
    method.penalty = {1e-4, 1.0};
    method.tolerance = {relative, 1e-2 * relative};
    const auto run = record(scene, {1.0, 10}, Mass::consistent, method, grid(0.3, 3));
    // Uniform under a uniform load: rho u'' = 1e3 t.
    const double exact = 1e3 * 0.3 * 0.3 * 0.3 / 6;
    for (const double u : run.u.back()) EXPECT_NEAR(u, exact, constant * relative * exact) << relative;
  }
}

TYPED_TEST(Adaptive, HundredThousandElementsRun) {
  if (std::is_same_v<TypeParam, OdeintBy<Stepper::dopri5>>) GTEST_SKIP() << "it is explicit";
  // The impact of a long bar does not know how finely it is cut: steps and penetration are those of a coarser mesh.
  Scene scene = falling_bar(0.1, 0.5, 1.0);
  const TypeParam method{Penalty{1e-4}, {1e-5, 1e-8}};
  const auto coarse = record(scene, Mesh{1.0, 1000}, Mass::consistent, method, grid(0.25, 1));
  const auto fine = record(scene, Mesh{1.0, 100000}, Mass::consistent, method, grid(0.25, 1));
  ASSERT_EQ(fine.events.size(), coarse.events.size());
  EXPECT_LT(fine.statistics.steps, 2 * coarse.statistics.steps);
  // The coarse mesh resolves the contact layer, (epsilon sqrt(alpha))^(2/3) = 2e-3 thick in time, to O(h).
  EXPECT_NEAR(fine.statistics.max_penetration, coarse.statistics.max_penetration,
              0.02 * coarse.statistics.max_penetration);
}

TEST(Cvode, RefusesMasslessNodesWithoutViscosity) {
  const BarSystem system(falling_bar(0.2, 1.0, 0.0), Mesh{1.0, 6}, Mass::redistributed);
  EXPECT_THROW(integrate(system, system.initial_state(), grid(1.0, 2), Cvode{}, {}), std::invalid_argument);
}

template <class Method>
struct Algebraic : testing::Test {};
using TakingAlgebraicRows = testing::Types<Ida, Arkode>;
TYPED_TEST_SUITE(Algebraic, TakingAlgebraicRows);

TYPED_TEST(Algebraic, RedistributedMassHasNoBounceAtAnyPenalty) {
  for (const double epsilon : {1e-2, 1e-5, 1e-8, 1e-11}) {
    const auto run = record(falling_bar(0.2, 1.0, 0.0), Mesh{1.0, 30}, Mass::redistributed,
                            TypeParam{Penalty{epsilon}, {}}, grid(2.0, 2));
    EXPECT_EQ(run.events.size(), 1u) << epsilon;
  }
}

template <class Method>
struct Stiff : testing::Test {};
using MadeForStiffness = testing::Types<Cvode, Arkode>;
TYPED_TEST_SUITE(Stiff, MadeForStiffness);

TYPED_TEST(Stiff, StepsDoNotGrowAsThePenaltyStiffensOnRedistributedMass) {
  std::vector<std::size_t> steps;
  for (const double epsilon : {1e-3, 1e-5, 1e-8}) {
    Scene scene = falling_bar(0.1, 0.5, 0.1);
    scene.right = Obstacle{0.1};
    const auto run = record(scene, Mesh{1.0, 27}, Mass::redistributed, TypeParam{Penalty{epsilon}, {}}, grid(4.0, 2));
    steps.push_back(run.statistics.steps);
  }
  EXPECT_LT(*std::max_element(steps.begin(), steps.end()), 2 * *std::min_element(steps.begin(), steps.end()));
}

}  // namespace
}  // namespace viscobar::testing_adaptive

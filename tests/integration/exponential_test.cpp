// The exponential method is the reference of the other methods: everything here is held to rounding.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "support/exponential_runs.hpp"
#include "support/fine_step_oracle.hpp"
#include "support/maximum_norm.hpp"
#include "support/modal_solution.hpp"
#include "support/paper_throw.hpp"
#include "viscobar/dynamics/load_vector.hpp"

namespace viscobar::testing_exponential {
namespace {

using namespace testing_support;

Scene smooth_scene(double viscosity) {
  Scene scene;
  scene.bar = {1.3, 1.7, 2.1, viscosity};
  scene.displacement = [](double x) { return 0.4 + x * (1 - x) + 0.1 * std::sin(9 * x); };
  scene.velocity = [](double x) { return std::cos(3 * x); };
  return scene;
}

// Section 6 of docs/model.md.
Scene chatter_scene(double viscosity) { return paper_throw(viscosity).scene; }

TEST(Exponential, FollowsEveryModeOfEveryBarWithoutContact) {
  const EndCondition ends[][2] = {{Free{}, Free{}}, {Fixed{}, Free{}}, {Free{}, Fixed{}}, {Fixed{}, Fixed{}}};
  for (const auto& [left, right] : ends)
    for (const Mass mass : {Mass::consistent, Mass::lumped, Mass::paper})
      for (const double viscosity : {0.0, 0.02, 3.0})
        for (const int loaded : {0, 1, 2}) {
          Scene scene = smooth_scene(viscosity);
          scene.left = left;
          scene.right = right;
          const auto profile = [](double x) { return std::cos(2 * x); };
          const double frequency = std::numbers::sqrt2;
          if (loaded == 1) scene.load = SeparableLoad{profile, [=](double t) { return std::sin(frequency * t); }};
          if (loaded == 2)
            scene.load = GeneralLoad{[=](double x, double t) { return profile(x) * std::sin(frequency * t); }};
          const Mesh mesh{1.3, 24};
          const BarSystem system(scene, mesh, mass);

          const auto n = static_cast<Eigen::Index>(system.size());
          ModalSolution::Vector rest = ModalSolution::Vector::Zero(n), load = rest;
          const long double a = scene.displacement(0.0), b = scene.displacement(1.3);
          for (Eigen::Index i = 0; i < n; ++i) {
            const long double x = mesh.node(static_cast<std::size_t>(i) + system.unknowns().first_node()) / 1.3L;
            if (is_fixed(left))
              rest[i] = is_fixed(right) ? a + (b - a) * x : a;
            else if (is_fixed(right))
              rest[i] = b;
          }
          if (loaded > 0) {
            Scene steady = scene;
            steady.load = SteadyLoad{profile};
            const BarSystem still(steady, mesh, mass);
            load = Eigen::Map<const Eigen::VectorXd>(LoadVector(still).at(0.0).data(), n).cast<long double>();
          }
          const ModalSolution exact(system, rest, load, frequency);
          const auto run = record(system, grid(6.0, 7));
          for (std::size_t k = 0; k < run.times.size(); ++k) {
            const auto expected = exact.displacement(run.times[k]);
            for (Eigen::Index i = 0; i < n; ++i)
              ASSERT_NEAR(run.u[k][static_cast<std::size_t>(i) + system.unknowns().first_node()],
                          static_cast<double>(expected[i]),
                          6 * accuracy)  // free bars fly to u = 6
                  << name(mass) << ", viscosity " << viscosity << ", load " << loaded << ", t = " << run.times[k];
          }
        }
}

TEST(Exponential, RigidFlightMeetsTheObstacleAtGapOverSpeed) {
  for (const double viscosity : {0.0, 0.1, 10.0})
    for (const Mass mass : {Mass::consistent, Mass::lumped, Mass::redistributed, Mass::fourth_order})
      for (const double gap : {0.3, 1e-3, 7.0}) {
        const double speed = 0.7, time = gap / speed;
        const auto run = record(BarSystem(falling_bar(gap, speed, viscosity), Mesh{1.0, 9}, mass), {0.0, 1.2 * time});
        ASSERT_FALSE(run.events.empty());
        // A few dozen doubled steps of a few roundings each.
        EXPECT_NEAR(run.events[0].time, time, 100 * 1.2e-16 * time) << viscosity << ", " << gap;
        // The matrices take a displacement to a velocity with the largest frequency, at most 2 sqrt(3) / h.
        EXPECT_NEAR(run.events[0].velocity, -speed, 100 * 1.2e-16 * (speed + gap * 2 * std::sqrt(3.0) * 9));
        EXPECT_EQ(run.events[0].change, Change::closing);
        EXPECT_EQ(run.events[0].where, Where::left);
      }
}

struct Impact {
  double viscosity;
  Mass mass;
  double restitution;
  bool span;
  bool loaded;
};

TEST(Exponential, AgreesWithAFineStepRungeKuttaMethodThroughContactChanges) {
  if (!FineStepOracle::is_extended()) GTEST_SKIP() << "125000 steps of the oracle need more digits than a double has";
  const Impact impacts[] = {{0.0, Mass::consistent, 1.0, false, false},    {0.05, Mass::consistent, 1.0, false, true},
                            {0.02, Mass::lumped, 0.0, false, false},       {0.0, Mass::redistributed, 1.0, false, true},
                            {0.1, Mass::redistributed, 1.0, false, false}, {0.1, Mass::redistributed, 1.0, false, true},
                            {0.03, Mass::consistent, 0.4, true, false},    {0.0, Mass::lumped, 1.0, true, true}};
  for (const Impact& impact : impacts) {
    SCOPED_TRACE(testing::Message() << "viscosity " << impact.viscosity << ", " << name(impact.mass) << ", restitution "
                                    << impact.restitution << (impact.span ? ", span" : "")
                                    << (impact.loaded ? ", loaded" : ""));
    Scene scene = chatter_scene(impact.viscosity);
    scene.velocity = [](double x) { return -0.3 - x; };
    if (impact.span) scene.left = scene.right = Free{}, scene.span = Obstacle{0.1};
    if (impact.loaded)
      scene.load = SeparableLoad{[](double x) { return -1 - x; }, [](double t) { return std::cos(2 * t); }};
    const Penalty penalty{1e-2, impact.restitution};
    const BarSystem system(scene, Mesh{1.0, 3}, impact.mass);
    // (rate h)^4 (rate T) / 120 with the fastest rate, 35 of an end node on its spring and 60 of damping, is below
    // 1e-13.
    FineStepOracle oracle(system, penalty, 1.6e-5L);
    const auto run = record(system, grid(2.0, 4), penalty);
    for (std::size_t k = 1; k < run.times.size(); ++k) {
      oracle.advance_to(run.times[k]);
      for (std::size_t i = 0; i < system.size(); ++i)
        EXPECT_NEAR(run.u[k][i], static_cast<double>(oracle.u[static_cast<Eigen::Index>(i)]), accuracy)
            << "t = " << run.times[k] << ", node " << i;
    }
    ASSERT_GE(run.events.size(), 2u);
    ASSERT_EQ(run.events.size(), oracle.changes.size());
    for (std::size_t k = 0; k < run.events.size(); ++k) {
      // The time of a crossing is its displacement's error over the speed.
      const double slack = accuracy / std::max(std::abs(run.events[k].velocity), 0.01);
      EXPECT_NEAR(run.events[k].time, static_cast<double>(oracle.changes[k].time), slack);
      EXPECT_EQ(run.events[k].node, system.contacts()[oracle.changes[k].contact].unknown);
      EXPECT_EQ(run.events[k].change == Change::closing, oracle.changes[k].closing);
    }
  }
}

TEST(Exponential, AMasslessNodeRelaxesWithTheRateOfTheMaterial) {
  // The stress of the end element vanishes at all times: u_0 - u_1 decays like exp(-E t / eta), and without viscosity
  // is zero at once. What is inside moves like a free bar of its own.
  for (const double viscosity : {0.0, 0.4}) {
    Scene scene = smooth_scene(viscosity);
    scene.left = Obstacle{100.0};
    const BarSystem system(scene, Mesh{1.3, 10}, Mass::redistributed);
    const auto run = record(system, grid(3.0, 6));
    const double difference = viscosity > 0.0 ? scene.displacement(0.0) - scene.displacement(0.13) : 0.0;
    for (std::size_t k = 0; k < run.times.size(); ++k) {
      const double decay = viscosity > 0.0 ? std::exp(-2.1 / viscosity * run.times[k]) : 0.0;
      EXPECT_NEAR(run.u[k][0] - run.u[k][1], difference * decay, accuracy);
      const double rate = viscosity > 0.0 ? -2.1 / viscosity * difference * decay : 0.0;
      EXPECT_NEAR(run.v[k][0] - run.v[k][1], rate, 10 * accuracy) << run.times[k];
    }
  }
}

// The node relaxes at h / (epsilon eta), 2e10, beside a motion of 1e-4 of a second: the maximum of its penetration has
// no more digits than the rounding of the spring's force leaves to its velocity.
TEST(Exponential, AMasslessNodeOnAStiffSpringIsNotFollowedAtTheRateOfItsDashpot) {
  Scene scene = falling_bar(0.0, 0.0, 4e-5);
  scene.left_input.force = EndForce{[](double) { return -1e-4; }, {}, true};
  const BarSystem system(scene, Mesh{1.0, 10}, Mass::redistributed);
  const auto run = record(system, grid(1.0, 5), Penalty{1e-7});
  EXPECT_LT(run.statistics.steps, 10'000u);
  for (const auto& u : run.u) EXPECT_NEAR(u.front(), 0.0, 1e-10);
}

TEST(Exponential, AMasslessNodeWithoutViscosityFollowsTheLoadAndItsRate) {
  // Open: E/h (u_1 - u_0) + p_0(t) = 0, and its derivative.
  Scene scene = smooth_scene(0.0);
  scene.left = Obstacle{100.0};
  scene.load = SeparableLoad{[](double) { return 2.0; }, [](double t) { return std::cos(5 * t); }};
  const Mesh mesh{1.3, 10};
  const double h = mesh.spacing();
  const auto run = record(BarSystem(scene, mesh, Mass::redistributed), grid(3.0, 6));
  for (std::size_t k = 0; k < run.times.size(); ++k) {
    const double compliance = h * 2.0 * h / 2 / 2.1;  // (h / E) times the weight h / 2 of the profile 2
    EXPECT_NEAR(run.u[k][0] - run.u[k][1], compliance * std::cos(5 * run.times[k]), accuracy);
    EXPECT_NEAR(run.v[k][0] - run.v[k][1], -5 * compliance * std::sin(5 * run.times[k]), 10 * accuracy);
  }
}

TEST(Exponential, AFlatBarOnASpanObstacleIsOneOscillatorWithTheRestitutionOfItsDashpot) {
  // Lumped mass and trapezoidal springs: d = V sqrt(eps rho) sin(t / sqrt(eps rho)) at every node.
  Scene scene = falling_bar(0.0, 1.0, 0.0);
  scene.left = Free{};
  scene.span = Obstacle{0.5};
  const BarSystem system(scene, Mesh{1.0, 8}, Mass::lumped);
  const auto run = record(system, grid(1.0, 4), Penalty{1e-4});
  ASSERT_EQ(run.events.size(), 2 * 9u);
  for (std::size_t i = 0; i < 18; ++i) {
    EXPECT_NEAR(run.events[i].time, 0.5 + (i < 9 ? 0.0 : std::numbers::pi * 1e-2), accuracy);
    EXPECT_EQ(run.events[i].where, Where::span);
  }
  EXPECT_NEAR(run.statistics.max_penetration, 1e-2, accuracy);
  for (const double restitution : {0.25, 0.5, 1.0}) {
    const auto bounce = record(system, {0.0, 1.0}, Penalty{1e-4, restitution});
    for (const double v : bounce.v.back()) EXPECT_NEAR(v, restitution, accuracy);
  }
}

TEST(Exponential, ReproducesTheChatterOfAStiffPenaltyAndItsAbsenceOnMasslessNodes) {
  const Scene scene = chatter_scene(0.01);
  const Mesh mesh{1.0, 27};
  const BarSystem massive(scene, mesh, Mass::consistent), massless(scene, mesh, Mass::redistributed);
  const std::pair<double, std::size_t> changes[] = {{1e-2, 4}, {1e-3, 12}, {1e-4, 56}, {1e-5, 352}, {1e-6, 456}};
  for (const auto& [epsilon, count] : changes)
    EXPECT_EQ(record(massive, {0.0, 6.0}, Penalty{epsilon}).events.size(), count) << epsilon;
  for (const double epsilon : {1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-8, 1e-10})
    EXPECT_EQ(record(massless, {0.0, 6.0}, Penalty{epsilon}).events.size(), 4u) << epsilon;
}

TEST(Exponential, TheMasslessLimitIsReachedLinearlyInThePenaltyDownToTinyPenetrations) {
  // u(eps) = u(0) + c eps: every decade closes nine tenths of what is left, with no floor from a contact that sticks.
  const BarSystem system(chatter_scene(0.01), Mesh{1.0, 27}, Mass::redistributed);
  const auto end = [&](double epsilon) { return record(system, {0.0, 6.0}, Penalty{epsilon}).u.back()[0]; };
  const double slope = (end(1e-6) - end(1e-7)) / 9e-7;
  EXPECT_NEAR((end(1e-8) - end(1e-10)) / 9.9e-9, slope, 1e-5 * std::abs(slope) + 2 * accuracy / 9.9e-9);
}

TEST(Exponential, EnergyIsKeptOverManyBouncesWithoutViscosity) {
  Scene scene = falling_bar(0.0, 0.0, 0.0);
  scene.right = Fixed{};
  scene.displacement = [](double x) { return (1 - x) / 2; };
  for (const Mass mass : {Mass::consistent, Mass::redistributed}) {
    const auto run = record(BarSystem(scene, Mesh{1.0, 27}, mass), {0.0, 40.0}, Penalty{1e-4}, true);
    const EnergyAccount& energy = *run.statistics.energy;
    EXPECT_GE(run.statistics.events, 2 * 13u);  // the bar comes back every 3 transit times
    EXPECT_EQ(energy.dissipated, 0.0);
    EXPECT_EQ(energy.work, 0.0);
    EXPECT_NEAR(energy.final, energy.initial, 1e-11 * energy.initial);
  }
}

TEST(Exponential, TheEnergyOfAContactHasTheDigitsOfItsPenetrationAsTheReactionHas) {
  const double epsilon = 1e-8;
  const BarSystem system(chatter_scene(0.01), Mesh{1.0, 27}, Mass::redistributed);
  Observers observers;
  observers.energy = true;
  std::size_t pressed = 0;
  observers.snapshot = [&](const Snapshot& now) {
    const double stored = epsilon / 2 * (std::pow(now.reaction_left, 2) + std::pow(now.reaction_right, 2));
    pressed += stored > 0.0;
    EXPECT_NEAR(now.energy->contact, stored, 1e-13 * stored) << now.time;
  };
  std::vector<double> times;
  for (int k = 0; k <= 600; ++k) times.push_back(0.01 * k);
  integrate(system, system.initial_state(), times, Exponential{{epsilon}}, observers);
  EXPECT_GT(pressed, 10u);
}

TEST(Exponential, EnergyBalancesWithViscosityDashpotsAndLoads) {
  const Load loads[] = {SteadyLoad{[](double x) { return -1 - x; }},
                        SeparableLoad{[](double x) { return std::cos(2 * x); }, [](double t) { return std::sin(t); }},
                        GeneralLoad{[](double x, double t) { return std::exp(-20 * (x - t / 3) * (x - t / 3)); }}};
  for (const double viscosity : {0.0, 0.01, 1.0})
    for (const Mass mass : {Mass::consistent, Mass::redistributed})
      for (const Load& load : loads) {
        Scene scene = chatter_scene(viscosity);
        scene.load = load;
        const auto run = record(BarSystem(scene, Mesh{1.0, 20}, mass), {0.0, 3.0}, Penalty{1e-3, 0.3}, true);
        const EnergyAccount& energy = *run.statistics.energy;
        EXPECT_LE(std::abs(energy.balance_error()), 1e-11 * (energy.initial + std::abs(energy.work)));
        EXPECT_EQ(energy.dissipated > 0.0, viscosity > 0.0 || (mass == Mass::consistent && run.statistics.events > 0));
      }
}

TEST(Exponential, ShorterStepsChangeNothing) {
  // The energy account asks for several times more steps.
  for (const Mass mass : {Mass::consistent, Mass::redistributed}) {
    const BarSystem system(chatter_scene(0.01), Mesh{1.0, 27}, mass);
    const auto run = record(system, grid(6.0, 4), Penalty{1e-4});
    const auto finer = record(system, grid(6.0, 4), Penalty{1e-4}, true);
    EXPECT_GT(finer.statistics.steps, 2 * run.statistics.steps);
    for (std::size_t k = 0; k < run.u.size(); ++k) EXPECT_LE(distance(run.u[k], finer.u[k]), accuracy);
    ASSERT_EQ(run.events.size(), finer.events.size());
    for (std::size_t k = 0; k < run.events.size(); ++k)
      EXPECT_NEAR(run.events[k].time, finer.events[k].time,
                  accuracy / std::max(std::abs(run.events[k].velocity), 1e-3));
  }
}

TEST(Exponential, OutputTimesLeaveTheTrajectoryUnchangedBitwise) {
  Scene scene = chatter_scene(0.02);
  scene.load = SeparableLoad{[](double x) { return x; }, [](double t) { return std::sin(7 * t); }};
  const BarSystem system(scene, Mesh{1.0, 12}, Mass::consistent);
  const auto coarse = record(system, grid(3.0, 2), Penalty{1e-4}), fine = record(system, grid(3.0, 200), Penalty{1e-4});
  EXPECT_EQ(coarse.u.back(), fine.u.back());
  EXPECT_EQ(coarse.v.back(), fine.v.back());
  EXPECT_EQ(coarse.u[1], fine.u[100]);
  ASSERT_EQ(coarse.events.size(), fine.events.size());
  for (std::size_t i = 0; i < coarse.events.size(); ++i) EXPECT_EQ(coarse.events[i].time, fine.events[i].time);
}

TEST(Exponential, MirroredScenesGiveMirroredRuns) {
  for (const Mass mass : {Mass::consistent, Mass::redistributed}) {
    Scene scene = chatter_scene(0.03);
    scene.right = Obstacle{0.02};
    scene.displacement = [](double x) { return 0.1 * x * x; };
    Scene mirrored = scene;
    std::swap(mirrored.left, mirrored.right);
    mirrored.displacement = [](double x) { return 0.1 * (1 - x) * (1 - x); };
    const auto run = record(BarSystem(scene, Mesh{1.0, 16}, mass), grid(2.0, 8), Penalty{1e-4});
    auto image = record(BarSystem(mirrored, Mesh{1.0, 16}, mass), grid(2.0, 8), Penalty{1e-4});
    ASSERT_GE(run.events.size(), 2u);
    ASSERT_EQ(run.events.size(), image.events.size());
    for (std::size_t k = 0; k < run.u.size(); ++k) {
      std::ranges::reverse(image.u[k]);
      EXPECT_LE(distance(run.u[k], image.u[k]), accuracy);
      // A force is a penetration over epsilon, and so is its error.
      EXPECT_NEAR(run.reaction_left[k], image.reaction_right[k], accuracy / 1e-4);
    }
  }
}

TEST(Exponential, AContactThatIsPressedAtTheStartClosesThere) {
  Scene scene = falling_bar(0.0, 0.0, 0.1);
  scene.load = SteadyLoad{[](double) { return -1.0; }};
  const auto run = record(BarSystem(scene, Mesh{1.0, 8}, Mass::consistent), {0.0, 40.0}, Penalty{1e-3});
  ASSERT_EQ(run.events.size(), 1u);
  EXPECT_EQ(run.events[0].time, 0.0);
  EXPECT_EQ(run.events[0].change, Change::closing);
  EXPECT_NEAR(run.reaction_left.back(), 1.0, 0.1);  // the weight, up to exp(-eta (pi/2)^2 T / 2) of the first mode
}

TEST(Exponential, CountsNothingThatTheSceneDoesNotHave) {
  Scene scene = falling_bar(1.0, 1.0, 0.1);
  scene.left = Free{};
  const auto run = record(BarSystem(scene, Mesh{1.0, 5}, Mass::lumped), grid(1.0, 2));
  EXPECT_EQ(run.statistics.unknowns, 12u);
  EXPECT_EQ(run.statistics.event_evaluations, 0u);
  EXPECT_EQ(run.statistics.load_evaluations, 0u);
  EXPECT_EQ(run.statistics.events, 0u);
  EXPECT_EQ(run.statistics.linear_solves, 0u);
  EXPECT_GT(run.statistics.matrix_factorisations, 0u);
  EXPECT_TRUE(run.statistics.completed);
  EXPECT_FALSE(run.statistics.energy.has_value());
}

TEST(Exponential, RefusesMeshesTooLargeForDenseMatricesAndRigidObstacles) {
  const BarSystem large(falling_bar(1.0, 1.0, 0.1), Mesh{1.0, 400}, Mass::lumped);
  EXPECT_THROW(record(large, {0.0, 1.0}), std::invalid_argument);
  const BarSystem rigid(falling_bar(1.0, 1.0, 0.1), Mesh{1.0, 8}, Mass::redistributed);
  EXPECT_THROW(record(rigid, {0.0, 1.0}, Penalty{0.0}), std::invalid_argument);
}

}  // namespace
}  // namespace viscobar::testing_exponential

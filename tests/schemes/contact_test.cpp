#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "support/exact_solutions.hpp"
#include "support/falling_bar.hpp"
#include "support/paper_throw.hpp"
#include "support/run_trace.hpp"
#include "viscobar/case/recording.hpp"
#include "viscobar/input/scene_file.hpp"
#include "viscobar/schemes/schemes.hpp"

namespace viscobar::testing_contact {
namespace {

constexpr double eps = std::numeric_limits<double>::epsilon();
constexpr Mass all_masses[] = {Mass::consistent, Mass::lumped, Mass::paper, Mass::redistributed, Mass::fourth_order};

RunTrace run_steps(const BarSystem& system, double dt, double end, FullyDiscrete scheme = {}) {
  scheme.step = dt;
  return record(system, uniform_times(dt, static_cast<std::size_t>(std::lround(end / dt))), scheme);
}

TEST(FullyDiscreteContact, RigidFlightMeetsTheObstacleWithinAStepAtTheSpeedOfFlight) {
  for (const double dt : {0.03, 0.007, 0.0011}) {
    const exact::ElasticImpact flight{{1.0, 2.0, 3.0, 0.4}, 0.7, 0.31};
    const auto run = run_steps(BarSystem(flight.scene(), {1.0, 20}, Mass::consistent), dt, 0.6);
    ASSERT_FALSE(run.events.empty());
    EXPECT_EQ(run.events[0].change, Change::closing);
    EXPECT_EQ(run.events[0].where, Where::left);
    EXPECT_GE(run.events[0].time, flight.closing());
    EXPECT_LE(run.events[0].time, flight.closing() + dt);
    EXPECT_EQ(run.events[0].velocity, -0.7);
  }
}

// As with every other method: at t = 0 with the speed of the data; apart by less than a step, where u^1 touches.
TEST(FullyDiscreteContact, ABarThatMovesInFromATouchClosesThereAndThen) {
  for (const Mass mass : all_masses)
    for (const double gap : {0.0, 0.004}) {
      Scene scene = falling_bar(gap, 1.0, 0.1);
      const auto run = run_steps(BarSystem(scene, {1.0, 20}, mass), 0.01, 2.5);
      ASSERT_GE(run.events.size(), 2u);
      EXPECT_EQ(run.events[0].change, Change::closing);
      EXPECT_EQ(run.events[0].time, gap > 0.0 ? 0.01 : 0.0) << gap;
      EXPECT_EQ(run.events[0].velocity, -1.0);
      const double h = 1.0 / 20;  // `paper` has a mass of h more
      EXPECT_NEAR(run.events[1].time, 1.9124710098 + gap, mass == Mass::paper ? 2.0 * h : h) << name(mass);
    }
}

TEST(FullyDiscreteContact, ContactsOfTheStartAreToldInTheOrderOfTime) {
  Scene scene;
  scene.bar.viscosity = 0.1;
  scene.left = Obstacle{0.004};
  scene.right = Obstacle{0.0, Side::above};
  scene.displacement = [](double) { return 0.0; };
  scene.velocity = [](double x) { return 2.0 * x - 1.0; };
  const auto run = run_steps(BarSystem(scene, {1.0, 20}, Mass::fourth_order), 0.01, 0.1);
  ASSERT_GE(run.events.size(), 2u);
  EXPECT_EQ(run.events[0].where, Where::right);
  EXPECT_EQ(run.events[0].time, 0.0);
  EXPECT_EQ(run.events[1].where, Where::left);
  EXPECT_EQ(run.events[1].time, 0.01);
}

// A rod of mass 1 with a mass M on its end touches at speed 1: E(0) = (1 + M) / 2, and the scheme stops M at once.
TEST(FullyDiscreteContact, WhatTheStartTakesAtATouchIsDissipatedAndNotForgotten) {
  for (const char* method : {"fully_discrete", "finite_difference"}) {
    const Case run = parse_scene(fmt::format("[bar]\nlength = 1\n[left]\nkind = \"obstacle\"\ngap = 0\nmass = 5\n"
                                             "[initial]\nvelocity = -1\n[time]\nend = 0.5\n[mesh]\nelements = 50\n"
                                             "[method]\nname = \"{}\"\n",
                                             method),
                                 "")
                         .run;
    Observers observers;
    observers.energy = true;
    const Statistics done = simulate(resolve(run), observers);
    EXPECT_NEAR(done.energy->initial, 3.0, 64.0 * 3.0 * eps) << method;
    // The mass, and of the rod what the node has of it: of an element a half at most.
    EXPECT_NEAR(done.energy->dissipated, 2.5, 0.5 / 50.0) << method;
    EXPECT_NEAR(done.energy->balance_error(), 0.0, 1e-12) << method;
  }
}

// A front that jumps in velocity is smeared by dispersion over t^(1/3) h^(2/3), which the displacement feels.
TEST(FullyDiscreteContact, AnElasticImpactLastsTwiceTheLengthOverTheWaveSpeed) {
  for (const Mass mass : {Mass::consistent, Mass::lumped, Mass::redistributed}) {
    const exact::ElasticImpact impact{{1.0, 2.0, 0.5, 0.0}, 0.8, 0.1};
    const double time_scale = 1.0 / impact.wave_speed();
    double before = 0.0;
    for (const std::size_t elements : {200u, 800u}) {
      const Mesh mesh{1.0, elements};
      const double dt = 0.5 * mesh.spacing() * time_scale, front = std::pow(mesh.spacing(), 2.0 / 3.0);
      const BarSystem system(impact.scene(), mesh, mass);
      const auto run = run_steps(system, dt, 6.0);
      ASSERT_EQ(run.events.size(), 2u) << name(mass);
      EXPECT_NEAR(run.events[0].time, impact.closing(), dt);
      EXPECT_NEAR(run.events[1].time, impact.opening(), front * time_scale);
      double error = 0.0;
      for (std::size_t k = 0; k < run.times.size(); ++k)
        error = std::max(error, std::abs(run.u[k][0] - impact.u(0.0, run.times[k])));
      EXPECT_LE(error, 1.5 * front * impact.speed * time_scale) << name(mass);
      if (before > 0.0) {
        EXPECT_NEAR(std::log(before / error) / std::log(4.0), 2.0 / 3.0, 0.1) << name(mass);
      }
      before = error;

      // The pressure phase alone, away from both fronts.
      for (std::size_t k = 0; k < run.times.size(); ++k)
        if (run.times[k] > impact.closing() + time_scale && run.times[k] < impact.opening() - 0.4 * time_scale) {
          EXPECT_NEAR(run.reaction_left[k], impact.reaction(run.times[k]), 0.05 * impact.reaction(run.times[k]));
        }
    }
  }
}

TEST(FullyDiscreteContact, TheReactionsImpulseIsTheChangeOfMomentum) {
  for (const Mass mass : all_masses) {
    const exact::ElasticImpact impact{{1.0, 2.0, 0.5, 0.01}, 0.8, 0.1};
    const BarSystem system(impact.scene(), {1.0, 50}, mass);
    const double dt = 0.01;
    const auto run = run_steps(system, dt, 6.0);
    const auto momentum = [&](const std::vector<double>& v) {
      std::vector<double> product(v.size());
      system.inertia().matrix().multiply(v, product);
      return std::accumulate(product.begin(), product.end(), 0.0);
    };
    const double impulse = dt * std::accumulate(run.reaction_left.begin(), run.reaction_left.end(), 0.0);
    // Sums of 600 steps over 51 nodes.
    EXPECT_NEAR(impulse, momentum(run.v.back()) - momentum(run.v.front()), 600 * 51 * eps * impulse) << name(mass);
    EXPECT_GT(impulse, impact.bar.density * impact.speed);
  }
}

TEST(FullyDiscreteContact, ThePeriodThreeBarRepeatsItselfWithReactionOneHalfAndEnergyOneEighth) {
  for (const Mass mass : {Mass::consistent, Mass::lumped, Mass::redistributed})
    for (const std::size_t elements : {100u, 400u}) {
      const Mesh mesh{1.0, elements};
      const double dt = 0.5 * mesh.spacing(), front = std::pow(mesh.spacing(), 2.0 / 3.0);
      const BarSystem system(exact::PeriodThree::scene(), mesh, mass);
      const auto run = run_steps(system, dt, 2 * exact::PeriodThree::period, {.start = Start::second_order});
      double impulse = 0.0;
      for (std::size_t k = 0; k < run.times.size(); ++k) {
        EXPECT_NEAR(run.u[k][0], exact::PeriodThree::end_displacement(run.times[k]), front) << run.times[k];
        impulse += dt * run.reaction_left[k];
      }
      EXPECT_NEAR(impulse, 2 * 0.5, front);
      EXPECT_NEAR(run.statistics.energy->initial, exact::PeriodThree::energy, mesh.spacing() / 2);
      EXPECT_NEAR(run.statistics.energy->final, exact::PeriodThree::energy, mesh.spacing());
      const auto closings = std::count_if(run.events.begin(), run.events.end(),
                                          [](const Event& e) { return e.change == Change::closing; });
      EXPECT_EQ(closings, 2) << name(mass);
      EXPECT_NEAR(run.events.front().time, exact::PeriodThree::closing, front);
      EXPECT_NEAR(run.events.back().time, exact::PeriodThree::opening + exact::PeriodThree::period, 2 * front);
    }
}

TEST(FullyDiscreteContact, IsSecondOrderForASmoothContactWithViscosity) {
  const exact::ManufacturedContact contact;
  for (const Mass mass : {Mass::consistent, Mass::lumped, Mass::redistributed}) {
    const auto error = [&](std::size_t elements) {
      const Mesh mesh{1.0, elements};
      const auto run = run_steps(BarSystem(contact.scene(), mesh, mass), 0.5 * mesh.spacing(), 3.0);
      double largest = 0.0;
      for (std::size_t k = 0; k < run.times.size(); ++k)
        for (std::size_t j = 0; j < mesh.nodes(); ++j)
          largest = std::max(largest, std::abs(run.u[k][j] - contact.u(mesh.node(j), run.times[k])));
      return largest;
    };
    EXPECT_NEAR(std::log2(error(100) / error(200)), 2.0, 0.1) << name(mass);
  }
}

Scene flat_fall(double gap) {
  Scene scene;
  scene.bar = {2.0, 1.5, 0.8, 0.1};
  scene.span = Obstacle{gap};
  scene.displacement = [](double) { return 0.0; };
  scene.velocity = [](double) { return -0.6; };
  return scene;
}

TEST(FullyDiscreteContact, AFlatFallOnASpanStaysAtRestitutionZero) {
  for (const Mass mass : {Mass::consistent, Mass::lumped, Mass::paper})
    for (const double dt : {0.3, 0.01, 0.0007}) {
      const BarSystem system(flat_fall(0.5), {2.0, 30}, mass);
      const auto run = run_steps(system, dt, 3.0);
      EXPECT_EQ(run.u.back(), std::vector<double>(31, -0.5));
      EXPECT_EQ(run.events.size(), 31u);
      const EnergyAccount& energy = *run.statistics.energy;
      EXPECT_NEAR(energy.dissipated, energy.initial, 1e3 * eps * energy.initial);
    }
}

TEST(FullyDiscreteContact, AFlatFallOnASpanReboundsWithTheRestitutionFromTheObstacleItselfToo) {
  for (const Mass mass : {Mass::consistent, Mass::lumped, Mass::paper})
    for (const Impact impact : {Impact::paoli_schatzman, Impact::moreau})
      for (const double gap : {0.0, 0.5})
        for (const double restitution : {0.25, 0.5, 1.0})
          for (const double dt : {0.13, 0.01, 0.0007}) {
            const BarSystem system(flat_fall(gap), {2.0, 30}, mass);
            const auto run = run_steps(system, dt, 3.0, {.restitution = restitution, .impact = impact});
            // Velocities are differences of |u| <= 1.5 over dt, and every node has its own rounding.
            for (const double v : run.v.back())
              EXPECT_NEAR(v, restitution * 0.6, 1e4 * eps / dt) << name(mass) << " gap " << gap << " " << dt;
            // The scheme bounds the mean of two displacements, or the velocity of the step after.
            const double share = impact == Impact::paoli_schatzman ? 2 * restitution : 1.0;
            EXPECT_LE(run.statistics.max_penetration, share * 0.6 * dt * (1 + 1e4 * eps));
          }
}

TEST(FullyDiscreteContact, HoldsEveryNodeAboveTheSpanBitwise) {
  for (const double viscosity : {0.0, 0.02})
    for (const double ratio : {0.05, 1.0, 40.0}) {
      Scene scene;
      scene.bar.viscosity = viscosity;
      scene.span = Obstacle{0.05};
      scene.displacement = [](double x) { return std::max(-0.05, 0.1 * std::cos(9 * x)); };
      scene.velocity = [](double x) { return std::sin(20 * x); };
      scene.load = SteadyLoad{[](double x) { return -x; }};
      const BarSystem system(scene, {1.0, 60}, Mass::consistent);
      const auto run = run_steps(system, ratio / 60, 400 * ratio / 60);
      EXPECT_GT(run.statistics.events, 0u);
      EXPECT_EQ(run.statistics.max_penetration, 0.0);
      std::size_t touching = 0;
      for (const auto& u : run.u)
        for (const double value : u) {
          ASSERT_GE(value, -0.05);
          touching += value == -0.05;
        }
      EXPECT_GT(touching, 0u);
    }
}

TEST(FullyDiscreteContact, ABarAtRestOnAnEndStaysAndTheReactionCarriesItsWeightFromTheStart) {
  const double weight = 0.3;
  for (const Mass mass : all_masses)
    for (const Start start : {Start::first_order, Start::second_order})
      for (const double viscosity : {0.0, 0.2}) {
        // -E u_xx = -weight, u(0) = -gap, u_x(L) = 0.
        Scene scene;
        scene.bar = {1.0, 1.0, 2.0, viscosity};
        scene.left = Obstacle{0.1};
        scene.displacement = [=](double x) { return -0.1 - weight / 2.0 * (x - x * x / 2); };
        scene.velocity = [](double) { return 0.0; };
        scene.load = SteadyLoad{[=](double) { return -weight; }};
        const Mesh mesh{1.0, 20};
        // The load of the printed product is h / 2 heavier at either end.
        const double surplus = mass == Mass::paper ? mesh.spacing() / 2 : 0.0;
        if (surplus > 0.0)
          scene.displacement = [=](double x) { return -0.1 - weight / 2.0 * (x * (1 + surplus) - x * x / 2); };
        const BarSystem system(scene, mesh, mass);
        const auto run = run_steps(system, 0.05, 5.0, {.start = start});
        const double rounding = 1e4 * eps;
        for (std::size_t k = 0; k < run.times.size(); ++k) {
          for (std::size_t j = 0; j < mesh.nodes(); ++j) EXPECT_NEAR(run.u[k][j], run.u[0][j], rounding);
          EXPECT_NEAR(run.reaction_left[k], weight * (1 + 2 * surplus), rounding * 20) << name(mass) << k;
        }
      }
}

TEST(FullyDiscreteContact, MirroredScenesHaveMirroredMotions) {
  for (const Mass mass : all_masses)
    for (const bool span : {false, true}) {
      if (span && mass == Mass::redistributed) continue;
      Scene scene;
      scene.bar.viscosity = 0.05;
      scene.left = Obstacle{0.1};
      scene.right = Free{};
      if (span) scene.span = Obstacle{0.15};
      scene.displacement = [](double x) { return x * (1 - x) + 0.1 * x; };
      scene.velocity = [](double x) { return -x; };
      scene.load = GeneralLoad{[](double x, double t) { return x * std::sin(3 * t) - 0.5; }};
      Scene mirrored = scene;
      std::swap(mirrored.left, mirrored.right);
      mirrored.displacement = [u = scene.displacement](double x) { return u(1 - x); };
      mirrored.velocity = [v = scene.velocity](double x) { return v(1 - x); };
      mirrored.load = GeneralLoad{[](double x, double t) { return (1 - x) * std::sin(3 * t) - 0.5; }};
      const Mesh mesh{1.0, 32};
      const auto a = run_steps(BarSystem(scene, mesh, mass), 0.01, 5.0);
      const auto b = run_steps(BarSystem(mirrored, mesh, mass), 0.01, 5.0);
      ASSERT_EQ(a.events.size(), b.events.size());
      EXPECT_GT(a.events.size(), 0u);
      const double rounding = 500 * 33 * eps / 0.01;  // steps, nodes, velocities are differences over dt
      for (std::size_t k = 0; k < a.times.size(); ++k) {
        EXPECT_NEAR(a.reaction_left[k], b.reaction_right[k], rounding / 0.01);
        for (std::size_t j = 0; j < mesh.nodes(); ++j) ASSERT_NEAR(a.u[k][j], b.u[k][mesh.elements - j], rounding);
      }
    }
}

TEST(FullyDiscreteContact, AnEndUnderTwoObstaclesIsBoundByTheHigherOneAndTellsWhichItIs) {
  Scene scene;
  scene.bar.viscosity = 0.5;
  scene.left = Obstacle{0.2};
  scene.right = Obstacle{0.5};
  scene.span = Obstacle{0.3};
  scene.displacement = [](double) { return 0.0; };
  scene.velocity = [](double) { return 0.0; };
  scene.load = SteadyLoad{[](double) { return -1.0; }};
  const auto run = run_steps(BarSystem(scene, {1.0, 10}, Mass::lumped), 0.01, 20.0);
  EXPECT_EQ(run.u.back().front(), -0.2);
  EXPECT_EQ(run.u.back().back(), -0.3);
  ASSERT_FALSE(run.events.empty());
  for (const Event& event : run.events) EXPECT_EQ(event.where, event.node == 0 ? Where::left : Where::span);
  EXPECT_GT(run.reaction_right.back(), 0.0);
  // Nodes in contact under the weight carry what the stress does not: the sum of what is held is the whole weight.
  EXPECT_LT(run.reaction_left.back() + run.reaction_right.back(), 1.0);
}

TEST(FullyDiscreteContact, EventsAlternateAtEachNodeInTheOrderOfTime) {
  Scene scene = paper_throw(0.001).scene;
  for (const bool span : {false, true}) {
    if (span) scene.span = Obstacle{0.05};
    for (const double restitution : {0.0, 1.0}) {
      const BarSystem system(scene, {1.0, 27}, Mass::consistent);
      const auto run =
          record(system, std::vector<double>{0.0, 6.0005}, FullyDiscrete{1e-3, Start::first_order, restitution});
      EXPECT_EQ(run.statistics.events, run.events.size());
      EXPECT_GT(run.events.size(), 4u);
      std::vector<bool> closed(28, false);
      double last = 0.0;
      for (const Event& event : run.events) {
        EXPECT_GE(event.time, last);
        EXPECT_LE(event.time, 6.0005);
        EXPECT_EQ(closed[event.node], event.change == Change::opening);
        closed[event.node] = !closed[event.node];
        last = event.time;
      }
    }
  }
}

// A massless row without viscosity is algebraic: the stress next to the end vanishes from the start, whatever the data.
TEST(FullyDiscreteContact, AMasslessEndStartsInBalance) {
  for (const double viscosity : {0.0, 0.1})
    for (const Start start : {Start::first_order, Start::second_order}) {
      Scene scene;
      scene.bar.viscosity = viscosity;
      scene.left = scene.right = Obstacle{1.0};
      scene.displacement = [](double x) { return 0.1 * x; };  // not stress-free at the ends
      scene.velocity = [](double) { return 0.0; };
      const BarSystem system(scene, {1.0, 20}, Mass::redistributed);
      const double dt = 0.01, h = 0.05;
      const auto run = run_steps(system, dt, 0.5, {.start = start});
      for (std::size_t k = 1; k < run.times.size(); ++k) {
        const double strain = (run.u[k][1] - run.u[k][0]) / h;
        // eta s' = -s: the initial strain decays within eta, at once where eta = 0.
        const double bound =
            viscosity > 0.0 ? 0.1 * std::exp(-run.times[k] / viscosity) + 0.1 * dt / viscosity : 10 * eps;
        EXPECT_LE(std::abs(strain), bound) << viscosity << " " << run.times[k];
      }
    }
}

// The bar rests on its obstacle with no force from t = 1 on, and is pressed to it from t = 2: in units whose roundings
// fall otherwise the node bounced by 1e-19 of its speed, told as 74 contacts.
TEST(FullyDiscreteContact, NoContactIsTheRoundingOfARest) {
  const Recording trace =
      record(parse_scene("bar.length = 1000\nbar.density = 1e-9\nbar.modulus = 1000.0000000000002\n"
                         "bar.viscosity = 30.000000000000007\nright.kind = \"obstacle\"\nright.side = \"above\"\n"
                         "right.gap = 0.0\nright.force = \"-1000.0000000000002*((t/0.001)<1 ? -1 : 0)\"\n"
                         "load.density = \"-1.0000000000000002*(0.1*((t/0.001)>2))\"\ntime.end = 0.03\n"
                         "method.name = \"fully_discrete\"\n",
                         "scene")
                 .run);
  EXPECT_EQ(trace.events.size(), 2u);
}

}  // namespace
}  // namespace viscobar::testing_contact

// The scheme on bars long enough for stretches side by side.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <random>
#include <span>
#include <string>

#include "schemes/end_constraint.hpp"
#include "schemes/time_step.hpp"
#include "support/random_vector.hpp"
#include "support/run_trace.hpp"
#include "viscobar/case/case.hpp"
#include "viscobar/dynamics/load_vector.hpp"
#include "viscobar/input/scene_file.hpp"

namespace viscobar::testing_lanes {
namespace {

constexpr double eps = std::numeric_limits<double>::epsilon();
constexpr Mass all_masses[] = {Mass::consistent, Mass::lumped, Mass::paper, Mass::redistributed, Mass::fourth_order};

Scene falling_bar(double viscosity) {
  Scene scene;
  scene.bar = {1.0, 1.2, 0.9, viscosity};
  scene.left = scene.right = Obstacle{0.02};
  scene.displacement = [](double x) { return 0.1 * x * (1 - x); };
  scene.velocity = [](double x) { return -0.3 * (1 + 0.2 * x); };
  scene.load = SeparableLoad{[](double x) { return std::cos(5 * x) - 1; }, [](double t) { return 1 + std::sin(t); }};
  return scene;
}

// a^n, p^{n-1/2}, u^n of the definition of TimeStep, node by node, from p^{1/2} = u_1 on.
std::vector<double> node_by_node(const BarSystem& system, double dt, std::size_t steps) {
  BandedMatrix matrix;
  system.dynamic_stiffness(1.0, dt / 2, dt * dt / 2, matrix);
  const std::size_t n = system.size();
  std::vector<EndConstraint::Bounded> bounded;
  for (const Contact& contact : system.contacts())
    bounded.push_back({contact.unknown, contact.sign, contact.joint > 0});
  EndConstraint constraint(matrix, bounded);
  std::optional<LoadVector> load;
  if (system.loaded()) load.emplace(system);
  State state = system.initial_state();
  auto& [u, p] = state;
  std::vector<double> a(n);
  for (std::size_t i = 0; i < n; ++i) u[i] += dt * p[i];
  for (std::size_t step = 1; step < steps; ++step) {
    system.internal_force(u, p, a);
    for (std::size_t i = 0; load && i < n; ++i) a[i] += load->at(static_cast<double>(step) * dt)[i];
    std::vector<double> bound, reaction(bounded.size());
    for (const Contact& one : system.contacts())
      bound.push_back(((-one.gap - one.sign * one.of(u)) / dt - one.sign * one.of(p)) / dt);
    constraint.solve(a, bound, reaction);
    for (std::size_t i = 0; i < n; ++i) {
      p[i] += dt * a[i];
      u[i] += dt * p[i];
    }
  }
  return u;
}

TEST(FullyDiscreteLanes, TakeTheSameStepsAsNodeByNode) {
  for (const Mass mass : {Mass::consistent, Mass::lumped, Mass::paper, Mass::fourth_order})
    for (const double viscosity : {0.0, 0.2})
      for (const std::size_t elements : {71u, 100u, 257u}) {
        const BarSystem system(falling_bar(viscosity), {1.0, elements}, mass);
        const double dt = 0.4 / static_cast<double>(elements);
        const std::size_t steps = elements;
        TimeStep step(system, system.initial_state(), 0.0, {.step = dt});
        ASSERT_GT(step.order().rows, 0u);
        bool touched = false;
        for (std::size_t n = 1; n < steps; ++n) {
          touched |= step.active()[0] != 0;
          step.advance();
          step.balance(static_cast<double>(n + 1) * dt);
        }
        EXPECT_TRUE(touched);
        std::vector<double> u(system.size());
        step.order().to_nodes([&](std::size_t i) { return step.u()[i]; }, u);
        const auto expected = node_by_node(system, dt, steps);
        // A force errs by eps E u / h, an acceleration by that over rho h; two sums over the steps, T = 0.4.
        const double h = 1.0 / static_cast<double>(elements), rounding = 100 * eps * 0.1 / (h * h) * 0.4 * 0.4;
        for (std::size_t i = 0; i < u.size(); ++i) ASSERT_NEAR(u[i], expected[i], rounding) << name(mass) << elements;
      }
}

// Chains whose lanes are cut at joints, of bars from shorter to longer than a lane: bonded, in contact, on springs, of
// one viscosity and of several, one of them none, with an end that is fixed.
TEST(FullyDiscreteLanes, TakeTheStepsOfChainsAsNodeByNode) {
  const auto bar = [](double length, int elements, double modulus, double viscosity, const std::string& more = "") {
    return fmt::format("[[bar]]\nlength = {}\nelements = {}\nmodulus = {}\nviscosity = {}\nvelocity = -1.0\n{}", length,
                       elements, modulus, viscosity, more);
  };
  const std::string contact = "[[joint]]\nkind = \"contact\"\ngap = 0.002\n", bonded = "[[joint]]\nkind = \"bonded\"\n",
                    spring = "[[joint]]\nkind = \"spring\"\nstiffness = 20.0\ndamping = 0.3\n",
                    obstacle = "[left]\nkind = \"obstacle\"\ngap = 0.01\n", rest = "[time]\nend = 1.0\n";
  std::string many;
  for (int k = 0; k < 10; ++k) many += bar(0.1, 40 + k, 1.0, 0.01) + (k % 3 == 1 ? bonded : contact);
  const std::string scenes[] = {
      obstacle + bar(1.0, 60, 1.0, 0.1) + bar(0.5, 90, 2.0, 0.2) + bonded,
      obstacle + bar(1.0, 160, 1.0, 0.1) + bar(0.5, 90, 2.0, 0.7) + contact,
      obstacle + bar(1.0, 160, 1.0, 0.0) + bar(0.5, 90, 2.0, 0.0) + spring + bar(0.5, 20, 2.0, 0.0) + contact,
      obstacle + "[right]\nkind = \"fixed\"\n" + bar(1.0, 300, 1.0, 0.1) + bar(0.5, 90, 2.0, 0.0) + contact,
      obstacle + many + bar(0.2, 30, 1.0, 0.5)};
  for (const std::string& text : scenes)
    for (const char* const mass : {"consistent", "lumped", "fourth_order"}) {
      const std::vector<std::string> settings = {std::string("mesh.mass=") + mass, "method.name=fully_discrete"};
      const BarSystem system = resolve(parse_scene(text + rest, "", settings).run).system();
      const double dt = 1e-3;
      const std::size_t steps = 150;
      State start = system.initial_state();
      TimeStep step(system, start, 0.0, {.step = dt});
      EXPECT_GT(step.order().rows, 0u) << text;
      std::vector<bool> touched(step.contacts().size());
      for (std::size_t n = 1; n < steps; ++n) {
        for (std::size_t k = 0; k < touched.size(); ++k) touched[k] = touched[k] || step.active()[k] != 0;
        step.advance();
        step.balance(static_cast<double>(n + 1) * dt);
      }
      EXPECT_TRUE(touched.empty() || std::ranges::count(touched, true) > 0) << text;
      std::vector<double> u(system.size());
      step.order().to_nodes([&](std::size_t i) { return step.u()[i]; }, u);
      const auto expected = node_by_node(system, dt, steps);
      const double rounding = 100 * eps * 0.2 * 2.0 * 200 * 200 * 0.15 * 0.15;  // as above, of the finest bar
      for (std::size_t i = 0; i < u.size(); ++i) ASSERT_NEAR(u[i], expected[i], rounding) << mass << i << text;
    }
}

// The energy law of energy_law_test.cpp where the sums go over stretches.
TEST(FullyDiscreteLanes, KeepTheEnergyBalance) {
  for (const Mass mass : all_masses)
    for (const double viscosity : {0.0, 0.2})
      for (const double restitution : {0.0, 0.5})
        for (const double ratio : {0.3, 30.0}) {
          const BarSystem system(falling_bar(viscosity), {1.0, 150}, mass);
          Observers observers;
          observers.energy = true;
          const double dt = ratio / 150.0;
          const std::vector<double> times{0.0, 300 * dt};
          const auto energy = *integrate(system, system.initial_state(), times,
                                         FullyDiscrete{.step = dt, .restitution = restitution}, observers)
                                   .energy;
          // Strain is a difference of displacements up to the largest, over h, in 150 elements and 300 steps.
          const double largest = 1.0 + times.back(), strain = 2 * largest * 150;
          EXPECT_NEAR(energy.balance_error(), 0.0, 300 * 10 * eps * strain * largest) << name(mass) << ratio;
          if (viscosity > 0.0) {
            EXPECT_GT(energy.dissipated, 0.0);
          }
        }
}

// As ZerosBehindAVectorChangeNoBitOfItsQuadraticForm, of the work of a load in a step.
TEST(FullyDiscreteLanes, ZerosBehindALoadChangeNoBitOfItsPower) {
  std::mt19937 random(4);
  for (std::size_t n = 1; n < 40; ++n)
    for (std::size_t zeros = 1; zeros <= 16; ++zeros) {
      auto load = random_vector(n, random), p = random_vector(n + zeros, random), a = random_vector(n + zeros, random);
      const double alone = power(load, std::span(p).first(n), -1e-3, std::span(a).first(n));
      load.resize(n + zeros);
      EXPECT_EQ(power(load, p, -1e-3, a), alone) << n << " " << zeros;
    }
}

TEST(FullyDiscreteLanes, CarryARigidMotionExactly) {
  Scene scene;
  scene.bar = {3.0, 2.0, 7.0, 0.4};
  scene.displacement = [](double) { return 0.3; };
  scene.velocity = [](double) { return -0.7; };
  for (const Mass mass : {Mass::consistent, Mass::lumped, Mass::paper}) {
    const auto run = record(BarSystem(scene, {3.0, 500}, mass), uniform_times(1.0, 3), FullyDiscrete{1e-2});
    for (const auto& v : run.v)
      for (const double value : v) EXPECT_EQ(value, -0.7);
  }
}

// A step with and without output, with and without the energy account, is the same to the last bit.
TEST(FullyDiscreteLanes, ObserversDoNotChangeTheTrajectory) {
  for (const double viscosity : {0.0, 0.2}) {
    const BarSystem system(falling_bar(viscosity), {1.0, 130}, Mass::consistent);
    const double dt = 1.0 / 256;
    const auto end_of = [&](std::size_t outputs, bool energy) {
      std::vector<double> u;
      Observers observers;
      observers.snapshot = [&](const Snapshot& now) { u.assign(now.u.begin(), now.u.end()); };
      observers.energy = energy;
      integrate(system, system.initial_state(), uniform_times(1.0 / static_cast<double>(outputs), outputs),
                FullyDiscrete{dt}, observers);
      return u;
    };
    const auto plain = end_of(1, false);
    EXPECT_EQ(end_of(256, false), plain);
    EXPECT_EQ(end_of(7, true), plain);
  }
}

TEST(FullyDiscreteLanes, MirroredScenesHaveMirroredMotions) {
  for (const Mass mass : all_masses) {
    const Scene scene = falling_bar(0.1);
    Scene mirrored = scene;
    mirrored.displacement = [u = scene.displacement](double x) { return u(1 - x); };
    mirrored.velocity = [v = scene.velocity](double x) { return v(1 - x); };
    mirrored.load =
        SeparableLoad{[](double x) { return std::cos(5 * (1 - x)) - 1; }, [](double t) { return 1 + std::sin(t); }};
    const Mesh mesh{1.0, 150};
    const auto a = record(BarSystem(scene, mesh, mass), uniform_times(0.1, 10), FullyDiscrete{1e-3});
    const auto b = record(BarSystem(mirrored, mesh, mass), uniform_times(0.1, 10), FullyDiscrete{1e-3});
    const double rounding = 100 * eps * 0.5 * 150 * 150;  // as in TakeTheSameStepsAsNodeByNode, |u| < 0.5, T = 1
    for (std::size_t k = 0; k < a.times.size(); ++k)
      for (std::size_t j = 0; j < mesh.nodes(); ++j) ASSERT_NEAR(a.u[k][j], b.u[k][mesh.elements - j], rounding);
  }
}

TEST(FullyDiscreteLanes, StopWhenTheSolutionIsNoLongerFinite) {
  Scene scene = falling_bar(0.1);
  scene.displacement = [](double x) { return x == 0.5 ? 1e308 : 0.0; };
  const BarSystem system(scene, {1.0, 200}, Mass::consistent);
  EXPECT_THROW(record(system, uniform_times(0.1, 2), FullyDiscrete{1e-3}), IntegrationError);
}

}  // namespace
}  // namespace viscobar::testing_lanes

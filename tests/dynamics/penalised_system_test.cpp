#include "dynamics/penalised_system.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "dynamics/contact_forces.hpp"
#include "dynamics/energy_terms.hpp"
#include "dynamics/indicator.hpp"
#include "support/random_vector.hpp"

namespace viscobar::testing_penalised_system {
namespace {

Scene scene_with(EndCondition left, EndCondition right, double viscosity) {
  Scene scene;
  scene.bar = {1.5, 2.0, 3.0, viscosity};
  scene.left = left;
  scene.right = right;
  scene.displacement = [](double x) { return 0.2 + x * (1.5 - x); };
  scene.velocity = [](double x) { return -x; };
  return scene;
}

// D(m,c,k) is the derivative of m rho M x - F(u + k x, w + c x): the force is affine on a leg, so differences are exact
// but for rounding, n eps times the size of the terms.
TEST(PenalisedSystem, DynamicStiffnessIsTheDerivativeOfTheForce) {
  for (const Mass mass : {Mass::consistent, Mass::lumped, Mass::paper, Mass::redistributed}) {
    for (const EndCondition& right : {EndCondition{Free{}}, EndCondition{Fixed{}}, EndCondition{Obstacle{0.3}}}) {
      const BarSystem bar(scene_with(Obstacle{0.1}, right, 0.7), Mesh{1.5, 8}, mass);
      PenalisedSystem system(bar, Penalty{0.01, 0.5});
      for (std::size_t i = 0; i < system.contacts().size(); ++i) system.contacts().set_closed(i, true);
      const std::size_t n = system.size();
      const double m = 1.7, c = 0.6, k = 0.9;
      const auto u = random_vector(n, 1), w = random_vector(n, 2), x = random_vector(n, 3);
      std::vector<double> shifted_u(n), shifted_w(n), before(n), after(n), product(n), inertia(n);
      for (std::size_t i = 0; i < n; ++i) shifted_u[i] = u[i] + k * x[i], shifted_w[i] = w[i] + c * x[i];
      system.force(0.0, u, w, before);
      system.force(0.0, shifted_u, shifted_w, after);
      BandedMatrix matrix;
      system.dynamic_stiffness(m, c, k, matrix);
      matrix.multiply(x, product);
      bar.inertia().matrix().multiply(x, inertia);
      for (std::size_t i = 0; i < n; ++i)
        EXPECT_NEAR(product[i], m * inertia[i] - (after[i] - before[i]), 100 * 2.3e-16 * 200.0)
            << name(mass) << ", row " << i;
    }
  }
}

// dE/dt = F . w - dissipated power + w . rho M a vanishes when rho M a = F: power of the force on frozen contacts.
TEST(PenalisedSystem, ForceDoesTheWorkThatTheEnergyLoses) {
  const BarSystem bar(scene_with(Obstacle{0.0}, Fixed{}, 0.4), Mesh{1.5, 6}, Mass::consistent);
  PenalisedSystem system(bar, Penalty{0.02, 0.3});
  system.contacts().set_closed(0, true);
  auto u = random_vector(system.size(), 4);
  const auto w = random_vector(system.size(), 5);
  u[0] = -0.5;  // penetrates
  std::vector<double> force(system.size());
  system.force(0.0, u, w, force);
  const double power = std::inner_product(force.begin(), force.end(), w.begin(), 0.0);
  // The potential energy is quadratic: a central difference along w has no error but rounding / step.
  const double step = 1e-3;
  const std::vector<double> still(system.size(), 0.0);
  auto potential = [&](double s) {
    std::vector<double> moved(u);
    for (std::size_t i = 0; i < moved.size(); ++i) moved[i] += s * w[i];
    return energy(system.contacts(), moved, still);
  };
  const double rate = (potential(step) - potential(-step)) / (2 * step);
  EXPECT_NEAR(power, -rate - dissipated_power(system.contacts(), w), 1e3 * 2.3e-16 / step);
}

TEST(PenalisedSystem, MasslessVelocityBalancesItsRow) {
  const BarSystem bar(scene_with(Obstacle{0.1}, Obstacle{0.1}, 0.7), Mesh{1.5, 8}, Mass::redistributed);
  PenalisedSystem system(bar, Penalty{0.01});
  system.contacts().set_closed(0, true);
  const auto u = random_vector(system.size(), 6);
  auto w = random_vector(system.size(), 7);
  system.complete_velocity(0.0, u, w);
  std::vector<double> force(system.size());
  system.force(0.0, u, w, force);
  // Terms of size u / epsilon = 100 cancel.
  EXPECT_NEAR(force.front(), 0.0, 100 * 100 * 2.3e-16);
  EXPECT_NEAR(force.back(), 0.0, 100 * 100 * 2.3e-16);
}

TEST(PenalisedSystem, UndampedMasslessDisplacementBalancesItsRow) {
  const BarSystem bar(scene_with(Obstacle{0.1}, Free{}, 0.0), Mesh{1.5, 8}, Mass::redistributed);
  PenalisedSystem system(bar, Penalty{0.01});
  for (const bool closed : {false, true}) {
    system.contacts().set_closed(0, closed);
    auto u = random_vector(system.size(), 8);
    const auto w = random_vector(system.size(), 9);
    system.complete_displacement(0.0, u);
    std::vector<double> force(system.size());
    system.force(0.0, u, w, force);
    EXPECT_NEAR(force.front(), 0.0, 100 * 100 * 2.3e-16);
  }
}

TEST(PenalisedSystem, StartsClosedOnlyWhenPressedIn) {
  struct Start {
    double displacement, velocity, load;
    bool closed;
  };
  const double gap = 0.25;
  for (const Start& start :
       {Start{0.0, -1.0, 0.0, false}, Start{-gap, -1.0, 0.0, true}, Start{-gap, 1.0, 0.0, false},
        Start{-gap, 0.0, -1.0, true}, Start{-gap, 0.0, 1.0, false}, Start{-gap, 0.0, 0.0, false}}) {
    Scene scene = scene_with(Obstacle{gap}, Free{}, 0.1);
    scene.displacement = [=](double) { return start.displacement; };
    scene.velocity = [=](double) { return start.velocity; };
    if (start.load != 0.0) scene.load = SteadyLoad{[=](double) { return start.load; }};
    const BarSystem bar(scene, Mesh{1.5, 4}, Mass::consistent);
    PenalisedSystem system(bar, Penalty{0.01});
    State state = bar.initial_state();
    system.settle(0.0, state.u, state.v);
    EXPECT_EQ(system.contacts().closed(0), start.closed)
        << "u " << start.displacement << ", v " << start.velocity << ", f " << start.load;
  }
}

// kappa = k h / E against 1 / rounding = 4.5e15, times 1 + eta / (h sqrt(E rho)) with viscosity.
TEST(PenalisedSystem, ASpringThatGivesWayByLessThanRoundingHoldsItsMasslessNode) {
  const double h = 1.5 / 6, modulus = 3.0, twice = 2.0 * h * std::sqrt(modulus * 2.0);
  const auto holds = [&](double kappa, double viscosity, Mass mass) {
    const BarSystem bar(scene_with(Obstacle{0.1}, Free{}, viscosity), Mesh{1.5, 6}, mass);
    return PenalisedSystem(bar, Penalty{h / (kappa * modulus)}).contacts()[0].holds;
  };
  EXPECT_FALSE(holds(4e15, 0.0, Mass::redistributed));
  EXPECT_TRUE(holds(5e15, 0.0, Mass::redistributed));
  EXPECT_FALSE(holds(13e15, twice, Mass::redistributed));
  EXPECT_TRUE(holds(14e15, twice, Mass::redistributed));
  EXPECT_FALSE(holds(14e15, 0.0, Mass::consistent));
}

TEST(PenalisedSystem, MeasuredFromItsObstacleABarFeelsTheSameForces) {
  for (const Mass mass : {Mass::consistent, Mass::lumped, Mass::redistributed})
    for (const double viscosity : {0.0, 0.7}) {
      const BarSystem bar(scene_with(Obstacle{0.1}, Obstacle{0.3}, viscosity), Mesh{1.5, 6}, mass);
      PenalisedSystem system(bar, Penalty{0.01});
      system.contacts().set_closed(0, true);
      std::vector<double> u = random_vector(7, 1), w = random_vector(7, 2), before(7), after(7);
      system.complete_displacement(0.0, u);
      system.complete_velocity(0.0, u, w);
      const std::vector<double> displacement = u, velocity = w;
      const double energy = viscobar::energy(system.contacts(), u, w), reaction = reactions(system, 0.0, u, w)[0];
      system.force(0.0, u, w, before);
      system.contacts().measure(0, u);
      system.contacts().measure(1, u);
      EXPECT_EQ(u[0], displacement[0] + 0.1);
      EXPECT_EQ(system.contacts().clearance(0, u), u[0]);
      system.complete_displacement(0.0, u);
      system.complete_velocity(0.0, u, w);
      system.force(0.0, u, w, after);
      for (std::size_t i = 0; i < 7; ++i) {
        EXPECT_NEAR(u[i] + system.contacts().origin().values()[i], displacement[i], 1e-14);
        EXPECT_NEAR(w[i], velocity[i], 1e-12);
        EXPECT_NEAR(after[i], before[i], 1e-11) << i;
      }
      EXPECT_NEAR(viscobar::energy(system.contacts(), u, w), energy, 1e-12 * energy);
      EXPECT_NEAR(reactions(system, 0.0, u, w)[0], reaction, 1e-12);
      EXPECT_DOUBLE_EQ(system.contacts().origin().largest_displacement(u),
                       std::abs(*std::ranges::max_element(displacement, {}, [](double x) { return std::abs(x); })));
    }
}

TEST(PenalisedSystem, APenetrationFarBelowTheRoundingOfTheGapGivesItsReaction) {
  const double epsilon = 1e-30, force = 0.4;
  const BarSystem bar(scene_with(Obstacle{0.1}, Free{}, 0.7), Mesh{1.5, 6}, Mass::consistent);
  PenalisedSystem system(bar, Penalty{epsilon});
  std::vector<double> u(7, -0.1), w(7, 0.0);
  system.contacts().set_closed(0, true);
  system.contacts().measure(0, u);
  u[0] = -epsilon * force;
  EXPECT_DOUBLE_EQ(reactions(system, 0.0, u, w)[0], force);
  // The rounding error of its clearance, as a reaction, is below the rounding of the strain beside it.
  EXPECT_LT(Indicators(system.contacts(), system.load()).rounding(0, 0.1) / epsilon, 64.0 * 0.2 * 3.0 / 0.25 * 2.3e-16);
}

TEST(PenalisedSystem, EvaluatesNoLoadWhereThereIsNone) {
  const BarSystem bar(scene_with(Obstacle{0.1}, Free{}, 0.1), Mesh{1.5, 4}, Mass::consistent);
  PenalisedSystem system(bar, Penalty{0.01});
  std::vector<double> out(system.size());
  const State state = bar.initial_state();
  system.force(0.0, state.u, state.v, out);
  EXPECT_FALSE(system.load().acts());
  EXPECT_EQ(system.load().evaluations(), 0u);
}

}  // namespace
}  // namespace viscobar::testing_penalised_system

// What only Boost.Odeint's steppers have: the choice among them, their refusals, and fixed symplectic steps.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <stdexcept>

#include "support/run_trace.hpp"
#include "viscobar/integration/integrate.hpp"

namespace viscobar::testing_odeint {
namespace {

Scene thrown_bar(double viscosity) {
  Scene scene;
  scene.bar = {1.0, 1.0, 1.0, viscosity};
  scene.left = Obstacle{0.1};
  scene.displacement = [](double x) { return x * (1.1 - x); };
  scene.velocity = [](double x) { return -0.8 - 0.4 * x; };
  return scene;
}

double distance(const RunTrace& a, const RunTrace& b) {
  double largest = 0.0;
  for (std::size_t k = 0; k < a.u.size(); ++k)
    for (std::size_t j = 0; j < a.u[k].size(); ++j) largest = std::max(largest, std::abs(a.u[k][j] - b.u[k][j]));
  return largest;
}

RunTrace symplectic_run(const BarSystem& system, double step, double end) {
  return record(system, uniform_times(end / 50, 50), Odeint{Penalty{1e-2}, {}, Stepper::symplectic, step});
}

TEST(Symplectic, IsOfOrderFourUnderALoadInTime) {
  Scene scene = thrown_bar(0.0);
  scene.left = Free{};
  scene.load = SeparableLoad{[](double x) { return 1 + x; }, [](double t) { return std::sin(3 * t); }};
  const BarSystem system(scene, Mesh{1.0, 6}, Mass::lumped);
  const RunTrace exact = record(system, uniform_times(0.05, 50), Exponential{});
  const double coarse = distance(symplectic_run(system, 8e-3, 2.5), exact);
  const double fine = distance(symplectic_run(system, 4e-3, 2.5), exact);
  EXPECT_NEAR(std::log2(coarse / fine), 4.0, 0.1) << coarse << " " << fine;
}

// Where a step is cut at a contact change depends on the phase of the fixed steps, and with it the constant before
// h^4, here by a factor of two either way: over four halvings, 1/4 in the order.
TEST(Symplectic, KeepsItsOrderAcrossContactChanges) {
  const BarSystem system(thrown_bar(0.0), Mesh{1.0, 6}, Mass::lumped);
  const RunTrace exact = record(system, uniform_times(0.05, 50), Exponential{Penalty{1e-2}});
  ASSERT_GE(exact.events.size(), 10u);
  const RunTrace coarse = symplectic_run(system, 8e-3, 2.5), fine = symplectic_run(system, 5e-4, 2.5);
  EXPECT_NEAR(std::log2(distance(coarse, exact) / distance(fine, exact)) / 4.0, 4.0, 0.25);
  ASSERT_EQ(fine.events.size(), exact.events.size());
  ASSERT_EQ(coarse.events.size(), exact.events.size());
}

// Away from contact the formulas conserve an energy that is h^4 from the bar's: the difference does not grow in time.
TEST(Symplectic, DoesNotDriftInEnergy) {
  Scene scene = thrown_bar(0.0);
  scene.left = Fixed{};
  const BarSystem system(scene, Mesh{1.0, 6}, Mass::lumped);
  const auto error = [&](double end) {
    return std::abs(symplectic_run(system, 2e-2, end).statistics.energy->balance_error());
  };
  double early = 0.0, late = 0.0;
  for (int k = 1; k <= 10; ++k) early = std::max(early, error(k)), late = std::max(late, error(200.0 + k));
  EXPECT_LT(late, 2.0 * early);
}

TEST(Symplectic, MakesItsFixedStepsAndNoOther) {
  Scene scene = thrown_bar(0.0);
  scene.left = Free{};
  const BarSystem system(scene, Mesh{1.0, 6}, Mass::lumped);
  const RunTrace run = symplectic_run(system, 1e-2, 1.0);
  EXPECT_EQ(run.statistics.steps, 100u);
  EXPECT_EQ(run.statistics.event_evaluations, 0u);
  EXPECT_EQ(run.statistics.load_evaluations, 0u);
}

// The bound refuses what grows and hardly more: lumped free bar, omega^2 = 4 / h^2 exactly at the highest mode.
TEST(Symplectic, RefusesTheStepsThatAreUnstable) {
  Scene scene = thrown_bar(0.0);
  scene.left = Free{};
  const BarSystem system(scene, Mesh{1.0, 8}, Mass::lumped);
  double largest = 1.0;
  while (plan(system, 100.0, Odeint{{}, {}, Stepper::symplectic, largest}).refusal) largest *= 0.99;
  const RunTrace run = record(system, uniform_times(50.0, 2), Odeint{{}, {}, Stepper::symplectic, largest});
  EXPECT_LT(std::abs(run.statistics.energy->balance_error()), 10.0 * run.statistics.energy->initial);
  EXPECT_GT(largest * 2.0 * 8.0, 2.0) << "no better than the leapfrog's h omega <= 2";
}

TEST(Odeint, ChoosesTheDenseStepperForFewStiffNodesOnly) {
  const auto chosen = [](std::size_t elements, double viscosity, Mass mass, double epsilon) {
    return plan(BarSystem(thrown_bar(viscosity), Mesh{1.0, elements}, mass), 6.0,
                Odeint{Penalty{epsilon}, {}, Stepper::automatic, {}})
        .stepper;
  };
  EXPECT_EQ(chosen(27, 0.01, Mass::consistent, 1e-4), Stepper::dopri5);
  EXPECT_EQ(chosen(27, 1.0, Mass::consistent, 1e-4), Stepper::dopri5);
  EXPECT_EQ(chosen(27, 0.01, Mass::redistributed, 1e-6), Stepper::rosenbrock4);
  EXPECT_EQ(chosen(200, 0.01, Mass::redistributed, 1e-6), Stepper::dopri5);
}

TEST(Odeint, SaysWhyItRefuses) {
  const auto refused = [](const Scene& scene, std::size_t elements, Mass mass, const Odeint& method) {
    const BarSystem system(scene, Mesh{1.0, elements}, mass);
    try {
      integrate(system, system.initial_state(), uniform_times(0.5, 2), method, {});
    } catch (const Unfit& error) {
      return std::optional(error.refusal);
    }
    return std::optional<Refusal>();
  };
  const Penalty penalty{1e-3};
  const auto by = [&](Stepper stepper) { return Odeint{penalty, {}, stepper, {}}; };
  EXPECT_EQ(refused(thrown_bar(0.0), 9, Mass::redistributed, by(Stepper::automatic)), Refusal::algebraic_rows);
  EXPECT_EQ(refused(thrown_bar(0.1), 120, Mass::lumped, by(Stepper::rosenbrock4)), Refusal::many_unknowns);
  EXPECT_EQ(refused(thrown_bar(0.1), 9, Mass::lumped, by(Stepper::symplectic)), Refusal::viscosity);
  EXPECT_EQ(refused(thrown_bar(0.0), 9, Mass::lumped, Odeint{Penalty{1e-3, 0.5}, {}, Stepper::symplectic, 1e-3}),
            Refusal::restitution);
  EXPECT_EQ(refused(thrown_bar(0.0), 9, Mass::lumped, by(Stepper::symplectic)), Refusal::no_step);
  EXPECT_EQ(refused(thrown_bar(0.0), 9, Mass::lumped, Odeint{penalty, {}, Stepper::symplectic, 1.0}),
            Refusal::unstable_step);
  // 12 eta / (rho h^2) = 1.2e11 a unit of time
  EXPECT_EQ(refused(thrown_bar(1.0), 100000, Mass::consistent, by(Stepper::automatic)), Refusal::many_steps);
}

// A spring far softer than the bar: the force of the element beside it is E/h times a difference of displacements,
// whose errors are those of the tolerance. The impulse is the integral of the spring's own force.
TEST(SoftSpring, HasTheImpulseOfItsForceWhateverTheMeshMakesOfErrors) {
  constexpr double epsilon = 100.0, tolerance = 1e-6;
  Scene scene;
  scene.bar.viscosity = 1e-3;
  scene.left = Obstacle{0.0};
  scene.displacement = [](double) { return 0.0; };
  scene.velocity = [](double) { return -1.0; };
  const BarSystem system(scene, Mesh{1.0, 100}, Mass::redistributed);
  const auto impulse = [&](const auto& method) {
    Observers observers;
    observers.account = true;
    return integrate(system, system.initial_state(), uniform_times(5.0, 1), method, observers).account->left.impulse;
  };
  const double exact = impulse(Exponential{Penalty{epsilon}});
  const Tolerance asked{tolerance};
  EXPECT_NEAR(impulse(Odeint{Penalty{epsilon}, asked, Stepper::dopri5, {}}), exact, 10 * tolerance * exact);
  EXPECT_NEAR(impulse(Cvode{Penalty{epsilon}, asked}), exact, 10 * tolerance * exact);
  EXPECT_NEAR(impulse(Ida{Penalty{epsilon}, asked}), exact, 10 * tolerance * exact);
  EXPECT_NEAR(impulse(Arkode{Penalty{epsilon}, asked}), exact, 10 * tolerance * exact);
}

// The bar is linear but for its gap: displacements, load and gap times a power of two, lengths as they are, give the
// same digits. (The Jacobian's columns were differences against the load, for displacements of the size of a length.)
TEST(Odeint, DigitsOfRosenbrock4DoNotDependOnTheUnitOfDisplacement) {
  for (const Mass mass : {Mass::consistent, Mass::redistributed, Mass::fourth_order}) {
    const auto run = [&](double unit) {
      Scene scene;
      scene.bar = {1.3, 1.7, 2.1, 0.1};
      scene.left = Obstacle{0.07 * unit};
      scene.displacement = [unit](double x) { return unit * 0.1 * x * (1.3 - x); };
      scene.velocity = [unit](double x) { return -0.3 * unit * (1.0 + 0.1 * x); };
      scene.load = SteadyLoad{[unit](double x) { return -0.7 * unit * x; }};
      return viscobar::record(BarSystem(scene, {1.3, 9}, mass), uniform_times(0.1, 15),
                              Odeint{{1e-4}, {1e-7}, Stepper::rosenbrock4, {}});
    };
    const RunTrace one = run(1.0);
    EXPECT_GT(one.events.size(), 0u);
    for (const double unit : {0x1p-40, 0x1p40}) {
      const RunTrace other = run(unit);
      ASSERT_EQ(other.u.size(), one.u.size());
      for (std::size_t k = 0; k < one.u.size(); ++k)
        for (std::size_t i = 0; i < one.u[k].size(); ++i)
          EXPECT_EQ(other.u[k][i], unit * one.u[k][i]) << name(mass) << " " << unit << " " << k << " " << i;
    }
  }
}

}  // namespace
}  // namespace viscobar::testing_odeint

#include <gtest/gtest.h>

#include <cmath>
#include <type_traits>

#include "support/allocations.hpp"
#include "viscobar/integration/integrate.hpp"

namespace viscobar::testing_allocation {
namespace {

using testing_support::allocations;

struct Count {
  std::size_t allocations, steps;
};

// A leg of a bar that flies between two obstacles under a load, searched for contact and accounted for.
template <class Method>
Count counted(const Method& method, double viscosity, Mass mass = Mass::consistent) {
  Scene scene;
  scene.bar.viscosity = viscosity;
  scene.left = scene.right = Obstacle{0.3};
  scene.displacement = [](double x) { return 0.1 * std::cos(3 * x); };
  scene.velocity = [](double) { return 0.1; };
  scene.load = GeneralLoad{[](double x, double t) { return 0.1 * x * std::sin(9 * t); }};
  const BarSystem system(scene, {1.0, 20}, mass);
  const State start = system.initial_state();
  double seen = 0.0;
  Observers observers;
  observers.energy = observers.account = true;
  observers.progress = [&](double time) {
    seen += time;
    return RunControl::go_on;
  };
  const double times[] = {0.0, 1.0};
  const std::size_t before = allocations;
  const Statistics statistics = integrate(system, start, times, method, observers);
  return {allocations - before, statistics.steps};
}

template <class Method>
void expect_no_allocation_a_step() {
  for (const Mass mass : {Mass::consistent, Mass::fourth_order})
    for (const double viscosity : {0.0, 0.1}) {
      Method rough{{1e-4}, {1e-4, 1e-7}}, fine{{1e-4}, {1e-10, 1e-13}};
      // Its choice depends on the tolerance.
      if constexpr (std::is_same_v<Method, Cvode>)
        rough.formulas = fine.formulas = viscosity > 0.0 ? Formulas::bdf : Formulas::adams;
      counted(fine, viscosity, mass);  // makes the tables that all runs share
      const Count few = counted(rough, viscosity, mass), many = counted(fine, viscosity, mass);
      EXPECT_GT(many.steps, 2 * few.steps);
      EXPECT_EQ(many.allocations, few.allocations) << name(mass);
    }
}

TEST(Cvode, StepsAllocateNothing) { expect_no_allocation_a_step<Cvode>(); }
TEST(Ida, StepsAllocateNothing) { expect_no_allocation_a_step<Ida>(); }
TEST(Arkode, StepsAllocateNothing) { expect_no_allocation_a_step<Arkode>(); }

TEST(Rigid, StepsAllocateNothing) {
  for (const Mass mass : {Mass::consistent, Mass::redistributed, Mass::fourth_order}) {
    counted(Rigid{{1e-4, 1e-7}}, 0.1, mass);  // makes the tables that all runs share
    const Count few = counted(Rigid{{1e-4, 1e-7}}, 0.1, mass), many = counted(Rigid{{1e-12, 1e-15}}, 0.1, mass);
    EXPECT_GT(many.steps, few.steps);
    EXPECT_EQ(many.allocations, few.allocations) << name(mass);
  }
}

TEST(Odeint, StepsAllocateNothing) {
  for (const Stepper stepper : {Stepper::dopri5, Stepper::rosenbrock4}) {
    counted(Odeint{{1e-4}, {1e-4, 1e-7}, stepper}, 0.1);  // makes the tables that all runs share
    const Count few = counted(Odeint{{1e-4}, {1e-4, 1e-7}, stepper}, 0.1);
    const Count many = counted(Odeint{{1e-4}, {1e-9, 1e-12}, stepper}, 0.1);
    EXPECT_GT(many.steps, few.steps);
    EXPECT_EQ(many.allocations, few.allocations);
  }
}

}  // namespace
}  // namespace viscobar::testing_allocation

// Features of Boost.Odeint's steppers alone: the choice among them and their refusals.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "support/falling_bar.hpp"
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

TEST(Odeint, ChoosesTheImplicitStepperWhereStabilityIsDear) {
  const auto chosen = [](std::size_t elements, double viscosity, Mass mass, double epsilon) {
    return plan(BarSystem(thrown_bar(viscosity), Mesh{1.0, elements}, mass), 6.0,
                Odeint{Penalty{epsilon}, {}, Stepper::automatic})
        .stepper;
  };
  EXPECT_EQ(chosen(27, 0.01, Mass::consistent, 1e-4), Stepper::dopri5);
  EXPECT_EQ(chosen(27, 1.0, Mass::consistent, 1e-4), Stepper::rosenbrock4);
  EXPECT_EQ(chosen(27, 0.01, Mass::redistributed, 1e-6), Stepper::rosenbrock4);
  // By dopri5 errors of u at its bound of stability are velocities of a node without mass.
  EXPECT_EQ(chosen(27, 0.01, Mass::redistributed, 1e-3), Stepper::rosenbrock4);
  EXPECT_EQ(chosen(200, 0.01, Mass::redistributed, 1e-6), Stepper::rosenbrock4);
  // At rest in contact dopri5 would step by the contact's own oscillation, which rosenbrock4 damps.
  EXPECT_EQ(chosen(27, 0.01, Mass::consistent, 1e-12), Stepper::rosenbrock4);
  EXPECT_EQ(chosen(27, 0.0, Mass::consistent, 1e-12), Stepper::dopri5);
  // So it would by a dashpot that stops an undamped bar, unless the contact is soft
  // (tests/measurements/odeint_steppers.py).
  const auto damped_contact = [](double epsilon) {
    return plan(BarSystem(thrown_bar(0.0), Mesh{1.0, 200}, Mass::consistent), 6.0,
                Odeint{Penalty{epsilon, 0.5}, {}, Stepper::automatic})
        .stepper;
  };
  EXPECT_EQ(damped_contact(1e-4), Stepper::dopri5);
  EXPECT_EQ(damped_contact(1e-9), Stepper::rosenbrock4);
}

TEST(Odeint, SaysWhyItRefuses) {
  const auto refused = [](const Scene& scene, std::size_t elements, Mass mass, const Odeint& method) {
    const BarSystem system(scene, Mesh{1.0, elements}, mass);
    try {
      integrate(system, system.initial_state(), uniform_times(0.5, 2), method, {});
    } catch (const Unfit& error) {
      return error.finding.key + " " + error.finding.problem;
    }
    return std::string();
  };
  constexpr auto npos = std::string::npos;
  const Penalty penalty{1e-3};
  const auto by = [&](Stepper stepper) { return Odeint{penalty, {}, stepper}; };
  EXPECT_NE(refused(thrown_bar(0.0), 9, Mass::redistributed, by(Stepper::automatic)).find("algebraic"), npos);
  // 12 eta / (rho h^2) = 1.2e11 a unit of time
  EXPECT_NE(refused(thrown_bar(1.0), 100000, Mass::consistent, by(Stepper::dopri5)).find("method.name dopri5 would"),
            npos);
}

// With Boost's own coefficients for the rate of the load the formulas are of order 2.
TEST(Rosenbrock4, IsOfOrderFourUnderALoadThatVaries) {
  for (const Mass mass : {Mass::consistent, Mass::redistributed, Mass::fourth_order}) {
    Scene scene;
    scene.bar = {1.0, 1.0, 1.0, 0.3};
    scene.left = Obstacle{10.0};
    scene.displacement = scene.velocity = [](double) { return 0.0; };
    scene.load = GeneralLoad{[](double x, double t) { return x * std::cos(3.0 * t); }};
    const BarSystem system(scene, {1.0, 12}, mass);
    const auto run = [&](const auto& method) { return viscobar::record(system, uniform_times(3.0, 1), method); };
    const std::vector<double> exact = run(Exponential{Penalty{1e-4}}).u.back();
    const auto by = [&](double tolerance) {
      const RunTrace trace = run(Odeint{{1e-4}, {tolerance, 1e-3 * tolerance}, Stepper::rosenbrock4});
      double error = 0.0;
      for (std::size_t i = 0; i < exact.size(); ++i) error = std::max(error, std::abs(trace.u.back()[i] - exact[i]));
      return std::pair(error, static_cast<double>(trace.statistics.steps));
    };
    const auto [rough, few] = by(1e-6);
    const auto [fine, many] = by(1e-9);
    EXPECT_NEAR(std::log(rough / fine) / std::log(many / few), 4.0, 0.3) << name(mass);
  }
}

// A spring far softer than the bar: the force of the element beside it is E/h times a difference of displacements,
// whose errors are those of the tolerance. The impulse is the integral of the spring's own force.
TEST(SoftSpring, HasTheImpulseOfItsForceWhateverTheMeshMakesOfErrors) {
  constexpr double epsilon = 100.0, tolerance = 1e-6;
  Scene scene = falling_bar(0.0, 1.0, 1e-3);
  const BarSystem system(scene, Mesh{1.0, 100}, Mass::redistributed);
  const auto impulse = [&](const auto& method) {
    Observers observers;
    observers.account = true;
    return integrate(system, system.initial_state(), uniform_times(5.0, 1), method, observers).account->left.impulse;
  };
  const double exact = impulse(Exponential{Penalty{epsilon}});
  const Tolerance asked{tolerance};
  EXPECT_NEAR(impulse(Odeint{Penalty{epsilon}, asked, Stepper::dopri5}), exact, 10 * tolerance * exact);
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
                              Odeint{{1e-4}, {1e-7}, Stepper::rosenbrock4});
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

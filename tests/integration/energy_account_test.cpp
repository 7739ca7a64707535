// The energy account is as good as the motion, however fast the power varies.
#include <gtest/gtest.h>

#include <cmath>

#include "viscobar/case/recording.hpp"

namespace viscobar::testing_energy_account {
namespace {

// A free bar under f = sin(omega t) moves as one point, v = (1 - cos omega t) / omega, in steps that just resolve the
// load; its power has twice the frequency. Little viscosity: cvode takes Adams' formulas, of high order; more: backward
// differentiation.
Case shaken(double frequency, double viscosity) {
  Case run;
  run.scene.bar = {1.0, 1.0, 1.0, viscosity};
  run.scene.displacement = run.scene.velocity = [](double) { return 0.0; };
  run.scene.load = SeparableLoad{[](double) { return 1.0; }, [=](double t) { return std::sin(frequency * t); }};
  run.elements = 8;
  run.end = 1.0;
  run.output_every = 0.5;
  return run;
}

class EnergyAccount : public testing::TestWithParam<MethodName> {};

TEST_P(EnergyAccount, OfALoadThatOscillatesFastKeepsThePromiseOfTheMotion) {
  for (const double frequency : {10.0, 1000.0}) {
    for (const double viscosity : {0.01, 0.1}) {
      for (const double tolerance : {1e-4, 1e-6, 1e-8}) {
        Case run = shaken(frequency, viscosity);
        run.method = GetParam();
        run.tolerance = {tolerance, 1e-3 * tolerance};
        const auto account = record(run).statistics.energy;
        ASSERT_TRUE(account.has_value());
        // A velocity wrong by 100 times the tolerance, at a speed of at most 2 / omega: twice that of the energy.
        const double speed = 2.0 / frequency, energy = speed * speed / 2.0;
        EXPECT_LE(std::abs(account->balance_error()), 200.0 * (tolerance * energy + 1e-3 * tolerance * speed))
            << frequency << " " << viscosity << " " << tolerance;
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Methods, EnergyAccount,
                         testing::Values(MethodName::cvode, MethodName::ida, MethodName::arkode, MethodName::odeint),
                         [](const auto& method) { return std::string(name(method.param)); });

}  // namespace
}  // namespace viscobar::testing_energy_account

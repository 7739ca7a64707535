// Derivatives against closed forms.
#include <gtest/gtest.h>

#include <cmath>

#include "support/falling_bar.hpp"
#include "viscobar/case/case.hpp"
#include "viscobar/case/recording.hpp"

namespace {

using namespace viscobar;

struct Rebound {
  double viscosity, time_rate, speed_rate;
};

// A Kelvin-Voigt bar thrown at speed 1, in touch at t = 0, right end free, rho = E = L = 1: in Laplace space its
// reaction is R = (1 + b s)^(1/2) / s tanh(s / (1 + b s)^(1/2)). It leaves at the first zero of R, and then its mean
// velocity is the impulse less 1; their derivatives by b follow from that of R.
Case rebound(double viscosity, std::size_t elements, double tolerance) {
  Case run;
  run.scene = falling_bar(0.0, 1.0, viscosity);
  run.elements = elements;
  run.method = MethodName::rigid;
  run.tolerance = {tolerance};
  run.end = 2.2;
  run.output_every = 0.1;
  return run;
}

TEST(ClosedForms, TheReboundOfAViscousBarHasItsDerivativesByTheViscosity) {
  for (const auto& [viscosity, time_rate, speed_rate] :
       {Rebound{0.1, -0.8744337027, -1.668763981}, Rebound{1.0, -0.3988366269, -0.1793220569}}) {
    Case run = rebound(viscosity, 200, 1e-10);
    run.directions = {direction(run, "bar.viscosity")};
    const Recording found = record(run);
    ASSERT_EQ(found.events.size(), 2u);
    EXPECT_EQ(found.events[0].sensitivities[0].time, 0.0);
    EXPECT_NEAR(found.events[1].sensitivities[0].time, time_rate, 1e-6);
    EXPECT_NEAR(found.statistics.sensitivity->impulse_left[0], speed_rate, 1e-6);
  }
}

// A rigid flight: it closes at gap / speed, with the speed.
TEST(ClosedForms, AFlightEndsLaterByTheGapOverTheSpeed) {
  Case run = rebound(0.3, 20, 1e-8);
  run.scene.left = Obstacle{0.5};
  run.end = 3.0;
  run.directions = {direction(run, "left.gap"), direction(run, "bar.modulus")};
  const Recording found = record(run);
  ASSERT_GE(found.events.size(), 1u);
  EXPECT_NEAR(found.events[0].sensitivities[0].time, 1.0, 1e-12);
  EXPECT_NEAR(found.events[0].sensitivities[1].time, 0.0, 1e-12);
  EXPECT_NEAR(found.events[0].sensitivities[0].velocity, 0.0, 1e-10);
  // A later contact changes the motion after it, and the way that the bar has come.
  ASSERT_EQ(found.events.size(), 2u);
  EXPECT_NEAR(found.events[1].sensitivities[0].time, 1.0, 1e-6);
  EXPECT_NEAR(found.statistics.sensitivity->impulse_left[0], 0.0, 1e-6);
}

// One element between a fixed end and a lumped mass on it: u'' m + eta u' / L + E u / L = 0, m = rho L / 2.
TEST(ClosedForms, AnElementAloneIsASpringAndAMass) {
  Case run;
  run.scene.bar = {1.0, 2.0, 3.0, 0.0};
  run.scene.right = Fixed{};
  run.scene.displacement = [](double x) { return (1.0 - x) * (1.0 - x); };
  run.scene.velocity = [](double) { return 0.0; };
  run.elements = 1;
  run.mass = Mass::lumped;
  run.method = MethodName::cvode;
  run.tolerance = {1e-10};
  run.end = 5.0;
  run.output_every = 0.5;
  run.directions = {direction(run, "bar.modulus"), direction(run, "bar.density"), direction(run, "bar.length"),
                    direction(run, "bar.viscosity")};
  const Recording found = record(run);
  const double omega = std::sqrt(3.0);
  for (std::size_t k = 0; k < found.times.size(); ++k) {
    const double t = found.times[k];
    // u = cos(omega t), omega^2 = 2 E / (rho L^2); neither u_0(0) nor the wall moves with L.
    const double by_omega = -t * std::sin(omega * t);
    EXPECT_NEAR(found.sensitivities[0].u[2 * k], by_omega * omega / (2.0 * 3.0), 1e-7);
    EXPECT_NEAR(found.sensitivities[1].u[2 * k], -by_omega * omega / (2.0 * 2.0), 1e-7);
    EXPECT_NEAR(found.sensitivities[2].u[2 * k], by_omega * -omega, 1e-6);
    // u = exp(-d t) (cos w t + d/w sin w t), d = eta / (2 m L) = eta / 2 at eta = 0
    EXPECT_NEAR(found.sensitivities[3].u[2 * k], 0.5 * (-t * std::cos(omega * t) + std::sin(omega * t) / omega), 1e-7);
  }
}

}  // namespace

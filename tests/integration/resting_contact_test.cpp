// Contacts with mass that come to rest, with and without a restitution, on springs far stiffer than the tolerance: the
// judge is the exponential method.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "support/falling_bar.hpp"
#include "support/paper_throw.hpp"
#include "support/pressed_bar.hpp"
#include "viscobar/case/recording.hpp"

namespace viscobar::testing_resting_contact {
namespace {

// max |u - u of the exponential method|, in promises of the tolerance.
double error(Case run, MethodName method, double relative, double absolute) {
  run.method = MethodName::exponential;
  const Recording exact = record(run);
  run.method = method;
  run.tolerance = {relative, absolute};
  const Recording mine = record(run);
  double largest = 0.0, off = 0.0;
  for (std::size_t i = 0; i < exact.u.size(); ++i) {
    largest = std::max(largest, std::abs(exact.u[i]));
    off = std::max(off, std::abs(mine.u[i] - exact.u[i]));
  }
  return off / (100.0 * (relative * largest + absolute));
}

constexpr MethodName adaptive[] = {MethodName::cvode, MethodName::ida, MethodName::arkode, MethodName::odeint};

TEST(RestingContact, OpensOnceAndInTimeWhereTheToleranceIsAboveThePenetration) {
  Case run = pressed_bar_of_four();
  run.epsilon = 1e-7;
  run.restitution = 0.0;
  for (const MethodName method : adaptive) EXPECT_LT(error(run, method, 1e-6, 1e-9), 1.0) << name(method);
  run.method = MethodName::arkode;
  std::vector<double> openings;
  for (const Event& event : record(run).events)
    if (event.where == Where::left && event.change == Change::opening && event.time > 7.0 && event.time < 8.0)
      openings.push_back(event.time);
  ASSERT_EQ(openings.size(), 1u);
  EXPECT_NEAR(openings[0], 7.2439, 1e-4);
}

TEST(RestingContact, GivesNoEnergyAtAnEventOfTheOtherContact) {
  Case run = pressed_bar_of_four();
  run.restitution = 0.3;
  run.epsilon = 1e-10;
  for (const MethodName method : adaptive) {
    EXPECT_LT(error(run, method, 1e-5, 1e-9), 1.0) << name(method);
    EXPECT_LT(error(run, method, 1e-4, 1e-8), 1.0) << name(method);
    EXPECT_LT(error(run, method, 1e-8, 1e-4), 1.0) << name(method);
  }
  run.epsilon = 3.0392964541406487e-9;
  EXPECT_LT(error(run, MethodName::arkode, 1e-8, 1e-11), 1.0);
  run.restitution = 0.5;
  run.epsilon = 1.36e-11;
  for (const MethodName method : adaptive) EXPECT_LT(error(run, method, 1e-9, 1e-12), 1.0) << name(method);
}

TEST(RestingContact, KeepsThePromiseOnTheSmallestMesh) {
  Case run = pressed_bar_of_two();
  run.restitution = 0.3;
  run.epsilon = 1e-9;
  for (const MethodName method : adaptive) {
    EXPECT_LT(error(run, method, 1e-6, 1e-9), 1.0) << name(method);
    EXPECT_LT(error(run, method, 1e-10, 1e-13), 1.0) << name(method);
  }
}

TEST(RestingContact, OpensWhereItsRowPullsDownToEveryEpsilon) {
  Case run = paper_throw(0.01);
  run.restitution = 0.0;
  run.output_every = 0.05;
  for (const double epsilon : {1e-6, 1e-11, 1e-13, 1e-14, 1e-16}) {
    run.epsilon = epsilon;
    for (const MethodName method : adaptive) EXPECT_LT(error(run, method, 1e-6, 1e-9), 1.0) << name(method) << epsilon;
  }
}

// The rate of a massless node was a difference of forces of size gap / epsilon, over the viscosity: the energy account
// of the methods whose account is an integral over their steps had 2.8 dissipated of 0.5.
TEST(RestingContact, KeepsTheEnergyAccountOnMasslessNodesAtEveryEpsilon) {
  Case run;
  run.scene = falling_bar(0.1, 1.0, 0.001);
  run.elements = 8;
  run.mass = Mass::redistributed;
  run.end = 3.0;
  run.tolerance = {1e-8, 1e-11};
  for (const double viscosity : {0.001, 0.01})
    for (const double epsilon : {1e-10, 1e-13, 1e-16, 1e-17, 1e-18}) {
      run.scene.bar.viscosity = viscosity;
      run.epsilon = epsilon;
      for (const MethodName method : adaptive) {
        run.method = method;
        Observers observers;
        observers.energy = true;
        const EnergyAccount energy = *simulate(resolve(run), observers).energy;
        // Energy is quadratic: twice the promise of u and w.
        EXPECT_LT(std::abs(energy.balance_error()), 2 * 100 * 1e-8 * energy.initial) << name(method) << " " << epsilon;
      }
    }
}

}  // namespace
}  // namespace viscobar::testing_resting_contact

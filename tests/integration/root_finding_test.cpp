// Cases in which root finding by signs at the ends of a step fails, silently or for ever: each must be caught or come
// out right, by every stepwise method.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>
#include <string>
#include <vector>

#include "support/run_trace.hpp"
#include "viscobar/integration/integrate.hpp"

namespace viscobar::testing_root_finding {
namespace {

constexpr double rounding = std::numeric_limits<double>::epsilon();
constexpr double constant = 100.0;  // the multiple of the tolerance that errors stay below (docs/methods.md)
constexpr double nan = std::numeric_limits<double>::quiet_NaN();

template <class Method>
struct RootFinding : testing::Test {};
using Methods = testing::Types<Cvode, Ida, Arkode, Odeint>;
TYPED_TEST_SUITE(RootFinding, Methods);

// A bar that moves as one point: u'' = history(t), u(0) = 0, u'(0) = velocity, over an obstacle at its left end.
Scene point(double gap, double velocity, TimeFunction history) {
  Scene scene;
  scene.left = Obstacle{gap};
  scene.displacement = [](double) { return 0.0; };
  scene.velocity = [velocity](double) { return velocity; };
  if (history) scene.load = SeparableLoad{[](double) { return 1.0; }, std::move(history)};
  return scene;
}

BarSystem system_of(const Scene& scene) { return BarSystem(scene, Mesh{1.0, 2}, Mass::lumped); }

double one(double) { return 1.0; }

template <class Method>
Method with(double epsilon, double tolerance) {
  Method method;
  method.penalty.epsilon = epsilon;
  method.tolerance = {tolerance, 1e-3 * tolerance};
  return method;
}

TYPED_TEST(RootFinding, TwoCrossingsInsideOneStepAreBothFound) {
  // u = -t + t^2/2 dives below -1/2 + depth for 2 sqrt(2 depth) about t = 1.
  const double depth = 1e-9, half = std::sqrt(2 * depth), tolerance = 1e-13;
  const auto method = with<TypeParam>(1.0, tolerance);
  const std::vector<double> times = {0.0, 2.0};

  // The steps of the same motion above the obstacle: one of them takes in both crossings, its ends are above.
  const BarSystem above = system_of(point(0.6, -1.0, one));
  const RunTrace undisturbed = record(above, times, method);
  const auto step_end = std::ranges::upper_bound(undisturbed.progress, 1.0);
  ASSERT_NE(step_end, undisturbed.progress.end());
  ASSERT_GT(*step_end, 1 + half);
  ASSERT_LT(*(step_end - 1), 1 - half);

  const BarSystem diving = system_of(point(0.5 - depth, -1.0, one));
  const RunTrace run = record(diving, times, method);
  ASSERT_EQ(run.events.size(), 2u);
  EXPECT_EQ(run.events[0].change, Change::closing);
  EXPECT_EQ(run.events[1].change, Change::opening);
  // |u'| dt = du; while it is closed the spring turns the node by less than half^2 / epsilon of its velocity.
  const double late = constant * tolerance / half;
  EXPECT_NEAR(run.events[0].time, 1 - half, late);
  EXPECT_NEAR(run.events[1].time, 1 + half, late + half * half);
}

TYPED_TEST(RootFinding, ARootOfEvenMultiplicityIsATouchAndDoesNoHarm) {
  const double tolerance = 1e-8;
  const BarSystem system = system_of(point(0.5, -1.0, one));
  const RunTrace run = record(system, std::vector{0.0, 1.0, 2.0}, with<TypeParam>(1e-3, tolerance));
  EXPECT_NEAR(run.u[1][0], -0.5, constant * tolerance);
  EXPECT_NEAR(run.u[2][0], 0.0, constant * tolerance);
  EXPECT_LE(run.events.size(), 2u);
}

TYPED_TEST(RootFinding, AnEvenRootDeeperThanItsRoundingIsFound) {
  const double depth = 1e-11;
  const BarSystem system = system_of(point(0.5 - depth, -1.0, one));
  const RunTrace run = record(system, std::vector{0.0, 2.0}, with<TypeParam>(1.0, 1e-13));
  ASSERT_EQ(run.events.size(), 2u);
  // At a graze an error of u, here 1e-12 by what was asked for, is one of the depth.
  EXPECT_NEAR(run.events[1].time - run.events[0].time, 2 * std::sqrt(2 * depth), std::sqrt(2 * depth));
}

TYPED_TEST(RootFinding, AContactThatStartsAtZeroIsToldAndTheNextRootIsKept) {
  const auto method = with<TypeParam>(1e-3, 1e-8);
  const BarSystem inwards = system_of(point(0.0, -1.0, {}));
  const RunTrace in = record(inwards, std::vector{0.0, 1.0}, method);
  ASSERT_FALSE(in.events.empty());
  EXPECT_EQ(in.events[0].time, 0.0);
  EXPECT_EQ(in.events[0].velocity, -1.0);

  // u = t - t^2/2 leaves and is back at t = 2.
  const BarSystem outwards = system_of(point(0.0, 1.0, [](double) { return -1.0; }));
  const RunTrace out = record(outwards, std::vector{0.0, 2.5}, method);
  ASSERT_FALSE(out.events.empty());
  EXPECT_EQ(out.events[0].change, Change::closing);
  EXPECT_NEAR(out.events[0].time, 2.0, constant * 1e-8);
}

TYPED_TEST(RootFinding, AnIndicatorThatIsZeroForAWhileLosesNoRoot) {
  // Stands on both obstacles, where nothing moves it until the load sets in.
  Scene scene = point(0.0, 0.0, [](double t) { return t < 1.0 ? 0.0 : -1.0; });
  scene.right = Obstacle{0.0};
  const BarSystem system = system_of(scene);
  const double tolerance = 1e-8, epsilon = 1e-2;
  const RunTrace run = record(system, std::vector{0.0, 0.5, 1.01}, with<TypeParam>(epsilon, tolerance));
  EXPECT_EQ(run.u[1], (std::vector<double>(3, 0.0)));
  // The step across the jump may leave the surface to either side by what it may err; u = -(t - 1)^2/2 tells a contact
  // late by sqrt(2 du).
  for (const Where where : {Where::left, Where::right}) {
    Change last = Change::opening;
    for (const Event& event : run.events) {
      if (event.where != where) continue;
      last = event.change;
      EXPECT_NEAR(event.time, 1.0, std::sqrt(2 * constant * tolerance * 1e-3));
    }
    EXPECT_EQ(last, Change::closing);
  }
  // Both ends on a spring, 1/epsilon each, and the bar of mass 1 between them all but rigid.
  EXPECT_NEAR(run.u[2][1], -0.01 * 0.01 / 2, 1e-7);
}

TYPED_TEST(RootFinding, AnIndicatorThatReachesZeroAndStaysThereEndsNoRun) {
  // The load brakes the bar to a stand exactly where the obstacle is, then ceases.
  const double tolerance = 1e-8;
  const BarSystem system = system_of(point(0.5, -1.0, [](double t) { return t < 1.0 ? 1.0 : 0.0; }));
  const RunTrace run = record(system, std::vector{0.0, 1.0, 2.0, 3.0}, with<TypeParam>(1e-3, tolerance));
  EXPECT_TRUE(run.statistics.completed);
  // The error of the velocity moves it on.
  for (std::size_t k = 1; k < 4; ++k) EXPECT_NEAR(run.u[k][0], -0.5, 3 * constant * tolerance) << k;
}

// The message of the error that the run has to end with.
template <class Method>
std::string message(const BarSystem& system, double end, const Method& method, Statistics& reached) {
  try {
    record(system, std::vector{0.0, end}, method);
  } catch (const IntegrationError& error) {
    reached = error.statistics;
    return error.what();
  }
  return "no error";
}

TYPED_TEST(RootFinding, ANanInsideTheBracketIsAnErrorThatNamesTheLoad) {
  // Where it appears the bar is about to close its contact: signs at the ends of that step differ.
  const BarSystem system = system_of(point(0.5, -1.0, [](double t) { return t > 0.499999 ? nan : 0.0; }));
  Statistics reached;
  const std::string what = message(system, 1.0, with<TypeParam>(1e-4, 1e-6), reached);
  EXPECT_NE(what.find("load"), std::string::npos) << what;
  EXPECT_NE(what.find("not a number"), std::string::npos) << what;
  EXPECT_FALSE(reached.completed);
  EXPECT_LE(reached.reached_time, 0.5);
}

TYPED_TEST(RootFinding, ARightHandSideThatIsNanStopsAtOnceAndSaysWhere) {
  const BarSystem system = system_of(point(10.0, -1.0, [](double t) { return t > 0.5 ? nan : std::sin(40 * t); }));
  const BarSystem healthy = system_of(point(10.0, -1.0, [](double t) { return std::sin(40 * t); }));
  const RunTrace until = record(healthy, std::vector{0.0, 0.5}, with<TypeParam>(1e-4, 1e-6));
  Statistics reached;
  const std::string what = message(system, 1.0, with<TypeParam>(1e-4, 1e-6), reached);
  EXPECT_NE(what.find("load"), std::string::npos) << what;
  EXPECT_NE(what.find("not a number"), std::string::npos) << what;
  EXPECT_NE(what.find("t = 0.5"), std::string::npos) << what;
  // No retreat in ever smaller steps: those to the place, and a few.
  EXPECT_LE(reached.steps, until.statistics.steps + 10);
}

TYPED_TEST(RootFinding, ASolutionThatOverflowsIsAnError) {
  const BarSystem system = system_of(point(10.0, -1.0, [](double t) { return t > 0.5 ? 1.7e308 : 0.0; }));
  Statistics reached;
  const std::string what = message(system, 10.0, with<TypeParam>(1e-4, 1e-6), reached);
  EXPECT_NE(what, "no error");
  EXPECT_FALSE(reached.completed);
}

TYPED_TEST(RootFinding, AnIndicatorFarBelowOneIsSeenAsOneOfOrderOne) {
  // 2^-664 is 1e-200, whose square is 0; a power of two changes no digit of any step.
  const double tiny = std::exp2(-664);
  const auto run_at = [](double scale) {
    TypeParam method = with<TypeParam>(1e-3, 1e-8);
    *method.tolerance.absolute *= scale;
    Scene scene = point(0.1 * scale, -scale, {});
    scene.bar.viscosity = 0.05;
    const BarSystem system = system_of(scene);
    return record(system, uniform_times(0.1, 20), method);
  };
  const RunTrace usual = run_at(1.0), small = run_at(tiny);
  ASSERT_EQ(small.events.size(), usual.events.size());
  ASSERT_GE(usual.events.size(), 2u);
  for (std::size_t i = 0; i < usual.events.size(); ++i) EXPECT_EQ(small.events[i].time, usual.events[i].time);
  for (std::size_t k = 0; k < usual.u.size(); ++k) EXPECT_EQ(small.u[k][0], tiny * usual.u[k][0]) << k;
}

TYPED_TEST(RootFinding, ALoadThatThrowsEndsTheRunWithWhatItSaid) {
  const BarSystem system = system_of(point(10.0, -1.0, [](double t) -> double {
    if (t > 0.5) throw std::runtime_error("the table ends at 0.5");
    return std::sin(t);
  }));
  try {
    record(system, std::vector{0.0, 1.0}, with<TypeParam>(1e-4, 1e-6));
    FAIL() << "no error";
  } catch (const std::runtime_error& error) {
    EXPECT_NE(std::string(error.what()).find("the table ends at 0.5"), std::string::npos) << error.what();
  }
  // No std::exception: no C frame may see it either.
  const BarSystem other = system_of(point(10.0, -1.0, [](double t) -> double {
    if (t > 0.5) throw 1;
    return std::sin(t);
  }));
  EXPECT_ANY_THROW(record(other, std::vector{0.0, 1.0}, with<TypeParam>(1e-4, 1e-6)));
}

TYPED_TEST(RootFinding, AnEventAtAnOutputTimeMayBeFollowedByAnotherOutputARoundingLater) {
  const double contact = 0.5;
  const std::vector<double> times = {
      0.0, 0.25, std::nextafter(contact, 0.0), contact, std::nextafter(contact, 1.0), contact + 1e-15, 1.0};
  const BarSystem system = system_of(point(contact, -1.0, {}));
  const RunTrace run = record(system, times, with<TypeParam>(1e-3, 1e-8));
  EXPECT_EQ(run.times, times);
  ASSERT_FALSE(run.events.empty());
  EXPECT_NEAR(run.events[0].time, contact, 1000 * rounding);
  for (std::size_t k = 2; k < 6; ++k) EXPECT_NEAR(run.u[k][0], -contact, 1000 * rounding);
}

TYPED_TEST(RootFinding, AnEventAtTheEndOfTheRunEndsIt) {
  const BarSystem system = system_of(point(1.0, -1.0, {}));
  for (const double end : {1.0, std::nextafter(1.0, 0.0), std::nextafter(1.0, 2.0), 1.0 + 1e-14}) {
    const RunTrace run = record(system, std::vector{0.0, end}, with<TypeParam>(1e-3, 1e-8));
    EXPECT_TRUE(run.statistics.completed);
    EXPECT_EQ(run.times.back(), end);
    EXPECT_NEAR(run.u.back()[0], -1.0, 1000 * rounding);
  }
}

TYPED_TEST(RootFinding, ADiscontinuousForceMakesOneChangeNotDozens) {
  // A dashpot's force jumps with the contact. The flat bar on a span obstacle is a point on spring and dashpot, which
  // leaves with the restitution times its speed after half a period pi / (omega sqrt(1 - zeta^2)).
  Scene scene = point(0.5, -1.0, {});
  scene.left = Free{};
  scene.span = Obstacle{0.5};
  const double tolerance = 1e-8, restitution = 0.5;
  auto method = with<TypeParam>(1e-4, tolerance);
  method.penalty.restitution = restitution;
  const BarSystem system = system_of(scene);
  const RunTrace run = record(system, std::vector{0.0, 1.0}, method);
  ASSERT_EQ(run.events.size(), 6u);  // three nodes, in and out
  const double zeta = damping_ratio(restitution);
  const double contact = 1e-2 * std::numbers::pi / std::sqrt(1 - zeta * zeta);
  for (std::size_t i = 0; i < 6; ++i) {
    EXPECT_EQ(run.events[i].change, i < 3 ? Change::closing : Change::opening);
    EXPECT_NEAR(run.events[i].time, i < 3 ? 0.5 : 0.5 + contact, constant * tolerance);
  }
  EXPECT_NEAR(run.v.back()[1], restitution, constant * tolerance);
}

TYPED_TEST(RootFinding, ALoadThatJumpsInsideAStepMakesOneChange) {
  // u = -t^2/2 would reach the obstacle at t = 1; at 0.99 the load is turned up, and the bar meets it earlier.
  const double tolerance = 1e-8, jump = 0.99;
  const BarSystem system = system_of(point(0.5, 0.0, [=](double t) { return t < jump ? -1.0 : -100.0; }));
  const RunTrace run = record(system, std::vector{0.0, 1.0}, with<TypeParam>(1.0, tolerance));
  const double speed = jump, rest = 0.5 - jump * jump / 2;
  const double meets = jump + (std::sqrt(speed * speed + 200 * rest) - speed) / 100;
  ASSERT_EQ(run.events.size(), 1u);
  EXPECT_NEAR(run.events[0].time, meets, constant * tolerance);
}

TYPED_TEST(RootFinding, ThousandsOfStepsBetweenTwoOutputsAreNoFailure) {
  // cos(omega t) at the highest frequency of the mesh, 2 c / (h / 2) for two elements of lumped mass: 4.
  Scene scene = point(10.0, 0.0, {});
  scene.displacement = [](double x) { return std::cos(2 * std::numbers::pi * x); };
  const double tolerance = 1e-8, end = 100.0;
  const BarSystem system = system_of(scene);
  const RunTrace run = record(system, std::vector{0.0, end}, with<TypeParam>(1e-3, tolerance));
  EXPECT_GT(run.statistics.steps, 500u);
  EXPECT_NEAR(run.u.back()[0], std::cos(4 * end), constant * tolerance);
}

}  // namespace
}  // namespace viscobar::testing_root_finding

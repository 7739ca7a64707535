// Scenes with many contact changes: every one is counted, and none costs what starting anew would.
#include <gtest/gtest.h>

#include "run/step_failure.hpp"
#include "run/watchdog.hpp"
#include "support/bouncing_bar.hpp"
#include "support/paper_throw.hpp"
#include "support/run_trace.hpp"
#include "viscobar/case/case.hpp"

namespace viscobar::testing_storm {
namespace {

Case chatter(double epsilon, MethodName method, double tolerance) {
  Case run = paper_throw(0.01);
  run.epsilon = epsilon;
  run.method = method;
  run.tolerance = {tolerance, 1e-3 * tolerance};
  return run;
}

struct Trace {
  std::vector<Event> events;
  Statistics statistics;
};

Trace trace(const Case& run) {
  Trace result;
  Observers observers;
  observers.event = [&](const Event& event) { result.events.push_back(event); };
  result.statistics = simulate(resolve(run), observers);
  return result;
}

constexpr MethodName adaptive[] = {MethodName::cvode, MethodName::ida, MethodName::arkode, MethodName::odeint};

// agreement_test.cpp holds the times down to epsilon = 1e-6.
TEST(Storm, EveryBounceIsCounted) {
  for (const double epsilon : {1e-5, 1e-7, 1e-8}) {
    const std::size_t changes = trace(chatter(epsilon, MethodName::exponential, 1.0)).events.size();
    EXPECT_GT(changes, 300u);
    for (const MethodName method : adaptive)
      EXPECT_EQ(trace(chatter(epsilon, method, 1e-8)).events.size(), changes) << name(method) << " " << epsilon;
  }
}

TEST(Storm, UnderASpanCountsEveryNodesBounces) {
  Case run = chatter(1e-3, MethodName::exponential, 1.0);
  run.scene.left = run.scene.right = Free{};
  run.scene.span = Obstacle{0.1};
  run.scene.displacement = [](double x) { return 0.02 * std::cos(7.0 * x); };
  run.scene.velocity = [](double) { return -1.0; };
  run.scene.load = SteadyLoad{[](double) { return -10.0; }};
  run.end = run.output_every = 2.0;
  const std::size_t changes = trace(run).events.size();
  EXPECT_GT(changes, 100u);
  for (const MethodName method : adaptive) {
    run.method = method;
    run.tolerance = {1e-8, 1e-11};
    EXPECT_EQ(trace(run).events.size(), changes) << name(method);
  }
}

// A multistep method begins anew at each change, at order one: 19 steps (Adams' formulas) or 41 (ida) a bounce here.
// One-step formulas have no history to lose: six.
TEST(Storm, ABounceCostsAMethodItsStart) {
  for (const double epsilon : {1e-6, 1e-7, 1e-8}) {
    for (const auto& [method, most] :
         {std::pair{MethodName::cvode, 20u}, {MethodName::ida, 43u}, {MethodName::arkode, 8u}}) {
      const Trace run = trace(chatter(epsilon, method, 1e-6));
      EXPECT_LT(run.statistics.steps, most * run.events.size()) << name(method) << " " << epsilon;
    }
  }
}

TEST(Storm, KeepsTheEnergyAccount) {
  for (const MethodName method : {MethodName::cvode, MethodName::ida}) {
    Case run = chatter(1e-6, method, 1e-8);
    Observers observers;
    observers.energy = true;
    const Statistics statistics = simulate(resolve(run), observers);
    // As in adaptive_test.cpp: energy is quadratic, and errors stay below 100 times the tolerance.
    EXPECT_LE(std::abs(statistics.energy->balance_error()), 2 * 100 * 1e-8 * statistics.energy->initial)
        << name(method);
  }
}

// At t = 1e6 a node at speed 3 moves by 7e-10 in a rounding of the time: its clearance at a change cannot be smaller,
// and was taken for a new change.
TEST(Storm, AFastNodeLateInARunChangesItsContactOnce) {
  Case run = chatter(1e-3, MethodName::cvode, 1e-6);
  run.scene.right = Free{};
  run.scene.displacement = [](double) { return 0.0; };
  run.scene.velocity = [](double) { return -3.0; };
  for (const MethodName method : adaptive) {
    run.method = method;
    const BarSystem system = resolve(run).system();
    std::vector<std::size_t> changes;
    for (const double start : {0.0, 1e3, 1e6}) {
      std::size_t count = 0;
      Observers observers;
      observers.event = [&](const Event&) { ++count; };
      simulate(resolve(run), system, std::vector{start, start + 2.0}, observers);
      changes.push_back(count);
    }
    EXPECT_GE(changes[0], 2u);
    EXPECT_EQ(changes[1], changes[0]) << name(method);
    EXPECT_EQ(changes[2], changes[0]) << name(method);
  }
}

// Touching and moving in, an undisplaced bar closes its contact at the start and makes its first step by the scale of a
// displacement of zero: as short as the rounding of any start but 0.
TEST(Storm, ABarThatStartsOnItsObstacleMovingInMovesAlikeFromAnyTime) {
  Case run = chatter(1e-2, MethodName::cvode, 1e-6);
  run.scene.left = Obstacle{0.0};
  run.scene.right = Free{};
  run.scene.displacement = [](double) { return 0.0; };
  run.scene.velocity = [](double) { return -1.0; };
  for (const double epsilon : {1e-2, 1e-6}) {
    run.epsilon = epsilon;
    for (const MethodName method : adaptive) {
      run.method = method;
      const BarSystem system = resolve(run).system();
      std::vector<double> reference;
      for (const double start : {0.0, 1.0, 131.0}) {
        std::vector<double> u;
        Observers observers;
        observers.snapshot = [&](const Snapshot& now) { u.insert(u.end(), now.u.begin(), now.u.end()); };
        EXPECT_NO_THROW(simulate(resolve(run), system, std::vector{start, start + 1.0, start + 2.0}, observers))
            << name(method) << " from " << start;
        if (start == 0.0) reference = u;
        ASSERT_EQ(u.size(), reference.size()) << name(method) << " from " << start;
        const double bound = 2 * 100 * (1e-6 * 2.0 + 1e-9);  // the promise for both, max|u| = 2
        for (std::size_t i = 0; i < u.size(); ++i) ASSERT_NEAR(u[i], reference[i], bound) << name(method);
      }
    }
  }
}

TEST(Storm, BouncingForEverEndsAtTheEndForEveryMethod) {
  Case run = bouncing_bar(40.0);
  run.output_every = 40.0;
  for (const MethodName method : adaptive) {
    run.method = method;
    Observers observers;
    observers.energy = true;
    const Statistics statistics = simulate(resolve(run), observers);
    EXPECT_TRUE(statistics.completed) << name(method);
    EXPECT_GT(statistics.events, 400u) << name(method);
    EXPECT_NEAR(statistics.energy->balance_error(), 0.0, 2 * 100 * run.tolerance.relative * statistics.energy->initial)
        << name(method);
  }
}

TEST(Watchdog, RefusesAPaceThatDoesNotReachTheEnd) {
  Watchdog guard(0.0, 1.0, 100, 1e4);
  for (int k = 1; k < 1000; ++k) EXPECT_NO_THROW(guard.step(1e-4 * k, 0)) << "1e4 steps in all";
  Watchdog slow(0.0, 1.0, 100, 1e4);
  for (int k = 1; k < 200; ++k) slow.step(9e-5 * k, 0);
  EXPECT_THROW(slow.step(9e-5 * 200, 0), StepFailure);
}

TEST(Watchdog, LetsARunGoOnWhosePaceRecovers) {
  Watchdog settling(0.0, 1.0, 100, 1e4);
  double t = 0.0;
  for (int look = 0; look < 20; ++look)
    for (int k = 0; k < 100; ++k) EXPECT_NO_THROW(settling.step(t += 1e-8 * std::pow(3.0, look), 0));
}

TEST(Watchdog, RefusesStepsThatLeadNowhereAndSaysWhetherContactsAreTheReason) {
  for (const auto& [changes, why] : {std::pair{0u, Failure::length}, {50u, Failure::chatter}}) {
    Watchdog guard(0.0, 1.0, 100, 1e4);
    try {
      for (int k = 1; k <= 100; ++k) guard.step(0.0, changes);
      FAIL();
    } catch (const StepFailure& failure) {
      EXPECT_EQ(failure.why, why) << failure.what();
    }
  }
}

// A step of 1e-11 for each change: the end is 1e11 steps away at each look, the second of which ends the run.
TEST(Watchdog, RefusesAChatterWithoutEndAfterFortyThousandChanges) {
  Watchdog guard(0.0, 1.0);
  for (std::size_t k = 1; k < 40'000; ++k) ASSERT_NO_THROW(guard.step(1e-11 * static_cast<double>(k), k));
  EXPECT_THROW(guard.step(4e-7, 40'000), StepFailure);
}

TEST(Watchdog, LetsARunReachItsEndHoweverSlowly) {
  Watchdog guard(0.0, 1.0, 100, 1e4);
  for (int k = 1; k < 100; ++k) guard.step(0.5, 0);
  EXPECT_NO_THROW(guard.step(1.0, 0));
}

TEST(Watchdog, EndsStepsThatDoNotAdvanceTheTime) {
  Watchdog guard(0.0, 1.0);
  for (int k = 0; k < 100; ++k) EXPECT_NO_THROW(guard.attempt(0.5, 0.5));
  EXPECT_NO_THROW(guard.attempt(0.5, 0.6)) << "one that leads on ends the count";
  for (int k = 0; k < 100; ++k) guard.attempt(0.6, 0.6);
  EXPECT_THROW(guard.attempt(0.6, 0.6), StepFailure);
}

TEST(Watchdog, EndsAContactThatTogglesAtOneTimeButNoneThatBounces) {
  Watchdog guard(0.0, 1.0);
  for (int k = 0; k < 1000; ++k) EXPECT_NO_THROW(guard.change(1e-9 * k, 0)) << "a bounce takes time";
  for (int k = 0; k < 20; ++k) EXPECT_NO_THROW(guard.change(0.5, 1));
  EXPECT_NO_THROW(guard.change(0.5, 2)) << "another contact";
  for (int k = 0; k < 20; ++k) guard.change(0.5, 2);
  EXPECT_EQ(guard.toggles(), 20u);
  EXPECT_THROW(guard.change(0.5, 2), StepFailure);
}

}  // namespace
}  // namespace viscobar::testing_storm

// Message of an adaptive method that cannot go on, and the results that it leaves. The words of every return flag: see
// return_flags_test.cpp; here those that a scene can bring about.
#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>

#include "run/parts.hpp"
#include "support/paper_throw.hpp"
#include "viscobar/case/case.hpp"

namespace viscobar::testing_failure {
namespace {

Case throw_under(Load load, MethodName method) {
  Case run = paper_throw(0.01);
  run.elements = 8;
  run.scene.load = std::move(load);
  run.method = method;
  run.end = 1.0;
  run.output_every = 0.01;
  run.tolerance.absolute = 1e-9;  // whatever the size of the load
  return run;
}

struct Failed {
  std::string what;
  Statistics statistics;
  double last_output = -1.0;
};

Failed fail(const Case& run, std::span<const double> times) {
  Failed failed;
  Observers observers;
  observers.snapshot = [&](const Snapshot& now) { failed.last_output = now.time; };
  try {
    simulate(resolve(run), times, observers);
    ADD_FAILURE() << name(run.method) << " ran through";
  } catch (const IntegrationError& error) {
    failed.what = error.what();
    failed.statistics = error.statistics;
  }
  return failed;
}

bool has(const Failed& failed, const std::string& part) { return failed.what.find(part) != std::string::npos; }

constexpr MethodName adaptive[] = {MethodName::cvode, MethodName::ida, MethodName::arkode, MethodName::odeint};

class Failure : public testing::TestWithParam<MethodName> {};

// Up to half of the time all is well: everything until then is kept.
void expect_half_kept(const Failed& failed) {
  EXPECT_FALSE(failed.statistics.completed);
  EXPECT_NEAR(failed.statistics.reached_time, 0.5, 0.03) << failed.what;
  EXPECT_LE(failed.statistics.reached_time, 0.5);
  EXPECT_EQ(failed.last_output, failed.statistics.reached_time) << "the state reached was told";
  EXPECT_GT(failed.statistics.steps, 0u);
}

TEST_P(Failure, AContactThatLastsAFewRoundingsOfTheTimeIsNamed) {
  Case run = paper_throw(0.01);
  run.method = GetParam();
  run.epsilon = 1e-30;  // pi sqrt(m epsilon) = 4e-16
  const Failed failed = fail(run, std::vector{0.0, 1.0, run.end});
  EXPECT_TRUE(has(failed, "a few roundings of t")) << failed.what;
  EXPECT_TRUE(has(failed, "redistributed")) << failed.what;
  EXPECT_FALSE(failed.statistics.completed);
  EXPECT_GT(failed.statistics.reached_time, 1.0);
}

TEST_P(Failure, OfALoadThatThrowsTellsTimeAndPlaceAndItsWords) {
  const Case run = throw_under(GeneralLoad{[](double x, double t) {
                                 if (t > 0.5 && x > 0.3) throw std::runtime_error("the table ends");
                                 return 0.0;
                               }},
                               GetParam());
  const Failed failed = fail(run, run.output_times());
  expect_half_kept(failed);
  EXPECT_TRUE(has(failed, "the load at x = 0.375, t = 0.5")) << failed.what;
  EXPECT_TRUE(has(failed, "the table ends")) << failed.what;
}

TEST_P(Failure, OfALoadThatIsNoNumberTellsTimeAndPlace) {
  const Case run =
      throw_under(GeneralLoad{[](double x, double t) { return x > 0.3 ? std::sqrt(0.5 - t) : 0.0; }}, GetParam());
  const Failed failed = fail(run, run.output_times());
  expect_half_kept(failed);
  EXPECT_TRUE(has(failed, "the load at x = 0.375, t = 0.5")) << failed.what;
  EXPECT_TRUE(has(failed, "is not a number")) << failed.what;
}

TEST_P(Failure, OfAnythingThatALoadThrowsIsNoCrash) {
  const Case run = throw_under(SeparableLoad{[](double) { return 1.0; },
                                             [](double t) {
                                               if (t > 0.5) throw 42;
                                               return 0.0;
                                             }},
                               GetParam());
  const Failed failed = fail(run, run.output_times());
  expect_half_kept(failed);
  EXPECT_TRUE(has(failed, "the history of the load at t = 0.5")) << failed.what;
}

TEST_P(Failure, AtAJumpThatNoStepCanFollowSaysToLookAtTheLoad) {
  const Case run =
      throw_under(SeparableLoad{[](double) { return 1.0; }, [](double t) { return t > 0.5 ? 1e30 : 0.0; }}, GetParam());
  const Failed failed = fail(run, run.output_times());
  expect_half_kept(failed);
  EXPECT_TRUE(has(failed, "keeps the tolerance")) << failed.what;
  EXPECT_TRUE(has(failed, "method.relative_tolerance")) << failed.what;
  EXPECT_TRUE(has(failed, "check the load for jumps")) << failed.what;
}

TEST_P(Failure, OfTheVeryFirstStepKeepsTheStart) {
  const Case run =
      throw_under(SeparableLoad{[](double) { return 1.0; }, [](double t) { return 1e308 * t; }}, GetParam());
  const Failed failed = fail(run, run.output_times());
  EXPECT_EQ(failed.last_output, 0.0);
  EXPECT_TRUE(has(failed, "keeps the tolerance")) << failed.what;
  if (GetParam() != MethodName::odeint) {
    EXPECT_TRUE(has(failed, "returned ")) << "the library's words: " << failed.what;
  }
}

TEST_P(Failure, OfNumbersThatOverflowSaysSo) {
  Case run = paper_throw(0.01);
  run.scene.velocity = [](double x) { return x > 0.5 ? 1e200 : -1e200; };
  run.method = GetParam();
  run.scene.bar.modulus = 1e150;
  run.epsilon = 1e-100;
  const Failed failed = fail(run, run.output_times());
  EXPECT_FALSE(failed.statistics.completed);
  EXPECT_GT(failed.what.size(), 40u) << failed.what;
}

TEST_P(Failure, ToAnEndWithinTheRoundingOfTheStartIsRefusedOrReached) {
  Case run = paper_throw(0.01);
  run.method = GetParam();
  const std::vector<double> times{1.0, std::nextafter(1.0, 2.0)};
  try {
    EXPECT_TRUE(simulate(resolve(run), times, {}).completed);
  } catch (const IntegrationError& error) {
    EXPECT_NE(std::string(error.what()).find("rounding of the time"), std::string::npos) << error.what();
    EXPECT_NE(std::string(error.what()).find("time.end"), std::string::npos) << error.what();
  }
}

INSTANTIATE_TEST_SUITE_P(EveryAdaptiveMethod, Failure, testing::ValuesIn(adaptive),
                         [](const auto& method) { return std::string(name(method.param)); });

// The reference method creeps up to a pole for ever: no load is without a step that resolves it, but none leads past.
TEST(FailureOfTheReference, AtAPoleIsNoHang) {
  const Case run =
      throw_under(SeparableLoad{[](double) { return 1.0; }, [](double t) { return 1.0 / ((0.5 - t) * (0.5 - t)); }},
                  MethodName::exponential);
  const Failed failed = fail(run, run.output_times());
  EXPECT_FALSE(failed.statistics.completed);
  EXPECT_TRUE(has(failed, "at that pace") || has(failed, "load")) << failed.what;
}

// A step that loses its inertia says so itself (return_flags_test.cpp): these are matrices of the inertia alone.
TEST(PartOrFailure, NamesWhatAMatrixThatIsNotPositiveComesFrom) {
  const auto named = [](const auto& cause) {
    try {
      part_or_failure(
          "one", [] { return Statistics{}; }, [&]() -> PartEnd { throw cause; });
    } catch (const IntegrationError& error) {
      return error.failure;
    }
    return viscobar::Failure::memory;
  };
  EXPECT_EQ(named(NotPositive(true)), viscobar::Failure::defect);
  EXPECT_EQ(named(NotPositive(false)), viscobar::Failure::overflow);
  EXPECT_EQ(named(std::domain_error("of a library")), viscobar::Failure::defect);
}

}  // namespace
}  // namespace viscobar::testing_failure

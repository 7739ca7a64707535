#include <gtest/gtest.h>

#include <cmath>

#include "support/paper_throw.hpp"
#include "viscobar/case/end_traces.hpp"
#include "viscobar/studies/limit/limit.hpp"

namespace viscobar {
namespace {

LimitStudy with_derivatives(Case scene, std::vector<double> epsilons) {
  LimitStudy study;
  study.scene = std::move(scene);
  study.scene.step = 1e-3;
  study.epsilons = std::move(epsilons);
  study.budget = 0.0;
  study.derivatives = true;
  return study;
}

Case massless(double viscosity, MethodName method = MethodName::ida) {
  Case scene = paper_throw(viscosity);
  scene.mass = Mass::redistributed;
  scene.method = method;
  return scene;
}

TEST(LocalPower, OnMasslessNodesIsOneByTheDerivativeAndByDifferencesOfRuns) {
  for (const MethodName method : {MethodName::cvode, MethodName::ida, MethodName::arkode}) {
    const LimitResult result = limit_of(with_derivatives(massless(0.1, method), {1e-4, 1e-5, 1e-6}));
    ASSERT_TRUE(result.orders.at(0).local_to_rigid);
    for (const auto local : {&LimitRow::local_largest, &LimitRow::local_mean}) {
      const auto& rows = result.rows;
      for (const LimitRow& row : rows) {
        ASSERT_TRUE(row.*local && (row.*local)->power) << name(method) << " " << row.epsilon;
        // D = c epsilon + O(epsilon^2): 1 - p falls like epsilon, from 1e-3 measured at 1e-4, to the error of p.
        EXPECT_NEAR(*(row.*local)->power, 1.0, 20.0 * row.epsilon + (row.*local)->error) << name(method);
        // 100 tolerances of the displacement, 0.25, in a difference of 0.9 epsilon, four times; and the times, half a
        // thousandth of the run apart.
        EXPECT_LT((row.*local)->error, 2e-8 / row.epsilon + 2e-3) << name(method) << " " << row.epsilon;
      }
      for (std::size_t i = 0; i + 1 < rows.size(); ++i) {
        EXPECT_TRUE((rows[i].*local)->agrees().value_or(false)) << name(method) << " " << rows[i].epsilon;
        EXPECT_NEAR(*(rows[i].*local)->observed, *(rows[i].*local)->mean, 3e-3) << name(method);
      }
      EXPECT_FALSE((rows.back().*local)->observed);
    }
  }
}

// Epsilons 1 % apart: the mean of both ends is then that of the interval to (0.01)^2 p'' / 12 < 1e-4.
TEST(LocalPower, IsThatOfTwoRunsCloseTogetherOnNodesWithMassAndUnderASpanToo) {
  Case massive = paper_throw(0.01);
  massive.restitution = 0.5;
  Case span = paper_throw(0.05);
  span.scene.left = span.scene.right = Free{};
  span.scene.span = Obstacle{0.1};
  span.mass = Mass::lumped;
  span.restitution = 0.5;
  span.scene.velocity = [](double x) { return -1.0 - x; };
  span.end = span.output_every = 1.0;
  for (const Case& scene : {massless(0.01), massless(0.0), massive, span}) {
    const LimitResult result = limit_of(with_derivatives(scene, {1.01e-3, 1e-3, 1e-6}));
    const LimitRow& row = result.rows.front();
    EXPECT_EQ(result.orders.at(0).local_to_rigid, !scene.scene.span.has_value());
    ASSERT_TRUE(row.local_mean && row.local_mean->mean && row.local_largest && row.local_largest->mean);
    EXPECT_NEAR(*row.local_mean->observed, *row.local_mean->mean, 1e-3 + row.local_mean->error);
    // That of the largest hops from one time to the next.
    EXPECT_NEAR(*row.local_largest->observed, *row.local_largest->mean, 1e-3 + row.local_largest->error);
  }
}

TEST(LocalPower, OfTheLargestDifferenceIsAHalfOnNodesWithMassAndOfTheMeanSquareMoreWhereNothingRebounds) {
  // At restitution 0 a bounce is sqrt(epsilon) high, and lasts as long: its part of the mean square is epsilon^(3/4).
  Case scene = paper_throw(0.01);
  scene.restitution = 0.0;
  const LimitResult result = limit_of(with_derivatives(scene, decades(1e-5, 1e-7)));
  for (const LimitRow& row : result.rows) {
    ASSERT_TRUE(row.local_largest && row.local_largest->power && row.local_mean && row.local_mean->power);
    EXPECT_NEAR(*row.local_largest->power, 0.5, 0.01 + row.local_largest->error) << row.epsilon;
    EXPECT_GT(*row.local_mean->power, 0.75) << row.epsilon;
    EXPECT_LT(*row.local_mean->power, 1.01) << row.epsilon;
  }
}

TEST(LocalPower, IsLeftOutWhereTheMethodHasNoDerivativesAndWhereNoneIsAskedFor) {
  LimitStudy study = with_derivatives(massless(0.1, MethodName::exponential), {1e-4, 1e-5});
  const LimitResult without = limit_of(study);
  for (const LimitRow& row : without.rows) {
    ASSERT_TRUE(row.local_mean);
    EXPECT_FALSE(row.local_mean->power);
  }
  EXPECT_NEAR(without.rows.front().local_mean->observed.value_or(0.0), 1.0, 0.01);
  study.derivatives = false;
  for (const LimitRow& row : limit_of(study).rows) EXPECT_FALSE(row.local_mean || row.local_largest);
}

TEST(LocalPower, NeverChangesAVerdict) {
  for (const bool derivatives : {false, true}) {
    LimitStudy study = with_derivatives(paper_throw(0.01), decades(1e-2, 1e-6));
    study.scene.step = 1e-4;
    study.derivatives = derivatives;
    EXPECT_EQ(limit_of(study).orders.at(0).verdict, Verdict::plateau);
  }
}

TEST(EndTraces, HaveTheDerivativesThatTheCaseAsksFor) {
  Case run = massless(0.1);
  run.epsilon = 1e-3;
  const std::vector<double> times = {0.0, 1.0, 2.5, 6.0};
  const auto at = [&](double epsilon) {
    Case moved = run;
    moved.epsilon = epsilon;
    moved.tolerance = {1e-11};
    return trace_ends(moved, times);
  };
  run.directions.push_back(direction(run, "contact.epsilon"));
  run.tolerance = {1e-10};
  const EndTraces traces = trace_ends(run, times);
  run.directions.clear();
  const EndTraces low = at(0.999e-3), high = at(1.001e-3);
  ASSERT_EQ(traces.sensitivities.size(), 1u);
  for (std::size_t k = 0; k < times.size(); ++k) {
    const double difference = (high.left[k] - low.left[k]) / 2e-6;
    // Of the second order in the step, and 1e-11 / 1e-6.
    EXPECT_NEAR(traces.sensitivities[0].left[k], difference, 1e-4 * (1.0 + std::abs(difference))) << times[k];
  }
}

}  // namespace
}  // namespace viscobar

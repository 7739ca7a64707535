// A sequence that settles, and what two of them say of their limits.
#include "studies/limit/verdict.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "support/paper_throw.hpp"
#include "support/verdict_truth.hpp"
#include "viscobar/case/end_traces.hpp"
#include "viscobar/studies/limit/limit.hpp"

namespace viscobar {
namespace {

// Traces T(x) = value(x) at every time.
Settling settling_of(double (*value)(double), const std::vector<double>& at) {
  std::vector<EndTraces> traces;
  for (const double x : at)
    traces.push_back({.left = {value(x)}, .right = {0.0}, .between = {}, .events = {}, .statistics = {}});
  TraceSequence sequence;
  for (std::size_t i = 0; i < at.size(); ++i) sequence.add(at[i], traces[i]);
  return settling(sequence, {.order = 0.5, .values = 3, .safety = 1.0}, 0.0);
}

TEST(Settling, IsExactForThePowerOfTheTheoryAndSafeForAHigherOne) {
  const std::vector<double> at = decades(1e-2, 1e-6);
  const Settling half = settling_of([](double x) { return 1.0 + 3.0 * std::sqrt(x); }, at);
  EXPECT_TRUE(half.settled);
  EXPECT_NEAR(half.error, 3.0 * 1e-3, 1e-12);
  const Settling one = settling_of([](double x) { return 1.0 + 3.0 * x; }, at);
  EXPECT_TRUE(one.settled);
  EXPECT_GT(one.error, 3.0 * 1e-6);
}

TEST(Settling, KnowsWhatDoesNotTendToAnything) {
  const std::vector<double> at = decades(1e-2, 1e-6);
  const Settling logarithm = settling_of([](double x) { return std::log(x); }, at);
  EXPECT_FALSE(logarithm.settled);
  const Settling growing = settling_of([](double x) { return 1e-9 / x; }, at);
  EXPECT_FALSE(growing.settled);
  EXPECT_TRUE(growing.grows);
  EXPECT_FALSE(settling_of([](double x) { return x; }, {1e-2, 1e-3}).settled) << "two values show no order";
}

TEST(Limit, TheSchemesErrorByItsStepsCoversItsDistanceToTheRigidLimit) {
  // Without using the rigid limit, as a study of massive nodes must: the error that the last four steps show. The
  // last one of each run is put at another place of its grid by the throw's speed.
  std::size_t covered = 0;
  constexpr std::size_t throws = 40;
  for (std::size_t k = 0; k < throws; ++k) {
    Case scene = paper_throw(0.05);
    const double speed = 0.5 + 0.0173 * static_cast<double>(k);
    scene.scene.velocity = [=](double x) { return -speed * (1.0 + x) / 2.0; };
    scene.mass = Mass::redistributed;
    scene.end = 2.0;
    scene.method = MethodName::rigid;
    scene.tolerance = {1e-10, 1e-13};
    const std::vector<double> times = comparison_times(scene.end, 1000, contact_changes(scene));
    const EndTraces limit = trace_ends(scene, times);
    scene.method = MethodName::fully_discrete;
    std::vector<EndTraces> traces;
    std::vector<double> steps;
    for (const double step : {4e-3, 4e-3 / std::cbrt(10.0), 4e-3 / std::cbrt(100.0), 4e-4}) {
      scene.step = step;
      steps.push_back(step);
      traces.push_back(trace_ends(scene, times));
    }
    TraceSequence sequence;
    for (std::size_t i = 0; i < steps.size(); ++i) sequence.add(steps[i], traces[i]);
    const Settling found = settling(sequence, {.order = 1.0, .values = 4, .safety = 2.0}, 0.0);
    if (largest_difference(traces.back(), limit) <= found.error) ++covered;
  }
  EXPECT_EQ(covered, throws);
}

TEST(LimitVerdict, WherePenalisedTracesDivergeASmallerEpsilonIsNotWhatIsLacking) {
  std::vector<EndTraces> penalised, scheme;
  LimitTraces mesh;
  const std::vector<double> at = decades(1e-2, 1e-5), steps = decades(1e-2, 1e-4);
  const auto constant = [](double value) {
    EndTraces traces{.left = {value}, .right = {0.0}, .between = {}, .events = {}, .statistics = {}};
    traces.statistics.max_penetration = 1e-12;
    return traces;
  };
  for (const double x : at) penalised.push_back(constant(1e-9 / x));
  for (const double x : steps) scheme.push_back(constant(x));
  for (std::size_t i = 0; i < at.size(); ++i) mesh.penalised.add(at[i], penalised[i]);
  for (std::size_t i = 0; i < steps.size(); ++i) mesh.scheme.add(steps[i], scheme[i]);
  const Judgement found = judge(mesh);
  EXPECT_EQ(found.verdict, Verdict::undecided);
  EXPECT_EQ(found.evidence.missing, Missing::larger_epsilon);
}

// Ends that move by 5 and limits known to 2: however far the bar would have fallen without the obstacle.
TEST(LimitVerdict, WhatABarWouldFallWithoutItsObstacleIsNotAtStake) {
  const auto moves = [](double off) {
    EndTraces traces{.left = {0.0, 5.0 + off}, .right = {0.0, 0.0}, .between = {}, .events = {}, .statistics = {}};
    traces.statistics.max_penetration = 1e-6;
    return traces;
  };
  const EndTraces rigid = moves(0.0), falls = moves(-1e4);
  const std::vector<double> at = decades(1e-3, 1e-6);
  std::vector<EndTraces> traces;
  for (const double x : at) traces.push_back(moves(2e6 * x));
  LimitTraces mesh;
  mesh.own_limit = mesh.scheme_limit = LimitTrace{rigid};
  mesh.one_limit = true;
  mesh.without_obstacles = [&]() -> const EndTraces& { return falls; };
  for (std::size_t i = 0; i < at.size(); ++i) mesh.penalised.add(at[i], rigid), mesh.scheme.add(at[i], traces[i]);
  const Judgement found = judge(mesh);
  EXPECT_EQ(found.evidence.stake, 5.0);
  EXPECT_EQ(found.verdict, Verdict::undecided);
  EXPECT_EQ(found.evidence.missing, Missing::smaller_step);
}

class VerdictOf : public testing::TestWithParam<std::size_t> {};

// A slice of the sixty scenes of docs/limit-verdicts.md.
TEST_P(VerdictOf, ARandomSceneIsTheOneOfTheoryAndItsBoundsEncloseTheDistanceByOtherRuns) {
  const VerdictScene scene = random_verdict_scenes(45)[GetParam() - 1];
  const KnownVerdict known = known_verdict(scene);
  const LimitOrders orders = limit_of(verdict_study(scene)).orders.at(0);
  EXPECT_EQ(orders.verdict, known.verdict) << scene.name;
  EXPECT_TRUE(agrees(orders.evidence, known)) << scene.name;
}

// Scenes of each mass and several restitutions, with and without viscosity, load and a second contact.
INSTANTIATE_TEST_SUITE_P(Slice, VerdictOf, testing::Values(1, 7, 9, 11, 12, 18, 20, 21, 38, 44));

}  // namespace
}  // namespace viscobar

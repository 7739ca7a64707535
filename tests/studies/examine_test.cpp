#include "viscobar/studies/compare/examine.hpp"

#include <gtest/gtest.h>

#include "viscobar/testing/examine.hpp"

namespace viscobar {
namespace {

// A bar that falls on an obstacle, with the viscosity that makes it smooth.
Case fall() {
  Case run;
  run.scene = exact::RigidFlight{{1.0, 1.0, 1.0, 0.3}, 1.0, 0.1}.scene();
  run.elements = 10;
  run.mass = Mass::redistributed;
  run.epsilon = 1e-5;
  run.end = 1.0;
  run.output_every = 0.05;
  run.tolerance = {1e-10, 1e-13};
  return run;
}

Recording by_ida(const Case& run) {
  Case mine = run;
  mine.method = MethodName::ida;
  return record(mine);
}

Solver off_by(double shift) {
  return [shift](const Case& run) {
    Recording recording = by_ida(run);
    for (double& u : recording.u) u += shift;
    return recording;
  };
}

// Two runs that both keep 100 times the tolerance.
const Bounds tight{.displacement_l2 = 2e-8, .end_trace = 2e-8, .event_shift = 1e-6};

TEST(Examination, PassesASchemeThatIsRight) {
  EXPECT_TRUE(passes("mine", by_ida, {"fall", fall(), {}, {MethodName::cvode}, tight}));
}

TEST(Examination, SaysByHowMuchASchemeIsOffAndToWhom) {
  const Trial trial{"fall", fall(), {}, {MethodName::cvode, MethodName::exponential}, tight};
  const TrialResult result = examine("mine", off_by(1e-3), {&trial, 1}).front();
  ASSERT_EQ(result.findings.size(), 4u) << trial_text(result);
  EXPECT_EQ(result.findings[1].key, "cvode: end trace");
  EXPECT_EQ(result.findings[1].problem, "0.001 exceeds 2e-08");
  EXPECT_NEAR(result.to(1)->end_trace, 1e-3, 2e-8);
  EXPECT_NE(trial_text(result).find("exponential: end trace: 0.001 exceeds 2e-08"), std::string::npos);
  EXPECT_FALSE(passes("mine", off_by(1e-3), trial));
}

TEST(Examination, MeasuresWithoutJudgingWhereNoBoundIsStated) {
  const Trial trial{"fall", fall(), {}, {MethodName::cvode}, {}};
  EXPECT_TRUE(examine("mine", off_by(1.0), {&trial, 1}).front().passed());
}

TEST(Examination, ASchemeThatThrowsOrDoesNotFitTheCaseIsAFinding) {
  const Trial trial{"fall", fall(), {}, {MethodName::cvode}, {}};
  const Solver broken = [](const Case&) -> Recording { throw std::runtime_error("no convergence"); };
  const auto thrown = examine("mine", broken, {&trial, 1}).front();
  ASSERT_EQ(thrown.findings.size(), 1u);
  EXPECT_EQ(thrown.findings[0].problem, "failed: no convergence");
  const Solver short_one = [](const Case& run) {
    Recording recording = by_ida(run);
    recording.times.pop_back();
    return recording;
  };
  const auto refused = examine("mine", short_one, {&trial, 1}).front();
  ASSERT_EQ(refused.findings.size(), 1u);
  EXPECT_NE(refused.findings[0].problem.find("its 20 times are not the 21 output times"), std::string::npos);
}

TEST(Examination, ABoundOnWhatASchemeDoesNotGiveIsNotPassed) {
  const Solver ends_only = [](const Case& run) {
    Recording full = by_ida(run), ends = full;
    ends.mesh.elements = 1;
    ends.u.clear();
    ends.v.clear();
    for (std::size_t k = 0; k < full.times.size(); ++k) {
      ends.u.push_back(full.displacement(k).front());
      ends.u.push_back(full.displacement(k).back());
    }
    return ends;
  };
  Trial trial{"fall", fall(), {}, {MethodName::cvode}, {.end_trace = 2e-8}};
  EXPECT_TRUE(passes("ends", ends_only, trial));
  trial.bounds.velocity_l2 = 1.0;
  const auto result = examine("ends", ends_only, {&trial, 1}).front();
  ASSERT_EQ(result.findings.size(), 1u);
  EXPECT_EQ(result.findings[0].problem, "is not known, 1 is the bound");
}

TEST(Examination, TakesTheExactSolutionForItsRefereeWhereThereIsOne) {
  const exact::Solution solution = exact::later(exact::solution(exact::ManufacturedContact{}), 0.1);
  Case run = fall();
  run.scene = solution.scene;
  const Trial trial{"manufactured", run, solution, {}, {.end_trace = 0.1}};
  const auto result = examine("mine", by_ida, {&trial, 1}).front();
  ASSERT_EQ(result.check.runs.size(), 2u);
  EXPECT_EQ(result.check.runs[0].label, "exact");
  ASSERT_TRUE(result.error) << trial_text(result);
  EXPECT_EQ(result.error->end_trace, result.to(0)->end_trace);
  EXPECT_TRUE(result.passed()) << trial_text(result);
}

TEST(Examination, WithoutSolutionOrMethodsEveryMethodThatFitsIsAReferee) {
  const Trial trial{"fall", fall(), {}, {}, {}};
  const auto result = examine("mine", by_ida, {&trial, 1}).front();
  EXPECT_EQ(result.check.runs.size(), fitting_methods(fall()).cases.size() + 1);
}

}  // namespace
}  // namespace viscobar

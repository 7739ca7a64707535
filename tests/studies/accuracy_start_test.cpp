// A search for a mesh that begins where a neighbour's ended.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "studies/accuracy/sample.hpp"
#include "viscobar/input/scene_file.hpp"
#include "viscobar/studies/accuracy/accuracy.hpp"

namespace viscobar {
namespace {

AccuracyStudy study_of(double viscosity, const std::vector<std::string>& settings) {
  const SceneFile scene = parse_scene(
      fmt::format("[bar]\nlength=1\nviscosity={}\n[left]\nkind=\"obstacle\"\ngap=0.1\n[initial]\nvelocity=-1\n"
                  "[time]\nend=2.5\n",
                  viscosity),
      "scene", settings);
  AccuracyStudy study;
  study.scene = scene.run;
  study.request = *scene.accuracy;
  return study;
}

AccuracyResult begun(AccuracyStudy study, const AccuracyStart& start) {
  study.start = start;
  return solve(study);
}

// Elements of all runs together: what they cost, about.
std::size_t work(const AccuracyResult& result) {
  std::size_t elements = result.run.elements;
  for (const ErrorEstimate::Run& run : result.estimate.runs) elements += run.elements;
  return elements;
}

std::size_t runs(const AccuracyResult& result) { return 1 + result.estimate.runs.size(); }

bool says_so(const AccuracyResult& result) {
  for (const std::string& reason : result.estimate.reasons)
    if (reason.find("neighbour") != reason.npos) return true;
  return false;
}

// The displacement beside four times the elements at a thirtieth of the tolerance.
double error_of(const AccuracyResult& result) {
  Case truth = result.run;
  truth.method = MethodName::rigid;
  truth.mass = Mass::fourth_order;
  truth.restitution.reset();
  truth.elements *= 4;
  truth.tolerance = Tolerance{std::clamp(result.run.tolerance.relative / 30.0, 1e-12, 1e-8)};
  const auto sample = [](const Case& run) { return accuracy::sample_of(run, run.output_times()); };
  return accuracy::difference(sample(result.run), sample(truth), Goal::displacement);
}

TEST(StartAtANeighbour, KeepsTheErrorWithFewerRuns) {
  for (const char* method : {"rigid", "cvode"})
    for (const double error : {1e-4, 1e-5}) {
      const std::vector<std::string> settings{fmt::format("accuracy.error={}", error),
                                              fmt::format("method.name={}", method)};
      const AccuracyStart start = start_at(solve(study_of(0.012, settings)).run);
      const AccuracyResult alone = solve(study_of(0.01, settings)), result = begun(study_of(0.01, settings), start);
      EXPECT_TRUE(result.estimate.kept) << result.estimate.doubt;
      EXPECT_TRUE(says_so(result)) << method << " " << error;
      EXPECT_FALSE(says_so(alone));
      EXPECT_LE(error_of(result), error) << method;
      EXPECT_LT(runs(result), runs(alone)) << method << " " << error;
      EXPECT_LE(static_cast<double>(work(result)), 1.05 * static_cast<double>(work(alone))) << method << " " << error;
    }
}

// However wrong the guess is.
TEST(StartAtANeighbour, EndsWithinAMeshStepOfTheSearchByItself) {
  const AccuracyStudy study = study_of(0.03, {"accuracy.error=1e-7"});
  const AccuracyResult alone = solve(study);
  for (const double factor : {0.1, 0.25, 0.5, 0.8, 1.25, 2.0, 4.0, 8.0}) {
    AccuracyStart start = start_at(alone.run);
    start.elements = static_cast<std::size_t>(factor * static_cast<double>(start.elements));
    const AccuracyResult result = begun(study, start);
    EXPECT_TRUE(result.estimate.kept) << factor << result.estimate.doubt;
    EXPECT_LE(error_of(result), 1e-7) << factor;
    EXPECT_LE(result.run.elements, 2 * alone.run.elements) << factor;
    EXPECT_GE(2 * result.run.elements, alone.run.elements) << factor;
  }
}

TEST(StartAtANeighbour, LeavesSettingsThatAreFarFinerThanNeeded) {
  const AccuracyStudy study = study_of(0.1, {"accuracy.error=1e-4", "method.name=cvode"});
  const AccuracyResult alone = solve(study);
  AccuracyStart start = start_at(alone.run);
  *start.tolerance *= 1e-4;
  *start.epsilon *= 1e-4;
  const AccuracyResult result = begun(study, start);
  EXPECT_TRUE(result.estimate.kept) << result.estimate.doubt;
  EXPECT_GE(result.run.tolerance.relative, 0.1 * alone.run.tolerance.relative);
  EXPECT_GE(*result.run.epsilon, 0.1 * *alone.run.epsilon);
}

TEST(StartAtANeighbour, TakesNothingOfWhatTheSceneFixesOrDoesNotUse) {
  const AccuracyStart start{.elements = 640, .tolerance = 1e-9, .epsilon = 1e-9};
  const AccuracyResult fixed =
      begun(study_of(0.1, {"accuracy.error=1e-3", "mesh.elements=40", "method.relative_tolerance=1e-5"}), start);
  EXPECT_TRUE(fixed.estimate.kept) << fixed.estimate.doubt;
  EXPECT_FALSE(says_so(fixed));
  EXPECT_EQ(fixed.run.elements, 40u);
  EXPECT_EQ(fixed.run.tolerance.relative, 1e-5);
  const AccuracyResult waves = begun(study_of(0.0, {"accuracy.error=1e-3"}), start);
  EXPECT_EQ(waves.run.method, MethodName::characteristics);
  EXPECT_TRUE(waves.estimate.kept);
  EXPECT_EQ(start_at(waves.run).elements, 0u);
}

TEST(StartAtANeighbour, SuitsAPercentageAndAnObstacleAlongTheBar) {
  for (const std::vector<std::string>& settings :
       {std::vector<std::string>{"accuracy.error=\"0.001 %\""},
        std::vector<std::string>{"accuracy.error=1e-3", "left.kind=free", "left.gap=", "span.gap=0.1"}}) {
    const AccuracyStudy study = study_of(0.1, settings);
    const AccuracyResult alone = solve(study), result = begun(study, start_at(alone.run));
    EXPECT_TRUE(result.estimate.kept) << result.estimate.doubt;
    EXPECT_EQ(result.run.elements, alone.run.elements);
    EXPECT_LE(runs(result), runs(alone));
  }
}

}  // namespace
}  // namespace viscobar

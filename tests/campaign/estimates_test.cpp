// One error of a scene, whoever asks.
#include "campaign/estimates.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "report/scene_check.hpp"
#include "studies/accuracy/data_error.hpp"
#include "studies/accuracy/quick_estimate.hpp"
#include "support/scratch.hpp"
#include "viscobar/input/scene_file.hpp"
#include "viscobar/record/record_run.hpp"
#include "viscobar/studies/precision/precision.hpp"

namespace viscobar::campaign {
namespace {

// The campaign is measure_estimates. An error that is not ten times larger than that of its truth is not told.
TEST(Estimates, OfRandomThrowsAreNoThirdOfTheErrorAndBelowThreeTimesItInTheMedian) {
  std::vector<double> ratios;
  for (std::size_t index = 0; index < 30; ++index) {
    const Case run = parse_scene(thrown_scene(3, index), "scene").run;
    if (run.scene.span || run.method == MethodName::characteristics) continue;
    const auto truth = true_error(run);
    const auto told = accuracy::quick_estimate(run, std::nullopt, 10.0);
    if (!truth || !truth->sharp()) continue;
    ASSERT_TRUE(told.estimate) << told.why_not << thrown_scene(3, index);
    ratios.push_back(told.estimate->total / truth->error);
    EXPECT_GT(ratios.back(), 1.0 / 3.0) << thrown_scene(3, index);
  }
  ASSERT_GT(ratios.size(), 20U);
  std::ranges::nth_element(ratios, ratios.begin() + static_cast<std::ptrdiff_t>(ratios.size() / 2));
  EXPECT_LT(ratios[ratios.size() / 2], 3.0);
}

// A plateau of the penalty: nodes of a span that is met one after the other, at 1.8e-5 of the natural epsilon and a
// tenth of it, are wrong by 0.018 alike; only below 1e-7 their impacts part.
TEST(Estimates, OfAPenaltyAlongTheBarSeeBeyondThePlateauOfImpactsThatOverlap) {
  const Case run = parse_scene(thrown_scene(77, 695), "scene").run;
  const auto truth = true_error(run);
  ASSERT_TRUE(truth && truth->sharp());
  const auto told = accuracy::quick_estimate(run, std::nullopt, 10.0);
  ASSERT_TRUE(told.estimate);
  // Impacts that do not overlap are wrong by the power 1/2: a thousandth by 3 %, and the estimate extrapolates. The
  // mesh's part, a quarter of it, is added.
  EXPECT_GT(told.estimate->total / truth->error, 0.9);
  EXPECT_LT(told.estimate->total / truth->error, 2.0);
}

TEST(Estimates, OfChatterAndBouncesAreNoThirdOfTheError) {
  for (const auto scene : {&chattering_scene, &bouncing_scene})
    for (std::size_t index = 0; index < 18; ++index) {
      const Case run = parse_scene(scene(82, index), "scene").run;
      const auto truth = true_error(run);
      const auto told = accuracy::quick_estimate(run, std::nullopt, 10.0);
      if (!truth || !truth->sharp()) continue;
      ASSERT_TRUE(told.estimate) << told.why_not << scene(82, index);
      EXPECT_GT(told.estimate->total / truth->error, 1.0 / 3.0) << scene(82, index);
    }
}

constexpr const char* thrown =
    "[bar]\nlength = 1.0\nviscosity = {}\n[left]\nkind = \"obstacle\"\ngap = 0.1\n[right]\nkind = \"obstacle\"\n"
    "gap = 0.1\n[initial]\ndisplacement = \"x*(1-x)\"\nvelocity = \"-x*(1-x)\"\n[time]\nend = 6.0\n"
    "[mesh]\nelements = 27\n[method]\nname = \"{}\"\n[output]\nevery = {}\n{}";

// The truth is rigid on 8 and 16 times the elements, the reference of precision on more: the two errors differ by less
// than a hundredth.
TEST(Estimates, OfAChatterAreOfTheSizeOfItsErrorWhichPrecisionMeasures) {
  Case run = parse_scene(fmt::format(thrown, 0.003, "cvode", 0.06, "[contact]\nepsilon = 1e-4\n"), "scene").run;
  run.mass = Mass::consistent;
  const auto truth = true_error(run);
  ASSERT_TRUE(truth && truth->sharp());
  PrecisionStudy study;
  study.scene = run, study.methods = {MethodName::cvode}, study.tolerances = {1e-6}, study.repeat = 1;
  const PrecisionResult measured = precision_of(study);
  ASSERT_TRUE(measured.rows.size() == 1 && measured.rows[0].error);
  EXPECT_NEAR(*measured.rows[0].error, truth->error, 0.01 * truth->error);
  const double ratio = accuracy::quick_estimate(run, std::nullopt, 10.0).estimate->total / truth->error;
  EXPECT_GT(ratio, 1.0 / 3.0);
  EXPECT_LT(ratio, 3.0);
}

TEST(Estimates, OfCheckAndRunAreOneNumberAtAnyOutputInterval) {
  const Scratch scratch;
  const struct {
    double viscosity;
    const char *method, *more;
  } scenes[] = {{0.01, "rigid", ""},
                {0.003, "cvode", "[contact]\nepsilon = 1e-4\n"},
                {0.1, "fully_discrete", ""},
                {0.0, "characteristics", ""}};
  for (const auto& [viscosity, method, more] : scenes) {
    std::vector<double> told;
    for (const double every : {0.06, 1.7, 0.0123}) {
      const SceneFile scene = parse_scene(fmt::format(fmt::runtime(thrown), viscosity, method, every, more), "scene");
      const auto check = check_scene(scene).error;
      ASSERT_TRUE(check);
      told.push_back(check->total);
      const RunRecord record = record_with_estimate(scene, scratch.path() / "run");
      ASSERT_TRUE(record.outcome.error_estimate) << record.outcome.no_estimate;
      told.push_back(record.outcome.error_estimate->total);
    }
    // Waves are told to rounding, by differences of roundings.
    for (const double one : told) EXPECT_NEAR(one, told.front(), viscosity > 0.0 ? 0.0 : 1e-3 * told.front()) << method;
  }
}

TEST(Estimates, OfCheckAreThoseOfTheSettingsThatARequestLeadsTo) {
  const Scratch scratch;
  for (const char* error : {"1e-3", "1e-5", "\"0.01 %\""}) {
    const SceneFile scene = parse_scene(
        fmt::format("[bar]\nlength = 1.0\nviscosity = 0.2\n[left]\nkind = \"obstacle\"\ngap = 0.1\n[initial]\n"
                    "velocity = -1.0\n[time]\nend = 2.0\n[accuracy]\nerror = {}\n",
                    error),
        "scene");
    const SceneCheck check = check_scene(scene);
    const RunRecord record = record_to_accuracy(scene, scratch.path() / "run", {});
    ASSERT_TRUE(check.error && record.outcome.error_estimate && record.run) << check.no_error;
    EXPECT_EQ(check.error->total, record.outcome.error_estimate->total);
    EXPECT_EQ(check.scene.run.elements, record.run->elements);
    EXPECT_EQ(check.error_elements, record.run->elements);
  }
  // A search that takes minutes is not made, and no number of other settings stands for it.
  const SceneCheck check = check_scene(
      parse_scene("[bar]\nlength = 1.0\nviscosity = 1e-3\n[left]\nkind = \"obstacle\"\ngap = 0.1\n[right]\nkind = "
                  "\"obstacle\"\ngap = 0.1\n[initial]\nvelocity = -1.0\n[time]\nend = 200.0\n[accuracy]\nerror = 1e-8\n"
                  "[method]\nname = \"cvode\"\n",
                  "scene"));
  EXPECT_FALSE(check.error);
  EXPECT_NE(check.no_error.find("takes longer"), std::string::npos) << check.no_error;
}

// At rest on the wall, beside 16 times as many elements, from the impact to four h^2 rho / eta behind it. What the
// elasticity adds in that time is a tenth of it. On masses of second order the error goes on to grow, and is seen.
TEST(LayerError, IsThatOfABarThatStopsDead) {
  for (const char* mass : {"fourth_order", "consistent", "lumped"}) {
    Case run = parse_scene(fmt::format("[bar]\nlength = 1.0\nviscosity = 2.0\n[left]\nkind = \"obstacle\"\ngap = 0.1\n"
                                       "[initial]\nvelocity = -1.0\n[time]\nend = 0.2\n[mesh]\nelements = 20\n"
                                       "mass = \"{}\"\n[contact]\nrestitution = 0.0\n[method]\nname = \"rigid\"\n"
                                       "relative_tolerance = 1e-10\n",
                                       mass),
                           "scene")
                   .run;
    std::vector<double> times{0.0};
    for (int k = 1; k <= 200; ++k) times.push_back(0.1 + 0.01 * 2.0 * 0.00125 * k);
    times.push_back(run.end);
    const accuracy::Sample coarse = accuracy::sample_of(run, times);
    const double layer = accuracy::layer_error(run, 1.0);
    const bool fourth = run.mass == Mass::fourth_order;
    run.elements *= 16;
    run.mass = Mass::fourth_order;
    const double error = accuracy::difference(coarse, accuracy::sample_of(run, times), Goal::displacement);
    EXPECT_GE(error / layer, 0.9) << mass;
    if (fourth) {
      EXPECT_LE(error / layer, 1.1);
    }
  }
}

}  // namespace
}  // namespace viscobar::campaign

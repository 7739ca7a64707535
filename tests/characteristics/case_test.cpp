// The method as scenes and studies meet it.
#include <gtest/gtest.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "case/alarm.hpp"
#include "case/regime.hpp"
#include "viscobar/case/recording.hpp"
#include "viscobar/input/scene_file.hpp"
#include "viscobar/record/record_run.hpp"
#include "viscobar/studies/compare/compare.hpp"
#include "viscobar/studies/precision/precision.hpp"

namespace viscobar {
namespace {

Case example(const char* name, const std::vector<std::string>& overrides = {}) {
  return read_scene(std::filesystem::path(VISCOBAR_SOURCE_DIR "/examples/scenes") / name, overrides).run;
}

std::vector<std::string> faulty_keys(Case run) {
  run.method = MethodName::characteristics;
  std::vector<std::string> keys;
  for (const Finding& finding : faults(resolve(run))) keys.push_back(finding.key);
  return keys;
}

TEST(CharacteristicsCase, IsRefusedWithTheKeyAndWhatDoesInstead) {
  const Case sound = example("bouncing.toml");
  EXPECT_TRUE(faulty_keys(sound).empty());
  Case run = sound;
  run.scene.bar.viscosity = 0.01;
  EXPECT_EQ(faulty_keys(run), std::vector<std::string>{"method.name"});
  run = sound;
  run.scene.span = Obstacle{100.0};
  EXPECT_EQ(faulty_keys(run), std::vector<std::string>{"method.name"});
  run = sound;
  run.end = 1e9;
  run.output_every = 1e9;
  EXPECT_EQ(faulty_keys(run), std::vector<std::string>{"time.end"});
  // Settings that other methods need may stay.
  run = sound;
  run.epsilon.reset();
  run.step.reset();
  run.restitution = 0.5;
  run.mass = Mass::redistributed;
  run.elements = 1;
  EXPECT_TRUE(faulty_keys(run).empty());
}

TEST(CharacteristicsCase, IsTheReferenceOfACrossCheckOfWhatItFits) {
  EXPECT_EQ(fitting_methods(example("bouncing.toml")).cases.front().method, MethodName::characteristics);
  EXPECT_NE(fitting_methods(example("chatter.toml")).cases.front().method, MethodName::characteristics);
}

// Places where a load is quick are no breaks of it: each piece between them took an integral of its own, 4e7 values of
// this load for one output.
TEST(CharacteristicsCase, LooksAtATravellingLoadWhereItIsQuick) {
  Case run =
      parse_scene(
          "[bar]\nlength = 1\n[left]\nkind = \"free\"\nmass = 2\n[load]\ndensity = \"exp(-20*(x-t)^2)\"\n[time]\nend = "
          "2.5\n[output]\nevery = 0.5\n",
          "")
          .run;
  ASSERT_EQ(run.method, MethodName::characteristics);
  const Recording quick = record(run);
  EXPECT_LT(quick.statistics.load_evaluations, 5'000'000u);
  auto& load = std::get<GeneralLoad>(*run.scene.load);
  load.breaks = {}, load.sharp.reset();
  const Recording smooth = record(run);
  for (std::size_t i = 0; i < smooth.u.size(); ++i) EXPECT_NEAR(quick.u[i], smooth.u[i], 1e-12);
}

TEST(CharacteristicsCase, GivesContactPeriodsTheirExactImpulses) {
  Case run = example("bouncing.toml", {"time.end=5", "output.every=0.7"});
  const Comparison check = compare(std::vector{run});
  ASSERT_EQ(check.runs[0].contacts.size(), 2u);
  for (const ContactPeriod& period : check.runs[0].contacts) EXPECT_NEAR(period.impulse.value(), 800.0 / 3.0, 1e-10);
}

TEST(CharacteristicsCase, IsTheReferenceOfPrecision) {
  PrecisionStudy study;
  study.scene = example("bouncing.toml", {"time.end=2", "mesh.elements=10", "output.every=0.5"});
  study.methods = {MethodName::characteristics, MethodName::rigid};
  study.tolerances = {1e-4};
  const PrecisionResult result = precision_of(study);
  ASSERT_TRUE(result.reference);
  EXPECT_TRUE(result.reference->closed_form);
  EXPECT_NE(result.reference->what.find("characteristics"), std::string::npos);
  EXPECT_EQ(*result.rows.front().error, 0.0);
  EXPECT_GT(*result.rows.back().error, 1e-3) << "ten elements";
}

TEST(CharacteristicsCase, PredictsTheFirstImpactExactly) {
  const auto foreseen = foresee(resolve(example("bouncing.toml")));
  ASSERT_TRUE(foreseen);
  ASSERT_EQ(foreseen->impacts.size(), 1u);
  EXPECT_NEAR(foreseen->impacts.front().time, 1.0, 1e-14);
  EXPECT_NEAR(foreseen->impacts.front().speed, 10.0, 1e-12);
}

// At rest at both ends of the run: what the bar had in between counts.
TEST(CharacteristicsCase, IsNoAlarmWhereAllEnergyIsGoneAgain) {
  const Case run = example("bouncing.toml");
  const Recording recording = record(run);
  EXPECT_TRUE(alarms(resolve(run), resolve(run).system(), recording.statistics).empty());
}

TEST(CharacteristicsCase, WritesImpulsesThatDoNotDependOnTheOutputTimes) {
  const std::filesystem::path directory = std::filesystem::path(testing::TempDir()) / "characteristics";
  for (const char* every : {"output.every=0.05", "output.every=3"}) {
    std::filesystem::remove_all(directory);
    const SceneFile scene =
        read_scene(VISCOBAR_SOURCE_DIR "/examples/scenes/bouncing.toml", std::vector<std::string>{every});
    const auto summary = nlohmann::json::parse(record_run(scene, directory, {}).summary);
    EXPECT_TRUE(summary["completed"]);
    EXPECT_TRUE(summary["warnings"].empty());
    EXPECT_NEAR(summary["contact"]["left"]["impulse"].get<double>(), 20.0 * 800.0 / 3.0, 1e-9);
    EXPECT_NEAR(summary["contact"]["left"]["max_reaction"].get<double>(), 500.0, 1e-10);
    EXPECT_NEAR(summary["contact"]["left"]["time_in_contact"].get<double>(), 40.0 / 3.0, 1e-11);
    EXPECT_EQ(summary["events"], 40);
    EXPECT_LT(summary["representation"]["error"], 1e-10);
  }
  std::filesystem::remove_all(directory);
}

}  // namespace
}  // namespace viscobar

#include "viscobar/record/record_run.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <limits>
#include <nlohmann/json.hpp>
#include <optional>

#include "support/file_size_limit.hpp"
#include "support/scratch.hpp"
#include "viscobar/results/io_error.hpp"

namespace viscobar {
namespace {

using Json = nlohmann::json;

Json summary_in(const std::filesystem::path& directory) { return Json::parse(read_text(directory / "summary.json")); }

TEST(RecordRun, WritesARowForEveryOutputTimeAndEveryContactChange) {
  const Scratch scratch;
  const RunRecord record = record_run(bouncing_bar(), scratch / "deep/out");
  EXPECT_EQ(record.outcome.ending, Ending::completed);
  const auto ends = read_lines(scratch / "deep/out/ends.csv");
  ASSERT_EQ(ends.size(), 1u + 101u);
  EXPECT_TRUE(ends[1].starts_with("0,"));
  EXPECT_TRUE(ends.back().starts_with("1,"));
  EXPECT_GE(record.outcome.events, 2u);
  EXPECT_EQ(read_lines(scratch / "deep/out/events.csv").size(), 1u + record.outcome.events);
  for (const char* file : {"field.h5", "field.xdmf", "report.html"})
    EXPECT_GT(std::filesystem::file_size(scratch / "deep/out" / file), 1000u) << file;
}

TEST(RecordRun, ADoubtOfTheEstimateIsToldAsItIsKept) {
  const Scratch scratch;
  std::vector<std::string> told;
  RecordOptions options;
  options.warning = [&](const std::string& warning) { told.push_back(warning); };
  const SceneFile scene = parse_scene(
      "[bar]\nlength = 1\nviscosity = 0.0036\n[span]\ngap = 0.1\n[initial]\nvelocity = \"-1.2-0.36*x\"\n[time]\nend = "
      "3\n[mesh]\nelements = 20\n[contact]\nrestitution = 0.16\n",
      "");
  record_with_estimate(scene, scratch / "out", options);
  EXPECT_EQ(told, summary_in(scratch / "out")["warnings"].get<std::vector<std::string>>());
  ASSERT_FALSE(told.empty());
  EXPECT_NE(told.back().find("lose the rebound"), std::string::npos) << told.back();
}

TEST(RecordRun, AnInterruptedRunKeepsWhatItReached) {
  const Scratch scratch;
  RecordOptions options;
  double reached = 0.0;
  options.progress = [&](double time, std::size_t) { reached = time; };
  options.stop = [&] { return reached > 0.5; };
  const RunRecord record = record_run(bouncing_bar(), scratch.path(), options);
  EXPECT_EQ(record.outcome.ending, Ending::interrupted);
  const Json summary = summary_in(scratch.path());
  EXPECT_EQ(summary["completed"], false);
  EXPECT_EQ(summary["error"], "interrupted");
  EXPECT_GT(summary["rhs_evaluations"], 0);
  EXPECT_TRUE(summary["energy"].is_null()) << "the final one is not known";
  EXPECT_GT(summary["reached_time"], 0.5);
  EXPECT_LT(summary["reached_time"], 1.0);
  const auto ends = read_lines(scratch / "ends.csv");
  EXPECT_GT(ends.size(), 50u);
  EXPECT_LE(ends.size(), 1u + 101u);
  EXPECT_NE(read_text(scratch / "report.html").find("did not complete"), std::string::npos);
}

TEST(RecordRun, AFailedIntegrationKeepsWhatItReachedAndSaysWhy) {
  const Scratch scratch;
  SceneFile scene = bouncing_bar();
  scene.run.scene.load =
      GeneralLoad{[](double, double t) { return t > 0.5 ? std::numeric_limits<double>::quiet_NaN() : 0.0; }};
  const RunRecord record = record_run(scene, scratch.path());
  EXPECT_EQ(record.outcome.ending, Ending::failed);
  const Json summary = summary_in(scratch.path());
  EXPECT_EQ(summary["completed"], false);
  EXPECT_NE(summary["error"].get<std::string>().find("load"), std::string::npos);
  EXPECT_GT(summary["steps"], 0);
  EXPECT_LE(summary["reached_time"], 0.5);
  EXPECT_GT(read_lines(scratch / "ends.csv").size(), 2u);
}

TEST(RecordRun, AFullDiskEndsTheRunAsAFailureThatNamesTheFile) {
  const Scratch scratch;
  SceneFile scene = bouncing_bar();
  scene.run.output_every = 1e-4;  // a megabyte of ends.csv
  std::optional<FileSizeLimit> full;
  RecordOptions options;
  options.progress = [&](double, std::size_t) {
    if (!full) full.emplace(100'000);
  };
  RunRecord record = record_run(scene, scratch.path(), options);
  full.reset();
  EXPECT_EQ(record.outcome.ending, Ending::failed);
  EXPECT_NE(record.outcome.error.find("cannot be written: File too large"), std::string::npos) << record.outcome.error;
  EXPECT_EQ(summary_in(scratch.path())["completed"], false);
}

TEST(RecordRun, ReplacesAnEarlierResult) {
  const Scratch scratch;
  SceneFile scene = bouncing_bar();
  record_run(scene, scratch.path());
  scene.run.end = 0.5;
  record_run(scene, scratch.path());
  EXPECT_EQ(read_lines(scratch / "ends.csv").size(), 1u + 51u);
}

TEST(RecordRun, TouchesNoDirectoryThatHoldsOtherFiles) {
  const Scratch scratch;
  std::ofstream(scratch / "ends.csv") << "mine";
  EXPECT_THROW(record_run(bouncing_bar(), scratch.path()), std::invalid_argument);
  EXPECT_EQ(read_text(scratch / "ends.csv"), "mine");
  EXPECT_THROW(record_run(bouncing_bar(), scratch / "ends.csv"), std::invalid_argument);
}

TEST(RecordRun, AKilledRunLeavesASummaryThatSaysSoAndNoOldReport) {
  const Scratch scratch;
  RecordOptions options;
  double reached = 0.0;
  options.progress = [&](double time, std::size_t) { reached = time; };
  options.stop = [&] { return reached > 0.5; };
  record_run(bouncing_bar(), scratch.path(), options);
  EXPECT_TRUE(std::filesystem::exists(scratch / "report.html"));
  options.stop = {};
  options.progress = [&](double, std::size_t steps) {
    if (steps > 1) return;
    EXPECT_EQ(summary_in(scratch.path())["error"], "the run is going on, or was killed");
    EXPECT_FALSE(std::filesystem::exists(scratch / "report.html"));
  };
  record_run(bouncing_bar(), scratch.path(), options);
  EXPECT_EQ(summary_in(scratch.path())["completed"], true);
}

TEST(RecordRun, TheRecordingDoesNotChangeTheMotion) {
  const Scratch scratch;
  const SceneFile scene = bouncing_bar();
  Observers last;
  double u = 0.0;
  last.snapshot = [&](const Snapshot& at) { u = at.u.front(); };
  simulate(resolve(scene.run), last);
  record_run(scene, scratch.path());
  const std::string row = read_lines(scratch / "ends.csv").back();
  // The energy account joins the state that the tolerances govern: ten times those.
  EXPECT_NEAR(std::stod(row.substr(row.find(',') + 1)), u, 10 * scene.run.tolerance.relative);
}

// A load that oscillates 10^9 times; the run is stopped as soon as it has spoken, after a million steps.
TEST(RecordRun, WarnsOfARunThatWillTakeLong) {
  const Scratch scratch;
  const SceneFile scene = parse_scene(
      "[bar]\nlength = 1\n[initial]\ndisplacement = 0\nvelocity = 0\n[load]\nprofile = 1\nhistory = \"sin(1e9*t)\"\n"
      "[time]\nend = 10\n[mesh]\nelements = 2\nmass = \"lumped\"\n[method]\nname = \"cvode\"\n[output]\nevery = 1\n",
      "slow");
  std::vector<std::string> warnings;
  RecordOptions options;
  options.warning = [&](const std::string& warning) { warnings.push_back(warning); };
  options.stop = [&] { return !warnings.empty(); };
  record_run(scene, scratch / "out", options);
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_TRUE(warnings[0].starts_with("slow: the last 1000000 steps")) << warnings[0];
}

// Pressed between two obstacles without viscosity: see Automatic.TakesRigidAndSaysWhyWhereTheWavesBreakWithoutEnd.
TEST(RecordRun, WarnsInTheSummaryWhereAutomaticCannotTakeTheExactMethod) {
  const Scratch scratch;
  const SceneFile scene = parse_scene(
      "[bar]\nlength = 1\n[left]\nkind = \"obstacle\"\ngap = 0.1\n[right]\nkind = \"obstacle\"\ngap = 0.1\n"
      "[initial]\ndisplacement = \"0.4*x*(1-x)\"\nvelocity = \"-0.5-x\"\n[load]\ndensity = -1\n"
      "[time]\nend = 120\n[mesh]\nelements = 8\n[output]\nevery = 10\n",
      "rough");
  record_run(scene, scratch.path());
  const auto summary = summary_in(scratch.path());
  EXPECT_EQ(summary["method"], "rigid");
  EXPECT_EQ(summary["method_requested"], "automatic");
  ASSERT_FALSE(summary["warnings"].empty());
  EXPECT_TRUE(summary["warnings"][0].get<std::string>().starts_with("automatic chose rigid")) << summary["warnings"];
}

TEST(RecordRun, WarnsOfImpactsThatNoContactFollows) {
  const auto warnings = [](int elements) {
    const Scratch scratch;
    record_run(
        parse_scene(fmt::format("[bar]\nlength = 1\nviscosity = 0.01\n[left]\nkind = \"obstacle\"\ngap = 0.1\n"
                                "[right]\nkind = \"obstacle\"\ngap = 0.1\n[initial]\ndisplacement = \"x*(1-x)\"\n"
                                "velocity = \"-x*(1-x)\"\n[time]\nend = 6\n[mesh]\nelements = {}\n",
                                elements),
                    ""),
        scratch.path());
    return summary_in(scratch.path())["warnings"].dump();
  };
  EXPECT_NE(warnings(2).find("touches: the left end strikes its obstacle and is pulled away at once"),
            std::string::npos);
  EXPECT_EQ(warnings(27).find("touches:"), std::string::npos);
}

}  // namespace
}  // namespace viscobar

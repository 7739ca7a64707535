// viscobar run --error, and [accuracy] in a scene: what the user sees of accuracy on request.
#include "cli/command.hpp"

namespace viscobar::testing_cli {
namespace {

class AccuracyCommand : public Command {
 protected:
  AccuracyCommand() {
    std::ofstream(directory_ / "bar.toml")
        << "[bar]\nlength = 1\nviscosity = 0.1\n[left]\nkind = \"obstacle\"\ngap = 0\n"
           "[initial]\nvelocity = -1\n[time]\nend = 2.5\n";
  }
};

TEST_F(AccuracyCommand, ASceneWithoutMeshContactAndMethodIsRunToTheErrorWithACertificate) {
  const Ended ended = viscobar("run bar.toml --error 1e-6 --json -o out");
  ASSERT_EQ(ended.code, 0) << ended.error;
  const nlohmann::json summary = ended.json();
  EXPECT_EQ(summary, nlohmann::json::parse(read_text(directory_ / "out/summary.json")));
  const nlohmann::json& estimate = summary["error_estimate"];
  EXPECT_EQ(estimate["kept"], true);
  EXPECT_EQ(estimate["requested"], 1e-6);
  EXPECT_NEAR(estimate["total"].get<double>(),
              estimate["space"].get<double>() + estimate["penalty"].get<double>() + estimate["time"].get<double>(),
              1e-20);
  EXPECT_LE(estimate["total"], 1e-6);
  EXPECT_EQ(summary["method_requested"], "automatic");
  EXPECT_EQ(summary["scene"]["mesh"]["elements"], summary["chosen"]["mesh"]["elements"]);
  EXPECT_EQ(summary["scene"]["mesh"]["mass"], "fourth_order");
  EXPECT_LE(summary["scene"]["method"]["relative_tolerance"], 1e-6);
  EXPECT_NE(read_text(directory_ / "out/report.html").find("How far from the bar itself"), std::string::npos);
  EXPECT_EQ(viscobar("info out --verify").code, 0);
}

TEST_F(AccuracyCommand, ThatIsToldInTheTerminal) {
  const Ended ended = viscobar("run bar.toml --error '0.01 %' -o out");
  ASSERT_EQ(ended.code, 0) << ended.error;
  EXPECT_NE(ended.out.find("asked for: kept"), std::string::npos) << ended.out;
}

TEST_F(AccuracyCommand, AnErrorThatAFixedKeyForbidsKeepsTheSolutionAndExitsAsAFailedRun) {
  const Ended ended = viscobar("run bar.toml --error 1e-6 --set mesh.elements=20 --json -o out");
  EXPECT_EQ(ended.code, 1);
  EXPECT_NE(ended.error.find("mesh.elements = 20 is kept"), std::string::npos) << ended.error;
  EXPECT_EQ(ended.json()["completed"], true);
  EXPECT_EQ(ended.json()["error_estimate"]["kept"], false);
  EXPECT_EQ(ended.json()["scene"]["mesh"]["elements"], 20);
}

TEST_F(AccuracyCommand, WhatCannotBeAskedForIsRefusedAtItsKey) {
  for (const auto& [settings, message] :
       {std::pair{"--set accuracy.error=0", "accuracy.error: must be positive"},
        {"--set 'accuracy.error=\"much\"'", "accuracy.error: must be a number, or a percentage"},
        {"--set 'accuracy.error=\"200 %\"'", "at most 100 %"},
        {"--set accuracy.of=impulse", "accuracy.error: is missing"},
        {"--error 1e-3 --set accuracy.of=impulses", "nearest is \"impulse\""},
        {"--error 1e-3 --set accuracy.of=peak_reaction", "has no limit"},
        {"--error 1e-3 --set left.kind=free --set accuracy.of=impulse", "no end has an obstacle"}}) {
    const Ended ended = viscobar(std::string("run bar.toml -o out ") + settings);
    EXPECT_EQ(ended.code, 2) << settings;
    EXPECT_NE(ended.error.find(message), std::string::npos) << settings << "\n" << ended.error;
    EXPECT_FALSE(fs::exists(directory_ / "out/summary.json")) << settings;
  }
}

TEST_F(AccuracyCommand, ASweepKeepsTheErrorInEachCase) {
  std::ofstream(directory_ / "sweep.toml") << "scene = \"bar.toml\"\n[vary]\n\"bar.viscosity\" = [0.05, 1]\n";
  const Ended ended = viscobar("sweep sweep.toml --error 1e-6 --json -o out");
  ASSERT_EQ(ended.code, 0) << ended.error;
  EXPECT_EQ(ended.json()["failed"].size(), 0u);
  const Ended fixed = viscobar("sweep sweep.toml --error 1e-6 --set mesh.elements=10 --json -o fixed");
  EXPECT_EQ(fixed.code, 1);
  EXPECT_EQ(fixed.json()["failed"].size(), 2u);
}

TEST_F(AccuracyCommand, ALimitStudyTakesTheMeshThatKeepsTheErrorAtEpsilonZero) {
  const auto elements = [&](const std::string& error) {
    const Ended ended = viscobar("limit bar.toml --epsilon 1e-3:1e-5 --json -o limit --error " + error);
    EXPECT_EQ(ended.code, 0) << ended.error;
    return ended.json()["rows"][0]["elements"].get<int>();
  };
  EXPECT_LT(elements("1e-2"), elements("1e-4"));
  const Ended both = viscobar("limit bar.toml --error 1e-2 --elements 20,40 -o limit");
  EXPECT_EQ(both.code, 2);
  EXPECT_NE(both.error.find("--error chooses the mesh"), std::string::npos) << both.error;
}

TEST_F(AccuracyCommand, ARunWithoutAnEstimateSaysWhy) {
  const Ended ended = viscobar("run bar.toml --set mesh.elements=8 --json -o out");
  ASSERT_EQ(ended.code, 0) << ended.error;
  EXPECT_TRUE(ended.json()["error_estimate"].is_null());
  EXPECT_NE(ended.json()["no_estimate"].get<std::string>().find("9 elements or more"), std::string::npos);
  EXPECT_NE(read_text(directory_ / "out/report.html").find("There is no estimate"), std::string::npos);
  EXPECT_NE(viscobar("run bar.toml --set mesh.elements=8 -o out").out.find("there is no estimate"), std::string::npos);
  EXPECT_NE(viscobar("check bar.toml --set mesh.elements=8").out.find("there is no estimate"), std::string::npos);
}

}  // namespace
}  // namespace viscobar::testing_cli

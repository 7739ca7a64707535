// A bar as engineers have it: steel of 1 m in SI units, and in others.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>

#include "cli/command.hpp"
#include "viscobar/case/recording.hpp"
#include "viscobar/input/scene_file.hpp"

namespace viscobar {
namespace {

using Steel = testing_cli::Command;

SceneFile steel(const std::string& name, const std::vector<std::string>& settings = {}) {
  return read_scene(VISCOBAR_SOURCE_DIR "/examples/scenes/" + name + ".toml", settings);
}

TEST_F(Steel, TouchesForThreeHundredAndEightySixMicroseconds) {
  const Recording run = record(steel("steel-bar").run);
  ASSERT_EQ(run.events.size(), 2u);
  EXPECT_NEAR(run.events[0].time, 2e-4, 1e-6 * 2e-4);
  // By the Laplace transform of the continuous bar. The error of the mesh is what twice the elements change it by, of
  // order 2 or more, so that it is less than 4/3 of that.
  const Recording fine = record(steel("steel-bar", {"mesh.elements=200"}).run);
  const auto duration = [](const Recording& r) { return r.events[1].time - r.events[0].time; };
  const double mesh_error = 4.0 / 3.0 * std::abs(duration(run) - duration(fine));
  EXPECT_LT(mesh_error, 1e-3 * 3.8585e-4);
  EXPECT_NEAR(duration(run), 3.8585e-4, mesh_error + 0.5e-8);
}

TEST_F(Steel, HasTheSameDigitsInMillimetresTonnesAndMilliseconds) {
  const Recording si = record(steel("steel-bar").run), mm = record(steel("steel-bar-mm").run);
  ASSERT_EQ(si.events.size(), mm.events.size());
  // The units are no powers of two: roundings of the data, magnified by what the steps are chosen by, and far below the
  // tolerance.
  for (std::size_t k = 0; k < si.events.size(); ++k)
    EXPECT_NEAR(mm.events[k].time, 1e3 * si.events[k].time, 1e-8 * mm.events[k].time);
  for (std::size_t i = 0; i < si.u.size(); ++i) ASSERT_NEAR(mm.u[i], 1e3 * si.u[i], 1e-7);
}

TEST_F(Steel, ByDefaultAPenaltyLetsItInByLessThanATenThousandthOfTheGap) {
  for (const char* method : {"cvode", "ida", "arkode", "odeint"}) {
    const SceneFile scene = steel("steel-bar", {fmt::format("method.name={}", method)});
    const Recording run = record(scene.run);
    // The error of odeint as the bar leaves closes the contact again for an instant.
    EXPECT_LE(run.events.size(), std::string(method) == "odeint" ? 16u : 2u) << method;
    EXPECT_GT(run.statistics.max_penetration, 0.0);
    EXPECT_LT(run.statistics.max_penetration, 1e-4 * 1e-3) << method;
  }
}

TEST_F(Steel, ThePenaltyOfPaperUnitsIsNoObstacleAndIsToldSo) {
  const std::string soft = " --set contact.epsilon=1e-6 --set method.name=arkode";
  const auto check = viscobar("check " + scene("steel-bar") + soft);
  EXPECT_EQ(check.code, 0);
  EXPECT_NE(check.error.find("a spring rather than an obstacle"), std::string::npos) << check.error;
  const auto run = viscobar("run " + scene("steel-bar") + soft + " --json -o out").json();
  EXPECT_GT(run["max_penetration"].get<double>(), 1e-3);
  ASSERT_EQ(run["warnings"].size(), 1u) << run["warnings"];
  EXPECT_NE(run["warnings"][0].get<std::string>().find("a spring rather than an obstacle"), std::string::npos);
  const auto limit = viscobar("limit " + scene("steel-bar") + " --epsilon 1e-2:1e-8 --json -o limit").json();
  EXPECT_EQ(limit["verdict"], "converges") << limit["reason"];
  EXPECT_LT(limit["rows"].back()["epsilon"].get<double>(), 1e-12)
      << "it goes on where springs are stiffer than the bar";
  // The remedy in the warning helps.
  EXPECT_EQ(viscobar("check " + scene("steel-bar") + soft + " --set contact.epsilon=").error, "");
}

TEST_F(Steel, ByDefaultThePenaltyLimitConverges) {
  EXPECT_EQ(viscobar("check " + scene("steel-bar")).error, "");
  const auto si = viscobar("limit " + scene("steel-bar") + " --json -o si").json();
  EXPECT_EQ(si["verdict"], "converges") << si["reason"];
  EXPECT_DOUBLE_EQ(si["rows"][0]["epsilon"].get<double>(), 1e-2 / 210e9);
  const auto mm = viscobar("limit " + scene("steel-bar-mm") + " --json -o mm").json();
  EXPECT_EQ(mm["verdict"], "converges") << mm["reason"];
}

TEST_F(Steel, TheChoicesOfTheProgramAreInTheSummary) {
  const auto summary = viscobar("run " + scene("steel-bar") + " --set method.name=arkode --json -o out").json();
  EXPECT_EQ(summary["chosen"]["mesh"]["elements"], 100);
  EXPECT_EQ(summary["chosen"]["mesh"]["mass"], "redistributed");
  EXPECT_EQ(summary["chosen"]["contact"]["epsilon"], summary["scene"]["contact"]["epsilon"]);
  EXPECT_GT(summary["absolute_tolerance"]["displacement"].get<double>(), 0.0);
  const auto scheme =
      viscobar("run " + scene("steel-bar") + " --set method.name=fully_discrete --json -o scheme").json();
  EXPECT_DOUBLE_EQ(scheme["chosen"]["method"]["step"].get<double>(), 0.01 / (100.0 * std::sqrt(210e9 / 7850.0)));
}

TEST_F(Steel, BetweenTwoWallsItMeetsTheRightOneFirstAndThenTheLeft) {
  const Recording run = record(steel("steel-two-walls").run);
  ASSERT_EQ(run.events.size(), 4u);
  const Where where[] = {Where::right, Where::right, Where::left, Where::left};
  for (std::size_t k = 0; k < 4; ++k) EXPECT_EQ(run.events[k].where, where[k]) << k;
  EXPECT_LT(run.statistics.account->right.impulse, 0.0);
  EXPECT_GT(run.statistics.account->left.impulse, 0.0);
}

}  // namespace
}  // namespace viscobar

#include <gtest/gtest.h>

#include <algorithm>
#include <string>

#include "viscobar/case/case.hpp"
#include "viscobar/input/scene_file.hpp"

namespace viscobar {
namespace {

const std::string bar = "[bar]\nlength = 2\n[initial]\nvelocity = -1\n[time]\nend = 1\n";

std::string told_of(const std::string& text) {
  try {
    parse_scene(text, "scene.toml");
  } catch (const SceneError& error) {
    return error.what();
  }
  return "";
}

testing::AssertionResult tells(const std::string& text, const std::string& what) {
  const std::string told = told_of(text);
  if (told.find(what) != told.npos) return testing::AssertionSuccess();
  return testing::AssertionFailure() << "\"" << told << "\" does not say \"" << what << "\"";
}

TEST(SideInput, RefusesWhatIsNegativeOrDependsOnTimeWithItsPlace) {
  EXPECT_TRUE(tells(bar + "[side]\nstiffness = -1\n", "scene.toml:8:13: side.stiffness: must not be negative, is -1"));
  EXPECT_TRUE(
      tells(bar + "[side]\ndrag = \"1-x\"\n", "scene.toml:8:8: side.drag: must be finite and not negative, is -"));
  EXPECT_TRUE(tells(bar + "[side]\nstiffness = \"2+t\"\n", "scene.toml:8:13: side.stiffness: "));
  EXPECT_TRUE(tells(bar + "[side]\n", "side.stiffness: is missing"));
  EXPECT_TRUE(tells(bar + "[side]\nstifness = 1\n", "nearest is \"stiffness\""));
}

TEST(SideInput, IsNothingWhereItIsZeroAndIsReadFromSeries) {
  EXPECT_FALSE(parse_scene(bar + "[side]\nstiffness = 0\ndrag = 0.0\n", "").run.scene.side);
  const Case run =
      parse_scene(bar + "[side]\nstiffness = { x = [0, 1, 2], values = [1, 3, 3], interpolation = \"linear\" }\n", "")
          .run;
  ASSERT_TRUE(run.scene.side && run.scene.side->stiffness);
  EXPECT_NEAR(run.scene.side->stiffness(0.5), 2.0, 1e-12);
  EXPECT_FALSE(run.scene.side->drag);
}

TEST(SideInput, CharacteristicsRefusesItAndAutomaticTakesRigidAndSaysWhy) {
  EXPECT_TRUE(
      tells(bar + "[side]\ndrag = 1\n[method]\nname = \"characteristics\"\n", "side.drag: is not for characteristics"));
  const Case run = parse_scene(bar + "[side]\ndrag = 1\n", "").run;
  EXPECT_EQ(run.method, MethodName::rigid);
  EXPECT_NE(run.warning.find("side.drag"), std::string::npos) << run.warning;
}

TEST(SideInput, SensitivityByAFormulaAsksForAParameter) {
  EXPECT_TRUE(tells(bar + "[side]\ndrag = \"1+x\"\n[method]\nname = \"rigid\"\n[sensitivity]\nof = [\"side.drag\"]\n",
                    "[parameters]"));
  EXPECT_TRUE(tells(bar + "[side]\ndrag = 1\n[method]\nname = \"rigid\"\n[sensitivity]\nof = [\"side.stiffness\"]\n",
                    "nothing resists the bar"));
}

}  // namespace
}  // namespace viscobar

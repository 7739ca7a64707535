#include "input/described_scene.hpp"

#include <gtest/gtest.h>

#include <filesystem>

namespace viscobar::testing_described_scene {
namespace {

TEST(DescribedScene, IsTheSceneAgainForEveryExample) {
  std::size_t scenes = 0;
  for (const auto& entry : std::filesystem::directory_iterator(VISCOBAR_SOURCE_DIR "/examples/scenes")) {
    if (entry.path().extension() != ".toml") continue;
    const std::string description = read_scene(entry.path()).description();
    EXPECT_EQ(described_scene(description, "again").description(), description) << entry;
    ++scenes;
  }
  EXPECT_GE(scenes, 5u);
}

// Each method has a mass of its own there, and a scene of finite_difference would be refused with that of the others.
TEST(DescribedScene, OfAComparisonOfMethodsLeavesOpenWhatWasChosen) {
  const auto case_of = [](const std::string& study) {
    return parse_scene("{" + study + R"("chosen": {"mesh": {"mass": "redistributed"}}, "scene": {"bar": {"length": 1},
      "left": {"kind": "obstacle", "gap": 0.1}, "initial": {"velocity": -1}, "time": {"end": 1},
      "mesh": {"elements": 20, "mass": "redistributed"}, "method": {"name": "cvode"}, "contact": {"epsilon": 1e-3}}})",
                       "study.json")
        .run;
  };
  for (const char* study : {R"("pairs": [], )", R"("parts": [], )"}) {
    EXPECT_FALSE(case_of(study).mass) << study;
    EXPECT_EQ(case_of(study).elements, 20u) << study;
  }
}

TEST(DescribedScene, KeepsEveryCharacterAndEveryDigit) {
  const char* text = R"toml(
title = "quotes \" backslashes \\ tabs \t lines \n bells \u0007 deletes \u007F beams \u2261 and \U0001F600"
[bar]
length = 0.1
density = 1e-90
modulus = 1.2345678901234567e99
[initial]
displacement = "x > 0.05 ? sin(pi*x) : 3e-5"
velocity = 0.30000000000000004
[time]
end = 3
[mesh]
elements = 7
[method]
name = "fully_discrete"
step = 1e-3
)toml";
  const SceneFile scene = parse_scene(text, "scene");
  const SceneFile again = described_scene(scene.description(), "again");
  EXPECT_EQ(again.description(), scene.description());
  EXPECT_EQ(again.run.scene.title, scene.run.scene.title);
  EXPECT_EQ(again.run.scene.velocity(0.0), 0.30000000000000004);
  EXPECT_EQ(again.run.scene.displacement(0.07), scene.run.scene.displacement(0.07));
}

// A value that the program chooses stands where the user's would, not behind the other keys of its table.
TEST(DescribedScene, IsTheSceneAgainWhereATableHasSomeOfItsKeys) {
  const SceneFile scene = parse_scene(
      "[bar]\nlength = 1\n[initial]\nvelocity = 1\n[time]\nend = 3\n[output]\nwrite = [\"ends\"]\n", "scene");
  EXPECT_EQ(described_scene(scene.description(), "again").description(), scene.description());
}

// Settings that a search ends with are told as if the scene had said it, in the order of the keys, and the rest stays.
TEST(DescribedScene, WithOtherSettingsReadsBackAndTellsWhatWasChosen) {
  const SceneFile scene = parse_scene(
      "[bar]\nlength = 1\nviscosity = 0.1\n[left]\nkind = \"obstacle\"\ngap = 0\n[initial]\nvelocity = -1\n[time]\nend = 3\n"
      "[mesh]\nmass = \"lumped\"\n[contact]\nepsilon = 1e-3\n[parameters]\nb = 2.0\na = 1.0\n",
      "scene");
  Case chosen = scene.run;
  chosen.elements = 37;
  chosen.tolerance.relative = 0.1 / 3.0;
  const SceneFile settled = with_settings(scene, chosen);
  const SceneFile again = described_scene(settled.description(), "again");
  EXPECT_EQ(again.description(), settled.description());
  EXPECT_EQ(again.run.elements, 37u);
  EXPECT_EQ(again.run.tolerance.relative, 0.1 / 3.0);
  EXPECT_EQ(again.run.mass, Mass::lumped);
  EXPECT_EQ(again.run.epsilon, 1e-3);
  ASSERT_NE(value_of(settled.chosen, "mesh.elements"), nullptr);
  EXPECT_EQ(*value_of(settled.chosen, "mesh.elements"), SceneValue(std::int64_t{37}));
  EXPECT_EQ(value_of(settled.chosen, "mesh.mass"), nullptr);
}

}  // namespace
}  // namespace viscobar::testing_described_scene

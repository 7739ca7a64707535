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

}  // namespace
}  // namespace viscobar::testing_described_scene

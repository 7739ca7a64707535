#include "campaign/sound.hpp"

#include <gtest/gtest.h>

namespace viscobar::campaign {
namespace {

// Slices of what measure_sound runs.
TEST(SoundCampaign, NoSoundRunFails) {
  std::size_t ran = 0;
  for (std::size_t index = 0; index < 300; ++index) {
    const std::string scene = sound_scene(11, index);
    const Sounded sounded = run_sound(scene);
    EXPECT_NE(sounded.end, End::failed) << index << ": " << sounded.said << "\n" << scene;
    ran += sounded.end <= End::warned;
  }
  EXPECT_GT(ran, 200u);
}

TEST(SoundCampaign, EveryFalsifiedAccountFails) {
  std::size_t spoiled = 0;
  for (std::size_t index = 0; index < 100; ++index) {
    const std::string scene = sound_scene(12, index);
    const Sounded sounded = run_spoiled(scene, 12, index);
    if (sounded.end == End::refused) continue;
    ++spoiled;
    EXPECT_EQ(sounded.end, End::failed) << index << ": " << sounded.said << "\n" << scene;
  }
  EXPECT_GT(spoiled, 30u);
}

}  // namespace
}  // namespace viscobar::campaign

#include "campaign/campaign.hpp"

#include <gtest/gtest.h>

namespace viscobar::campaign {
namespace {

// A slice of what measure_campaign runs; in parts, for the tests run side by side.
class Campaign : public testing::TestWithParam<std::size_t> {};

constexpr std::size_t part = 250;

TEST_P(Campaign, KeepsThePromiseOrIsMagnifiedAlarmsOnlyWhatIsWrongAndHasNoPhantomContacts) {
  std::size_t judged = 0, resting = 0;
  for (std::size_t index = GetParam() * part; index < (GetParam() + 1) * part; ++index) {
    const SceneFile scene = parse_scene(scene_text(7, index), "random.toml");
    const Judged result = judge(scene);
    EXPECT_NE(result.outcome, Outcome::wrong)
        << index << ": " << result.error << " promises, magnified " << result.magnification << " times\n"
        << scene_text(7, index);
    if (result.outcome == Outcome::kept) {
      EXPECT_EQ(result.said, "") << index << "\n" << scene_text(7, index);
    }
    EXPECT_EQ(result.phantom, "") << index << "\n" << scene_text(7, index);
    judged += result.outcome != Outcome::too_long && result.outcome != Outcome::stopped;
    resting += result.late > 0.0;
  }
  EXPECT_GT(judged, part * 9 / 10);
  EXPECT_GT(resting, part / 50);  // contacts come to rest, and leave it
}

INSTANTIATE_TEST_SUITE_P(Parts, Campaign, testing::Range(std::size_t{0}, std::size_t{4}));

}  // namespace
}  // namespace viscobar::campaign

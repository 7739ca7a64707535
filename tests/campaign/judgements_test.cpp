#include "campaign/judgements.hpp"

#include <gtest/gtest.h>

namespace viscobar::campaign {
namespace {

// A slice of what measure_judgements runs: each way to spoil a solution, and sound ones between.
TEST(JudgementCampaign, SoundSolutionsAreNotBlamedAndSpoiledOnesAre) {
  std::size_t judged = 0;
  for (std::size_t index = 0; index < 40; ++index) {
    const JudgedSample one = run_judgement(3, index);
    EXPECT_NE(one.verdict, Verdict::false_) << index << ", " << one.spoiled << ": " << one.said << "\n"
                                            << judged_scene(3, index);
    judged += one.verdict == Verdict::right;
  }
  EXPECT_GT(judged, 30u);
}

}  // namespace
}  // namespace viscobar::campaign

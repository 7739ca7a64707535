// Runs that keep an error, with their files.
#include <gtest/gtest.h>

#include <atomic>
#include <nlohmann/json.hpp>

#include "support/scratch.hpp"
#include "viscobar/input/scene_file.hpp"
#include "viscobar/record/record_run.hpp"

namespace viscobar {
namespace {

constexpr const char* rebound =
    "[bar]\nlength=1\nviscosity=0.1\n[left]\nkind=\"obstacle\"\ngap=0\n[initial]\nvelocity=-1\n[time]\nend=2.5\n"
    "[accuracy]\nerror=1e-6\n";

// The estimate is made anew, from a ladder of meshes that ends at the one that was chosen: where the search for it took
// other steps, it is another one of the same size.
TEST(ResumedToAccuracy, ARunHasItsEstimateOfTheSameSettings) {
  const Scratch scratch;
  const SceneFile scene = parse_scene(rebound, "rebound");
  const RunRecord whole = record_to_accuracy(scene, scratch / "whole");
  ASSERT_TRUE(whole.outcome.error_estimate && whole.outcome.error_estimate->kept);

  std::atomic<bool> enough = false;
  RecordOptions options;
  options.snapshot = [&](const Snapshot& at) { enough = at.time > 1.0; };
  options.stop = [&] { return enough.load(); };
  const RunRecord stopped = record_to_accuracy(scene, scratch / "out", options);
  ASSERT_EQ(stopped.outcome.ending, Ending::interrupted);
  EXPECT_FALSE(stopped.outcome.error_estimate);

  const SceneFile rest = scene_of_checkpoint(scratch / "out");
  EXPECT_EQ(rest.run.elements, whole.run->elements);
  const RunRecord resumed = resume_to_accuracy(rest, scratch / "out");
  ASSERT_TRUE(resumed.outcome.error_estimate);
  EXPECT_TRUE(resumed.outcome.error_estimate->kept) << resumed.outcome.error_estimate->doubt;
  EXPECT_NEAR(resumed.outcome.error_estimate->total / whole.outcome.error_estimate->total, 1.0, 0.5);
  EXPECT_DOUBLE_EQ(*resumed.outcome.error_estimate->requested, 1e-6);
  const auto told = [](const RunRecord& of) {
    nlohmann::json summary = nlohmann::json::parse(of.summary);
    return nlohmann::json{summary["chosen"], summary["scene"], summary["method_requested"]};
  };
  EXPECT_EQ(told(resumed), told(whole));
  for (const std::string& reason : resumed.outcome.error_estimate->reasons)
    EXPECT_EQ(reason.find("as the scene says"), reason.npos) << reason;
}

}  // namespace
}  // namespace viscobar

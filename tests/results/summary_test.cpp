#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <numeric>

#include "support/absolute_tolerance.hpp"
#include "support/scratch.hpp"
#include "viscobar/record/record_run.hpp"
#include "viscobar/run/run.hpp"

namespace viscobar::testing_summary {
namespace {

using Json = nlohmann::json;

TEST(RunAccount, AddsUpTimesFromContactChanges) {
  RunAccount account;
  account.count({0.5, Where::left, 0, Change::closing, -1.0});
  account.count({1.25, Where::left, 0, Change::opening, 1.0});
  account.count({2.5, Where::left, 0, Change::closing, -1.0});
  EXPECT_EQ(account.left.closings, 2u);
  EXPECT_EQ(account.left.contact.total(3.0), 0.75 + 0.5);
  EXPECT_EQ(account.right.closings, 0u);
}

TEST(RunAccount, ASpanIsInContactWhileAnyOfItsNodesIs) {
  RunAccount account;
  account.count({0.5, Where::span, 3, Change::closing, -1.0});
  account.count({1.0, Where::span, 4, Change::closing, -1.0});
  account.count({1.5, Where::span, 3, Change::opening, 1.0});
  account.count({2.0, Where::span, 4, Change::opening, 1.0});
  account.count({4.0, Where::span, 3, Change::closing, -1.0});
  EXPECT_EQ(account.span.contact.total(4.25), 1.5 + 0.25);
  EXPECT_EQ(account.span.closed(), 1u);
}

TEST(Summary, HasEveryPromisedKeyAndTheBooksBalance) {
  const Scratch scratch;
  const RunRecord record = record_run(bouncing_bar(), scratch / "out");
  const Json summary = Json::parse(record.summary);
  EXPECT_EQ(read_text(scratch / "out/summary.json"), record.summary);
  for (const char* key : {"method",
                          "unknowns",
                          "steps",
                          "rhs_evaluations",
                          "linear_solves",
                          "matrix_factorisations",
                          "event_evaluations",
                          "load_evaluations",
                          "events",
                          "wall_seconds",
                          "integration_seconds",
                          "reached_time",
                          "completed",
                          "max_penetration",
                          "energy",
                          "scene",
                          "mass",
                          "contact",
                          "versions",
                          "platform",
                          "error"})
    EXPECT_TRUE(summary.contains(key)) << key;
  for (const char* key : {"initial", "final", "dissipated", "work", "balance_error"})
    EXPECT_TRUE(summary["energy"][key].is_number()) << key;
  EXPECT_EQ(summary["method"], "cvode");
  EXPECT_EQ(summary["completed"], true);
  EXPECT_EQ(summary["reached_time"], 1.0);
  EXPECT_EQ(summary["load_evaluations"], 0);
  EXPECT_EQ(summary["scene"]["bar"]["viscosity"], 0.5);
  EXPECT_TRUE(summary["error"].is_null());
  EXPECT_LE(summary["integration_seconds"], summary["wall_seconds"]);
  for (const char* library : {"viscobar", "sundials", "hdf5", "eigen"})
    EXPECT_FALSE(summary["versions"][library].get<std::string>().empty());
}

TEST(Summary, TheImpulseOfTheReactionIsTheGainOfMomentum) {
  const Scratch scratch;
  const SceneFile scene = bouncing_bar();
  double momentum = 0.0;
  const BarSystem system = resolve(scene.run).system();
  Observers last;
  last.snapshot = [&](const Snapshot& at) {
    std::vector<double> weighted(system.size());
    system.inertia().matrix().multiply(at.v, weighted);
    momentum = std::accumulate(weighted.begin(), weighted.end(), 0.0);
  };
  simulate(resolve(scene.run), system, last);
  const Json summary = Json::parse(record_run(scene, scratch.path()).summary);
  const double impulse = summary["contact"]["left"]["impulse"];
  // Both are within a hundred tolerances of the velocity, of size 0.3.
  EXPECT_NEAR(impulse, momentum - (-0.3), 100.0 * (scene.run.tolerance.relative * 0.3 + absolute_tolerance(scene.run)));
  EXPECT_GT(impulse, 0.3);
}

TEST(Summary, AnEndWithoutObstacleHasNoContact) {
  const Scratch scratch;
  const Json summary = Json::parse(record_run(bouncing_bar(), scratch.path()).summary);
  EXPECT_TRUE(summary["contact"].contains("left"));
  EXPECT_FALSE(summary["contact"].contains("right"));
  EXPECT_FALSE(summary["contact"].contains("span"));
}

}  // namespace
}  // namespace viscobar::testing_summary

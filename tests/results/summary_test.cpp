#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <numeric>

#include "results/contact_account.hpp"
#include "support/scratch.hpp"
#include "viscobar/record/record_run.hpp"

namespace viscobar {
namespace {

using Json = nlohmann::json;

TEST(ContactAccount, AddsUpTimesFromEventsAndImpulseFromOutputTimes) {
  ContactAccount account;
  account.add(0.0, 0.0);
  account.add({0.5, Where::left, 0, Change::closing, -1.0});
  account.add(1.0, 4.0);
  account.add({1.25, Where::left, 0, Change::opening, 1.0});
  account.add(2.0, 0.0);
  account.add({2.5, Where::left, 0, Change::closing, -1.0});
  EXPECT_EQ(account.closings(), 2u);
  EXPECT_EQ(account.duration(3.0), 0.75 + 0.5);
  EXPECT_EQ(account.impulse(), 2.0 + 2.0);
  EXPECT_EQ(account.max_reaction(), 4.0);
  ASSERT_EQ(account.intervals(3.0).size(), 2u);
  EXPECT_EQ(account.intervals(3.0)[1].end, 3.0);
}

TEST(ContactAccount, AnEndThatPressesFromTheStartIsInContactFromThere) {
  ContactAccount account;
  account.add(1.0, 2.0);
  account.add({3.0, Where::left, 0, Change::opening, 1.0});
  EXPECT_EQ(account.closings(), 0u);
  EXPECT_EQ(account.duration(5.0), 2.0);
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
  SceneFile scene = bouncing_bar();
  double momentum = 0.0;
  const BarSystem system = make_system(scene.run);
  Observers last;
  last.snapshot = [&](const Snapshot& at) {
    std::vector<double> weighted(system.size());
    system.inertia().multiply(at.v, weighted);
    momentum = std::accumulate(weighted.begin(), weighted.end(), 0.0);
  };
  simulate(scene.run, system, last);
  scene.run.output_every = 1e-4;
  const Json summary = Json::parse(record_run(scene, scratch.path()).summary);
  const double impulse = summary["contact"]["left"]["impulse"], largest = summary["contact"]["left"]["max_reaction"];
  // Trapezoidal rule: its error is that of the intervals in which the reaction jumps, one a contact change.
  const double changes = summary["events"];
  EXPECT_NEAR(impulse, momentum - (-0.3), changes * largest * scene.run.output_every);
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
}  // namespace viscobar

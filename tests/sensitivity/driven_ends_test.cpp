// Sensitivities of scenes whose ends are pushed, mounted or moved.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "viscobar/case/recording.hpp"
#include "viscobar/input/scene_file.hpp"

namespace {

using namespace viscobar;

struct Driven {
  const char* what;
  std::string ends;               // tables of the ends
  std::vector<std::string> keys;  // to differentiate by
  const char* bar = "viscosity = 0.08";
};

std::string scene_of(const Driven& driven) {
  return fmt::format(R"~(
[bar]
length = 1.2
density = 1.1
modulus = 1.3
{}
{}
[initial]
displacement = "0.01*x*(1.2 - x)"
velocity = "-speed*x*(1.2 - x)"
[load]
density = "0.3*sin(2*t)"
[parameters]
speed = 1.0
push = 0.4
omega = 3.0
depth = 0.1
[time]
end = 3.0
[mesh]
elements = 10
[contact]
epsilon = 1e-2
[method]
relative_tolerance = 1e-10
)~",
                     driven.bar, driven.ends);
}

SceneFile parsed(const std::string& text, const std::vector<std::string>& settings) {
  return parse_scene(text, "scene", settings);
}

double value(const SceneFile& scene, const std::string& key) {
  const Scene& of = scene.run.scene;
  if (key == "bar.viscosity") return of.bar.viscosity;
  if (key == "bar.density") return of.bar.density;
  if (key == "bar.modulus") return of.bar.modulus;
  if (key == "bar.length") return of.bar.length;
  if (key == "left.gap") return std::get<Obstacle>(of.left).gap;
  if (key == "right.stiffness") return of.right_input.stiffness;
  if (key == "right.dashpot") return of.right_input.dashpot;
  if (key == "left.dashpot") return of.left_input.dashpot;
  if (key == "left.stiffness") return of.left_input.stiffness;
  if (key == "left.mass") return of.left_input.mass;
  if (key == "right.mass") return of.right_input.mass;
  if (key == "parameters.push") return 0.4;
  if (key == "parameters.omega") return 3.0;
  if (key == "parameters.depth") return 0.1;
  return 1.0;
}

// Central differences of runs over 1e-4: their error is the square of that, times a third derivative, and 1e-10 over
// it, 1e-6 times what the tolerance promises.
void expect_slopes(const Driven& driven, const std::string& method) {
  const std::string text = scene_of(driven), name = fmt::format("method.name={}", method);
  std::string list;
  for (const std::string& key : driven.keys) list += fmt::format("{}\"{}\"", list.empty() ? "" : ",", key);
  const SceneFile scene = parsed(text, {name, "sensitivity.of=[" + list + "]"});
  const Recording with = record(scene.run);
  ASSERT_FALSE(with.statistics.sensitivity->lost.has_value()) << with.statistics.sensitivity->why;
  ASSERT_EQ(with.sensitivities.size(), driven.keys.size());
  ASSERT_GE(with.events.size(), 1u) << driven.what << " by " << method;
  for (std::size_t k = 0; k < driven.keys.size(); ++k) {
    const std::string& key = driven.keys[k];
    const std::string what = fmt::format("{}: {} by {}", driven.what, key, method);
    // A contact node without mass relaxes in 1/150, and the gap moves its contact times most.
    const double step = key == "left.gap" ? 1e-5 : 1e-4;
    const auto moved = [&](double by) {
      return record(parsed(text, {name, fmt::format("{}={}", key, value(scene, key) + by)}).run);
    };
    const Recording more = moved(step), less = moved(-step);
    const auto compare = [&](const std::vector<double>& told, const std::vector<double>& high,
                             const std::vector<double>& low, const char* of) {
      double largest = 0.0, worst = 0.0;
      for (std::size_t i = 0; i < told.size(); ++i) {
        const double slope = (high[i] - low[i]) / (2.0 * step);
        largest = std::max(largest, std::abs(slope));
        worst = std::max(worst, std::abs(told[i] - slope));
      }
      EXPECT_GT(largest, 0.0) << what << ", " << of;
      EXPECT_LT(worst, 1e-4 * largest) << what << ", " << of;
    };
    const RecordedSensitivity& s = with.sensitivities[k];
    compare(s.u, more.u, less.u, "u");
    ASSERT_EQ(more.events.size(), with.events.size()) << what;
    ASSERT_EQ(less.events.size(), with.events.size()) << what;
    const auto near = [&](double told, double high, double low, const char* of) {
      const double slope = (high - low) / (2.0 * step);
      EXPECT_NEAR(told, slope, 1e-4 * std::max(1.0, std::abs(slope))) << what << ", " << of;
    };
    for (std::size_t i = 0; i < with.events.size(); ++i) {
      const ChangeSensitivity& change = with.events[i].sensitivities[k];
      near(change.time, more.events[i].time, less.events[i].time, "time");
      near(change.velocity, more.events[i].velocity, less.events[i].velocity, "velocity");
    }
    near(with.statistics.sensitivity->impulse_left[k], more.statistics.account->left.impulse,
         less.statistics.account->left.impulse, "impulse");
    near(with.statistics.sensitivity->energy[k], more.statistics.energy->final, less.statistics.energy->final,
         "energy");
  }
}

const std::vector<std::string> material = {"bar.viscosity", "bar.density", "bar.modulus", "bar.length"};

std::vector<std::string> with(std::vector<std::string> more) {
  more.insert(more.end(), material.begin(), material.end());
  return more;
}

void expect_slopes(const Driven& driven) {
  for (const char* method : {"rigid", "cvode", "ida", "arkode"}) expect_slopes(driven, method);
}

std::string before_an_obstacle(const std::string& right) {
  return "[left]\nkind = \"obstacle\"\ngap = 0.02\n[right]\n" + right;
}

TEST(SensitivitiesOfDrivenEnds, AreTheSlopesOfRunsUnderForcesAndWithAFixedEndInMotion) {
  for (const char* right : {"kind = \"free\"\nforce = \"-push*(1 + sin(omega*t))\"",
                            "kind = \"fixed\"\nmotion = \"-push*(1 - cos(omega*t))\""})
    expect_slopes({right, before_an_obstacle(right), with({"parameters.push", "parameters.omega", "left.gap"})});
}

TEST(SensitivitiesOfDrivenEnds, AreTheSlopesOfRunsOnSpringsAndDashpots) {
  expect_slopes({"mounts", R"~(
[left]
kind = "obstacle"
gap = 0.02
stiffness = 0.7
dashpot = 0.2
[right]
kind = "free"
force = -0.4
stiffness = 0.5
dashpot = 0.3)~",
                 with({"left.stiffness", "left.dashpot", "right.stiffness", "right.dashpot", "left.gap"})});
}

// Also of the filter of jumps, which the force at the start sets going, and of a frame that moves.
TEST(SensitivitiesOfDrivenEnds, AreTheSlopesOfRunsWithMasses) {
  expect_slopes({"masses", R"~(
[left]
kind = "obstacle"
gap = 0.02
mass = 0.3
[right]
kind = "free"
force = -0.4
mass = 0.6
dashpot = 0.3)~",
                 with({"left.mass", "right.mass", "right.dashpot", "left.gap"})});
  expect_slopes({"mass behind a moving obstacle", R"~(
[left]
kind = "obstacle"
gap = "depth - push*t*exp(-omega*t)"
mass = 0.2
[right]
kind = "free"
force = -0.5)~",
                 with({"left.mass", "parameters.depth"})},
                "rigid");
}

TEST(SensitivitiesOfDrivenEnds, AreTheSlopesOfRunsAgainstAnObstacleThatMoves) {
  for (const char* right : {"kind = \"free\"\nforce = -0.5\ndashpot = 0.2", "kind = \"fixed\"\nmotion = \"-0.3*t\""})
    expect_slopes({"gap(t)",
                   fmt::format(R"~(
[left]
kind = "obstacle"
gap = "depth - push*t*exp(-omega*t)"
[right]
{})~",
                               right),
                   with({"parameters.depth", "parameters.push", "parameters.omega", "parameters.speed"})});
}

// At 1.1 and 1.9 the end stops and goes on, in touch or not.
TEST(SensitivitiesOfDrivenEnds, PassKinksOfAMotion) {
  for (const char* method : {"cvode", "ida", "arkode"})
    expect_slopes({"kinks", before_an_obstacle("kind = \"fixed\"\nmotion = \"-push*(min(t, 1.1) + max(t - 1.9, 0))\""),
                   with({"parameters.push", "left.gap"})},
                  method);
}

TEST(SensitivitiesOfDrivenEnds, EndWhereAKinkMovesWithTheParameter) {
  const Driven driven{"kinks",
                      R"~(
[left]
kind = "fixed"
[right]
kind = "fixed"
motion = "min(push*t, 0.2)")~",
                      {}};
  const Recording found = record(parsed(scene_of(driven), {"sensitivity.of=[\"parameters.push\"]"}).run);
  ASSERT_TRUE(found.statistics.sensitivity->lost.has_value());
  EXPECT_NEAR(*found.statistics.sensitivity->lost, 0.5, 1e-12);
  EXPECT_NE(found.statistics.sensitivity->why.find("parameters.push"), std::string::npos);
}

}  // namespace

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
  std::vector<std::string> settings{};
  const char* scene = nullptr;  // all of it, in place of what is above
  bool has_velocities = true;   // of contact changes
};

std::string scene_of(const Driven& driven) {
  if (driven.scene) return driven.scene;
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
  if (key == "parameters.c") return -0.6;
  return 1.0;
}

// Central differences of runs over 1e-4: their error is the square of that, times a third derivative, and 1e-10 over
// it, 1e-6 times what the tolerance promises.
void expect_slopes(const Driven& driven, const std::string& method) {
  const std::string text = scene_of(driven);
  const auto set = [&](const std::string& more) {
    std::vector<std::string> all = driven.settings;
    all.insert(all.end(), {fmt::format("method.name={}", method), more});
    return all;
  };
  std::string list;
  for (const std::string& key : driven.keys) list += fmt::format("{}\"{}\"", list.empty() ? "" : ",", key);
  const SceneFile scene = parsed(text, set("sensitivity.of=[" + list + "]"));
  const Recording with = record(scene.run);
  ASSERT_FALSE(with.statistics.sensitivity->lost.has_value()) << with.statistics.sensitivity->why;
  ASSERT_EQ(with.sensitivities.size(), driven.keys.size());
  ASSERT_GE(with.events.size(), 1u) << driven.what << " by " << method;
  for (std::size_t k = 0; k < driven.keys.size(); ++k) {
    const std::string& key = driven.keys[k];
    const std::string what = fmt::format("{}: {} by {}", driven.what, key, method);
    // A contact node without mass relaxes in 1/150, and the gap moves its contact times most.
    const double step = key == "left.gap" || key == "parameters.depth" ? 1e-5 : 1e-4;
    const auto moved = [&](double by) {
      return record(parsed(text, set(fmt::format("{}={}", key, value(scene, key) + by))).run);
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
      if (driven.has_velocities) near(change.velocity, more.events[i].velocity, less.events[i].velocity, "velocity");
    }
    if (is_obstacle(scene.run.scene.left))
      near(with.statistics.sensitivity->impulse_left[k], more.statistics.account->left.impulse,
           less.statistics.account->left.impulse, "impulse");
    if (is_obstacle(scene.run.scene.right))
      near(with.statistics.sensitivity->impulse_right[k], more.statistics.account->right.impulse,
           less.statistics.account->right.impulse, "impulse");
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

// A spot narrower than an element moves and beats with one parameter: either factor's rate is met as the load is.
TEST(SensitivitiesOfDrivenEnds, AreTheSlopesOfRunsUnderAProductOfWhichBothFactorsDependOnTheParameter) {
  Driven driven{"a spot", before_an_obstacle("kind = \"free\""), {"parameters.omega", "bar.length"}};
  driven.settings = {"load.density=-20*exp(-((x - 0.23*omega)/0.03)^2)*sin(omega*t)"};
  expect_slopes(driven);
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

// The velocities that an impact gives to a few elements depend on the mass at their other end.
TEST(SensitivitiesOfDrivenEnds, AreTheSlopesOfImpactsOfALightBarBetweenMasses) {
  expect_slopes({"a light bar", "", {"bar.density", "bar.modulus", "left.mass", "right.mass"}, "", {}, R"~(
[bar]
length = 1.0
viscosity = 0.05
[left]
kind = "obstacle"
gap = 0.1
mass = 0.3
[right]
kind = "free"
mass = 2.0
[initial]
velocity = "-1.0 + 0.1*x"
[time]
end = 0.3
[mesh]
elements = 4
mass = "consistent"
[contact]
restitution = 0.5
[method]
relative_tolerance = 1e-10
)~"},
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

TEST(SensitivitiesOfDrivenEnds, AreTheSlopesOfRunsThatBeginOnAnObstacleThatMoves) {
  for (const char* right : {"kind = \"free\"\nforce = \"-push\"", "kind = \"fixed\"\nmotion = \"-push*t\""})
    expect_slopes({"gap(t) from 0",
                   fmt::format(R"~(
[left]
kind = "obstacle"
gap = "-depth*sin(omega*t)"
[right]
{})~",
                               right),
                   with({"parameters.depth", "parameters.omega", "parameters.push", "parameters.speed"})});
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

// The obstacle comes to the bar, which a force holds against it, and stops in touch: at 0.31 / push, where the force of
// a dashpot jumps, as does that of a row which an obstacle holds without mass.
TEST(SensitivitiesOfDrivenEnds, PassAKinkOfAnObstacleThatMovesWithTheParameter) {
  const std::vector<std::string> keys = {"parameters.push", "parameters.depth", "bar.viscosity"};
  const std::string mass = "mesh.mass=fourth_order";
  const std::string hertz = "left.contact={ law = \"hunt_crossley\", stiffness = 50.0, damping = 20.0 }";
  for (const bool right : {false, true}) {
    const std::string ends =
        fmt::format(R"~(
[{}]
kind = "obstacle"
side = "{}"
gap = "max(depth - push*t, -0.21)"
[{}]
kind = "free"
force = {}
dashpot = 0.2)~",
                    right ? "right" : "left", right ? "above" : "below", right ? "left" : "right", right ? 0.8 : -0.8);
    for (const char* method : {"cvode", "ida", "arkode"}) {
      expect_slopes({"springs", ends, keys, "viscosity = 0.08", {mass}}, method);
      expect_slopes({"dashpots", ends, keys, "viscosity = 0.08", {"contact.restitution=0.4", mass}}, method);
      if (!right) expect_slopes({"a law", ends, keys, "viscosity = 0.08", {hertz, mass}}, method);
    }
    expect_slopes({"a row", ends, keys, "viscosity = 0.08", {"mesh.mass=redistributed"}}, "rigid");
  }
}

// The kink is at t = 0.15 / a, where the obstacle turns away from the bar that moves on with it.
TEST(SensitivitiesOfDrivenEnds, KnowWhenAKinkOpensAContact) {
  const SceneFile scene = parsed(R"~(
[bar]
length = 1.0
viscosity = 0.1
[left]
kind = "obstacle"
gap = "max(0.05, 0.2 - a*t)"
force = -0.7
[initial]
velocity = -0.5
[mesh]
elements = 20
[method]
name = "rigid"
[time]
end = 2.0
[parameters]
a = 0.1
[sensitivity]
of = ["bar.viscosity", "parameters.a"]
)~",
                                 {});
  const Recording found = record(scene.run);
  ASSERT_GE(found.events.size(), 3u);
  EXPECT_EQ(found.events[1].change, Change::opening);
  EXPECT_NEAR(found.events[1].time, 1.5, 1e-12);
  EXPECT_EQ(found.events[1].sensitivities[0].time, 0.0);
  EXPECT_NEAR(found.events[1].sensitivities[1].time, -15.0, 1e-9);
  for (const std::size_t k : {0, 1}) {
    EXPECT_TRUE(std::isnan(found.events[1].sensitivities[k].velocity));
    EXPECT_TRUE(std::isnan(found.events[2].sensitivities[k].time));
  }
  ASSERT_TRUE(found.statistics.sensitivity->lost.has_value());
  EXPECT_NEAR(*found.statistics.sensitivity->lost, 1.5, 1e-12);
}

// A force that turns at 0.7 presses the end back before it has got away: what the mesh does not resolve of that is put
// right at once, and no further than the obstacle.
TEST(SensitivitiesOfDrivenEnds, PassAJumpThatPutsAnEndOnItsObstacle) {
  for (const char* method : {"cvode", "ida", "arkode"})
    expect_slopes({"a force that turns",
                   "",
                   {"bar.modulus", "left.gap", "bar.density", "left.stiffness"},
                   "",
                   {},
                   R"~(
[bar]
length = 0.536
density = 0.6494
modulus = 1.143
viscosity = 0.01096
[left]
kind = "obstacle"
gap = 0.08677
side = "above"
stiffness = 2.827
force = "t < 0.7 ? -0.06443 : 0.06443"
[right]
kind = "free"
mass = 1.212
[initial]
velocity = "1.193*x*x"
[contact]
epsilon = 0.003155
[mesh]
elements = 8
mass = "fourth_order"
[method]
relative_tolerance = 1e-10
[time]
end = 1.0
[output]
every = 0.02
)~"},
                  method);
}

// A node without mass or viscosity follows the load at once, and its derivative that of the load.
TEST(SensitivitiesOfDrivenEnds, FollowAJumpOfTheLoadThatAParameterMultiplies) {
  for (const char* method : {"rigid", "ida", "arkode"})
    expect_slopes({"a load that ends",
                   "",
                   {"parameters.c", "left.gap"},
                   "",
                   {},
                   R"~(
[bar]
length = 1.0
[left]
kind = "obstacle"
gap = 0.1
[initial]
velocity = -0.5
[load]
density = "t < 1 ? c : 0"
[contact]
epsilon = 1e-3
[mesh]
elements = 8
mass = "redistributed"
[method]
relative_tolerance = 1e-10
[time]
end = 1.5
[parameters]
c = -0.6
)~",
                   false},
                  method);
}

}  // namespace

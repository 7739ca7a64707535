// An obstacle above is one below in a mirror.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>

#include "support/maximum_norm.hpp"
#include "viscobar/case/recording.hpp"
#include "viscobar/input/scene_file.hpp"

namespace viscobar {
namespace {

/// A bar, its obstacles and loads; `sign` -1 turns all displacements.
struct Mirrored {
  std::string name, left, right, span;
  double viscosity = 0.02;

  Case at(int sign, const std::string& method, const std::string& mass) const {
    const auto side = [&](const std::string& text) {
      std::string turned = text;
      const auto at = turned.find("SIDE");
      if (at != turned.npos) turned.replace(at, 4, sign > 0 ? "below" : "above");
      const auto other = turned.find("OTHER");
      if (other != turned.npos) turned.replace(other, 5, sign > 0 ? "above" : "below");
      for (auto at_sign = turned.find("SIGN"); at_sign != turned.npos; at_sign = turned.find("SIGN"))
        turned.replace(at_sign, 4, sign > 0 ? "1" : "-1");
      return turned;
    };
    const std::string text = fmt::format(
        "[bar]\nlength = 1\nviscosity = {}\n{}{}{}[initial]\ndisplacement = \"{}*(0.3*x*(1-x))\"\n"
        "velocity = \"{}*(-1-0.3*x)\"\n[load]\nprofile = \"{}*(-2-x)\"\nhistory = \"1+0.3*sin(2*t)\"\n[time]\nend = 3\n"
        "[mesh]\nelements = 12\nmass = \"{}\"\n[contact]\nepsilon = 1e-3\n[method]\nname = \"{}\"\nstep = 1e-3\n"
        "[output]\nevery = 0.05\n",
        method == "characteristics" ? 0.0 : viscosity, side(left), side(right), side(span), sign, sign, sign, mass,
        method);
    return parse_scene(text, name).run;
  }
};

const std::string left = "[left]\nkind = \"obstacle\"\ngap = 0.1\nside = \"SIDE\"\n";
const std::string right = "[right]\nkind = \"obstacle\"\ngap = 0.15\nside = \"SIDE\"\n";
const std::string walls = "[right]\nkind = \"obstacle\"\ngap = 0.15\nside = \"OTHER\"\n";
// A stop that vibrates under an end that is pushed, and a fixed end in motion: its displacement is 0 at the start.
const std::string pushed =
    "[left]\nkind = \"obstacle\"\ngap = \"0.1-0.03*sin(7*t)\"\nside = \"SIDE\"\nforce = \"SIGN*(0.3*cos(3*t))\"\n";
const std::string damped = "dashpot = 0.4\n";
const std::string driven = "[right]\nkind = \"fixed\"\nmotion = \"SIGN*(0.05*sin(2*t)^2)\"\n";
const Mirrored ends[] = {
    {"left", left, "", ""}, {"right", "", right, ""}, {"both ends", left, right, ""}, {"two walls", left, walls, ""}};
const Mirrored spans[] = {{"span", "", "", "[span]\ngap = 0.1\nside = \"SIDE\"\n"},
                          {"slit", "", "", "[span]\ngap = 0.1\nside = \"both\"\n"}};

void expect_turned(const Case& below, const Case& above) {
  const Recording a = record(below), b = record(above);
  ASSERT_FALSE(a.events.empty());
  ASSERT_EQ(a.times, b.times);
  for (std::size_t i = 0; i < a.u.size(); ++i) ASSERT_EQ(a.u[i], -b.u[i]) << i;
  for (std::size_t i = 0; i < a.v.size(); ++i) ASSERT_EQ(a.v[i], -b.v[i]) << i;
  for (std::size_t k = 0; k < a.times.size(); ++k) {
    ASSERT_EQ(a.reaction_left[k], -b.reaction_left[k]);
    ASSERT_EQ(a.reaction_right[k], -b.reaction_right[k]);
  }
  ASSERT_EQ(a.events.size(), b.events.size());
  for (std::size_t i = 0; i < a.events.size(); ++i) {
    ASSERT_EQ(a.events[i].time, b.events[i].time);
    ASSERT_EQ(a.events[i].node, b.events[i].node);
    ASSERT_EQ(a.events[i].change, b.events[i].change);
    ASSERT_EQ(a.events[i].velocity, -b.events[i].velocity);
  }
  const Statistics &x = a.statistics, &y = b.statistics;
  EXPECT_EQ(x.steps, y.steps);
  EXPECT_EQ(x.max_penetration, y.max_penetration);
  EXPECT_EQ(x.energy->final, y.energy->final);
  EXPECT_EQ(x.energy->dissipated, y.energy->dissipated);
  EXPECT_EQ(x.account->left.impulse, -y.account->left.impulse);
  EXPECT_EQ(x.account->right.impulse, -y.account->right.impulse);
  EXPECT_EQ(x.account->left.peak_reaction, y.account->left.peak_reaction);
  EXPECT_EQ(x.account->right.peak_reaction, y.account->right.peak_reaction);
  EXPECT_EQ(x.account->left.lowest, -y.account->left.highest);
  EXPECT_EQ(x.account->right.highest, -y.account->right.lowest);
}

class Sides : public testing::TestWithParam<std::string> {};

TEST_P(Sides, AnObstacleAboveIsOneBelowWithAllSignsTurnedBitForBit) {
  const std::string method = GetParam();
  for (const Mirrored& scene : ends) {
    SCOPED_TRACE(scene.name);
    for (const char* mass : {"consistent", "redistributed", "lumped", "fourth_order"}) {
      if (method == "finite_difference" && std::string(mass) != "lumped") continue;
      SCOPED_TRACE(mass);
      expect_turned(scene.at(1, method, mass), scene.at(-1, method, mass));
      if (HasFailure()) return;
    }
  }
  const Mirrored moved[] = {{"moved", pushed, driven, ""}, {"moved, free", pushed + damped, "", ""}};
  for (const Mirrored& scene : moved) {
    SCOPED_TRACE(scene.name);
    expect_turned(scene.at(1, method, "lumped"), scene.at(-1, method, "lumped"));
  }
  if (method == "rigid" || method == "characteristics") return;
  for (const Mirrored& scene : spans) {
    SCOPED_TRACE(scene.name);
    expect_turned(scene.at(1, method, "lumped"), scene.at(-1, method, "lumped"));
  }
}

// A bar that meets both obstacles at the same instant, again and again.
TEST_P(Sides, AtBothEndsAtOnceAreTurnedBitForBit) {
  const auto at = [](const char* side, int sign) {
    return parse_scene(
               fmt::format("[bar]\nlength = 1\nviscosity = {}\n[left]\nkind = \"obstacle\"\ngap = 0.1\nside = \"{}\"\n"
                           "[right]\nkind = \"obstacle\"\ngap = 0.1\nside = \"{}\"\n[initial]\nvelocity = {}\n[load]\n"
                           "density = {}\n[time]\nend = 2\n[mesh]\nelements = 16\nmass = \"{}\"\n[contact]\nepsilon = "
                           "1e-4\n[method]\nname = \"{}\"\nstep = 1e-3\n",
                           GetParam() == "characteristics" ? 0.0 : 0.1, side, side, -sign, -sign,
                           GetParam() == "finite_difference" ? "lumped" : "consistent", GetParam()),
               "thrown.toml")
        .run;
  };
  expect_turned(at("below", 1), at("above", -1));
}

INSTANTIATE_TEST_SUITE_P(All, Sides,
                         testing::Values("cvode", "ida", "arkode", "odeint", "rigid", "exponential", "characteristics",
                                         "fully_discrete", "finite_difference"));

double largest_difference(const Recording& a, const Recording& b) { return distance(a.u, b.u); }

// The two walls of a bar, and the two sides of a slit, are met in turn; undamped contact and a fine step of the scheme
// have one limit where contacts have no mass.
TEST(Sides, BetweenTwoWallsEveryMethodHasTheSameMotion) {
  const Mirrored& between = ends[3];
  Case truth = between.at(1, "exponential", "redistributed");
  const auto thrown = [](Case& run) { run.scene.load.reset(); };
  thrown(truth);
  const Recording exact = record(truth);
  EXPECT_GE(exact.events.size(), 3u);
  const double largest = viscobar::largest(exact.u);
  for (const char* method : {"cvode", "ida", "arkode", "odeint"}) {
    Case run = between.at(1, method, "redistributed");
    thrown(run);
    // The promise of the tolerances.
    EXPECT_LE(largest_difference(exact, record(run)), 100.0 * 1.001 * run.tolerance.relative * largest) << method;
  }
}

TEST(Sides, ARigidWallOnTheRightAndTheSchemeAgree) {
  for (const Mirrored& scene : ends) {
    const Recording rigid = record(scene.at(1, "rigid", "redistributed"));
    Case coarse = scene.at(1, "fully_discrete", "redistributed"), fine = coarse;
    coarse.step = 2e-3, fine.step = 1e-3;
    const double before = largest_difference(rigid, record(coarse)), after = largest_difference(rigid, record(fine));
    EXPECT_LT(after, 0.02) << scene.name;
    EXPECT_LT(after, 0.75 * before) << scene.name;  // of first order, contacts closing on the grid
  }
}

TEST(Sides, ASlitHoldsTheBarFromBothSides) {
  for (const char* method : {"cvode", "arkode", "fully_discrete", "exponential"}) {
    Case run = spans[1].at(1, method, "lumped");
    run.scene.velocity = [](double x) { return std::cos(3.0 * x); };
    run.scene.load.reset();
    run.restitution = 0.0;
    run.epsilon = 1e-6;
    const Recording recording = record(run);
    double lowest = 0.0, highest = 0.0;
    for (const double u : recording.u) lowest = std::min(lowest, u), highest = std::max(highest, u);
    // As deep as the spring of a node that all of the bar's energy, rho V^2 / 2 = 1/2, presses; in the scheme not at
    // all.
    const double deep = is_scheme(run.method) ? 1e-15 : std::sqrt(*run.epsilon * 1.0);
    EXPECT_LE(highest, 0.1 + deep) << method;
    EXPECT_GE(lowest, -0.1 - deep) << method;
    // Both surfaces are touched; an output is at most a step of 1e-3 away from a touch, at a speed below 2.
    EXPECT_NEAR(highest, 0.1, 2e-3) << method;
    EXPECT_NEAR(lowest, -0.1, 2e-3) << method;
  }
}

TEST(Sides, ABarThrownAtTheWallOnItsRightReboundsThere) {
  const auto thrown = [](const char* end, const char* side, int direction) {
    return parse_scene(
               fmt::format("[bar]\nlength = 1\ndensity = 7850\nmodulus = 210e9\nviscosity = 2e5\n[{}]\nkind = "
                           "\"obstacle\"\ngap = 1e-3\nside = \"{}\"\n[initial]\nvelocity = {}\n[time]\nend = 1e-3\n",
                           end, side, 5 * direction),
               "thrown.toml")
        .run;
  };
  const Recording rightwards = record(thrown("right", "above", 1)), leftwards = record(thrown("left", "below", -1));
  ASSERT_EQ(rightwards.events.size(), 2u);
  ASSERT_EQ(leftwards.events.size(), 2u);
  EXPECT_EQ(rightwards.events[0].where, Where::right);
  EXPECT_GT(rightwards.events[0].velocity, 0.0);
  EXPECT_LT(rightwards.v.back(), 0.0);
  EXPECT_LT(rightwards.statistics.account->right.impulse, 0.0);
  // Mirrored in space too, so that sums run in another order: the tolerances' promise.
  for (const int k : {0, 1}) EXPECT_NEAR(rightwards.events[k].time, leftwards.events[k].time, 1e-4 * 2e-4);
}

TEST(Sides, AnEndHasOneSideAndOnlyAnObstacleHasAny) {
  const auto problem = [](const std::string& table) {
    try {
      parse_scene("[bar]\nlength = 1\n" + table + "[initial]\nvelocity = 1\n[time]\nend = 1\n", "s.toml");
    } catch (const SceneError& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  EXPECT_NE(problem("[left]\nkind = \"obstacle\"\ngap = 1\nside = \"both\"\n").find("left.side"), std::string::npos);
  EXPECT_NE(problem("[left]\nkind = \"free\"\nside = \"above\"\n").find("left.side: belongs to an obstacle"),
            std::string::npos);
  EXPECT_EQ(problem("[span]\ngap = 1\nside = \"both\"\n"), "");
}

}  // namespace
}  // namespace viscobar

// Rigid bodies that meet each other, or what is at an end of a chain, against momentum and energy.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <span>
#include <string>
#include <vector>

#include "support/maximum_norm.hpp"
#include "viscobar/case/recording.hpp"
#include "viscobar/input/scene_file.hpp"

namespace viscobar::chain_bodies {
namespace {

Recording run_of(const std::string& text, const std::vector<std::string>& settings = {}) {
  return record(parse_scene(text, "", settings).run);
}

std::string method_text(const std::string& method, double restitution) {
  return fmt::format(
      "[time]\nend = 0.8\n[output]\nevery = 0.05\n[method]\nname = \"{}\"\nrelative_tolerance = 1e-9\nstep = 1e-4\nimpact = "
      "\"moreau\"\n[contact]\nepsilon = 1e-6\nrestitution = {}\n",
      method, restitution);
}

const std::string far_bar = "[[bar]]\nlength = 1.0\nelements = 4\nviscosity = 0.1\nvelocity = 0.0\n";

// A mass that strikes and is pulled off at once has a contact, whether it is one of the end or a body bonded to it.
// They begin with velocities of the node beside them that differ by what the mesh leaves.
TEST(RigidBodies, BondedToABarStrikeAsAMassOfItsEnd) {
  const std::string bar =
      "[[bar]]\nlength = 1.0\ndensity = 0.554\nviscosity = 0.0121\nelements = 22\nvelocity = \"-cos(pi*x)\"\n";
  const std::string rest =
      "[right]\nkind = \"free\"\nstiffness = 2.0\ndashpot = 0.1\n[load]\nprofile = \"1+x\"\nhistory = \"sin(3*t)\"\n[time]\nend = 0.3\n[method]\nname = \"rigid\"\nrelative_tolerance = "
      "1e-9\n[left]\nkind = \"obstacle\"\ngap = 0.24654\n";
  const Recording of_end = run_of(bar + rest + "mass = 0.3\n");
  const Recording body = run_of("[[bar]]\nmass = 0.3\nvelocity = -1.0\n" + bar + rest);
  ASSERT_EQ(of_end.events.size(), 2U);
  ASSERT_EQ(body.events.size(), 2U);
  for (std::size_t k = 0; k < 2; ++k) {
    EXPECT_NEAR(body.events[k].time, of_end.events[k].time, 2e-5) << k;
    EXPECT_NEAR(*body.events[k].impulse, *of_end.events[k].impulse, 2e-5) << k;
  }
  EXPECT_GT(*body.events[1].impulse, 0.3 * 0.8);  // the mass alone
}

// A bar that touches a heavy body, which a force of 1e-7 presses to it, goes on with its speed where that is stopped,
// though its node is light beside the body.
TEST(RigidBodies, AreStoppedWithoutTheBarThatTouchesThem) {
  for (const double mass : {1.0, 100.0})
    for (const double e : {0.0, 0.5})
      for (const char* tolerance : {"1e-3", "1e-9"}) {
        const Recording found = run_of(fmt::format(
            "[[bar]]\nmass = {}\nvelocity = 1.0\n[[bar]]\nlength = 1.0\nviscosity = 0.05\nvelocity = 1.0\n"
            "elements = 40\n[[joint]]\nkind = \"contact\"\n[left]\nkind = \"obstacle\"\ngap = 0.3\nside = "
            "\"above\"\nforce = 1e-7\n[right]\nkind = \"free\"\nforce = -0.1\n[time]\nend = 0.8\n[contact]\nrestitution = "
            "{}\n[method]\nname = \"rigid\"\nrelative_tolerance = {}\n",
            mass, e, tolerance));
        EXPECT_NEAR(found.statistics.account->left.impulse, -mass * (1.0 + e), 1e-6 * mass) << e << tolerance;
        ASSERT_GE(found.events.size(), 3U);
        EXPECT_EQ(found.events[2].where, Where::joint);
        EXPECT_NEAR(found.events[2].velocity, 1.0 + e, 1e-6) << mass << tolerance;
      }
}

// A ram of mass 2 and speed 1 leaves the wall with speed e: impulse 2 (1 + e), energy lost 1 - e^2. A penalty of 1e-6
// is passed in pi (2e-6)^(1/2) = 4.5e-3.
TEST(RigidBodies, ARamLeavesAWallWithItsRestitution) {
  for (const double e : {0.0, 0.5})
    for (const char* method :
         {"cvode", "ida", "arkode", "odeint", "exponential", "fully_discrete", "characteristics"}) {
      if (std::string_view(method) == "characteristics" && e > 0.0) continue;
      const std::string what = fmt::format("{} {}", method, e);
      const Recording found =
          run_of("[[bar]]\nmass = 2.0\nvelocity = -1.0\n" + far_bar +
                     "[[joint]]\nkind = \"contact\"\ngap = 0.5\n[left]\nkind = "
                     "\"obstacle\"\ngap = 0.1\n" +
                     method_text(method, e),
                 std::string_view(method) == "characteristics" ? std::vector<std::string>{"bar.2.viscosity=0"}
                                                               : std::vector<std::string>{});
      ASSERT_GE(found.events.size(), 1U) << what;
      EXPECT_NEAR(found.events[0].time, 0.1, 2e-4) << what;
      EXPECT_NEAR(found.events[0].velocity, -1.0, 1e-6) << what;
      EXPECT_EQ(found.events[0].where, Where::left) << what;
      const std::size_t nodes = found.mesh.nodes();
      EXPECT_NEAR(found.v[(found.times.size() - 1) * nodes], e, 3e-3) << what;
      EXPECT_NEAR(found.statistics.account->left.impulse, 2.0 * (1.0 + e), 1e-2) << what;
      EXPECT_NEAR(found.statistics.energy->dissipated, 1.0 - e * e, 1e-2) << what;
      EXPECT_NEAR(found.statistics.energy->balance_error(), 0.0, 1e-4) << what;
    }
}

// A wall that goes away, at t0 and with velocity -V0, strikes a body of mass 0.4 that it leaves at once: the mass is
// the scene's, not the mesh's. A second body of mass 0.8 overtakes the first at t1; both come to the wall at t2, and
// strike it and each other until all have its velocity -V2.
TEST(RigidBodies, AWallThatGoesAwayStrikesWhatMeetsIt) {
  const double t0 = (0.2 - std::sqrt(0.04 - 0.006)) / 0.06, v0 = 0.06 * t0, t1 = t0 + 0.02 / (0.2 - v0);
  const double common = (0.4 * v0 + 0.8 * 0.2) / 1.2, place = 0.2 * t0 + v0 * (t1 - t0) - common * t1;
  const double t2 = (common - std::sqrt(common * common - 0.12 * (0.05 - place))) / 0.06;
  for (const char* method : {"rigid", "characteristics"})
    for (const bool two : {false, true}) {
      const std::string contact = "[[joint]]\nkind = \"contact\"\n";
      const Recording found =
          run_of(std::string("[[bar]]\nmass = 0.4\nvelocity = -0.2\n") +
                     (two ? "[[bar]]\nmass = 0.8\nvelocity = -0.2\n" : "") + far_bar + contact + "gap = 0.02\n" +
                     (two ? contact + "gap = 0.5\n" : "") + "[left]\nkind = \"obstacle\"\ngap = \"0.05+0.03*t^2\"\n" +
                     "[time]\nend = 0.45\n[contact]\nrestitution = 0\n[method]\nrelative_tolerance = 1e-10\nname = \"" +
                     method + "\"\n",
                 {two ? "bar.3.viscosity=0" : "bar.2.viscosity=0"});
      const std::string what = fmt::format("{} {}", method, two);
      ASSERT_GE(found.events.size(), 2U) << what;
      for (const std::size_t k : {0, 1}) EXPECT_NEAR(found.events[k].time, t0, 1e-9) << what;
      EXPECT_NEAR(found.events[0].velocity, -0.2, 1e-9) << what;
      EXPECT_NEAR(found.events[1].velocity, -v0, 1e-9) << what;
      const double v2 = 0.06 * t2, mass = two ? 1.2 : 0.4, left = two ? v2 : v0;
      EXPECT_NEAR(found.statistics.account->left.impulse, mass * (0.2 - left), 1e-7) << what;
      const double work = -0.4 * v0 * (0.2 - v0) - (two ? v2 * (0.8 * 0.2 + 0.4 * v0 - 1.2 * v2) : 0.0);
      EXPECT_NEAR(found.statistics.energy->work, work, 1e-7) << what;
      EXPECT_NEAR(found.statistics.energy->final, 0.5 * mass * left * left, 1e-7) << what;
      EXPECT_NEAR(found.statistics.energy->balance_error(), 0.0, 1e-9) << what;
    }
}

// v1 = (m1 - e m2) / (m1 + m2), v2 = (1 + e) m1 / (m1 + m2), impulse m2 v2.
TEST(RigidBodies, TwoThatMeetKeepTheirMomentum) {
  for (const double e : {0.0, 0.5})
    for (const char* method : {"rigid", "cvode", "ida", "arkode", "odeint", "exponential", "fully_discrete"}) {
      const std::string what = fmt::format("{} {}", method, e);
      const Recording found =
          run_of("[[bar]]\nmass = 2.0\nvelocity = 1.0\n[[bar]]\nmass = 1.0\nvelocity = 0.0\n" + far_bar +
                 "[[joint]]\nkind = \"contact\"\ngap = 0.1\n[[joint]]\nkind = \"contact\"\ngap = 5.0\n" +
                 method_text(method, e));
      ASSERT_GE(found.events.size(), 1U) << what;
      EXPECT_NEAR(found.events[0].time, 0.1, 2e-4) << what;
      const double* last = &found.v[(found.times.size() - 1) * found.mesh.nodes()];
      EXPECT_NEAR(last[0], (2.0 - e) / 3.0, 2e-3) << what;
      EXPECT_NEAR(last[1], (1.0 + e) * 2.0 / 3.0, 2e-3) << what;
      EXPECT_NEAR(2.0 * last[0] + last[1], 2.0, 1e-7) << what;
      EXPECT_NEAR(found.statistics.account->joints.at(0).impulse, (1.0 + e) * 2.0 / 3.0, 5e-3) << what;
      EXPECT_NEAR(found.statistics.energy->balance_error(), 0.0, 1e-4) << what;
    }
}

// Hertz: 1/2 m V^2 = 2/5 k d^(5/2), m = m1 m2 / (m1 + m2) = 2/3, and nothing is lost.
TEST(RigidBodies, TwoOfHertzHaveHisPeakForce) {
  for (const char* method : {"cvode", "ida", "arkode"}) {
    const Recording found = run_of(
        "[[bar]]\nmass = 2.0\nvelocity = 1.0\n[[bar]]\nmass = 1.0\nvelocity = 0.0\n" + far_bar +
        "[[joint]]\nkind = \"contact\"\ngap = 0.1\nlaw = \"hertz\"\nstiffness = 1e4\n[[joint]]\nkind = \"contact\"\ngap = 5.0\n" +
        method_text(method, 0.0));
    const double depth = std::pow(1.25 * (2.0 / 3.0) / 1e4, 0.4);
    EXPECT_NEAR(found.statistics.account->joints.at(0).peak_reaction / (1e4 * std::pow(depth, 1.5)), 1.0, 1e-4)
        << method;
    const double* last = &found.v[(found.times.size() - 1) * found.mesh.nodes()];
    EXPECT_NEAR(last[0], 1.0 / 3.0, 1e-6) << method;
    EXPECT_NEAR(last[1], 4.0 / 3.0, 1e-6) << method;
  }
}

// A body falls onto its obstacle at 0.5 and rests at -0.1. A bar at speed 0.1 is there at 2, and would be at 3 if the
// body were where it began. A penalty of 1e-4 is passed by 0.2 (1e-4)^(1/2) = 2e-3, worth 0.02 of the bar's time.
TEST(RigidBodies, OneThatRestsOnAnObstacleIsMetWhereItIs) {
  for (const char* joint : {"", "law = \"spring_damper\"\nstiffness = 50.0\ndamping = 0.5\n"})
    for (const char* method : {"cvode", "ida", "arkode", "odeint"}) {
      const Recording found = run_of(fmt::format(
          "[[bar]]\nlength = 1.0\nelements = 4\nviscosity = 0.1\nvelocity = 0.1\n[[bar]]\nmass = 1.0\nvelocity = "
          "-0.2\n[[joint]]\nkind = \"contact\"\ngap = 0.3\n{}[right]\nkind = \"obstacle\"\ngap = 0.1\n[time]\nend = "
          "3.5\n[contact]\nepsilon = 1e-4\nrestitution = 0.0\n[method]\nname = \"{}\"\n",
          joint, method));
      std::vector<double> closings;
      for (const Event& event : found.events)
        if (event.where == Where::joint && event.change == Change::closing) closings.push_back(event.time);
      ASSERT_FALSE(closings.empty()) << method;
      EXPECT_NEAR(closings.front(), 2.0, 0.02) << method << joint;
    }
}

// A body bonded to the end is a mass on it; what holds it, holds the bar.
TEST(RigidBodies, OneBondedToTheEndIsAMassOnIt) {
  const std::string of_bar = "length = 1.0\nviscosity = 0.1\n", start = "[initial]\nvelocity = -1.0\n";
  for (const char* left : {"[left]\nkind = \"obstacle\"\ngap = 0.1\nstiffness = 0.7\n",
                           "[left]\nkind = \"fixed\"\nmotion = \"0.1*sin(3*t)\"\n",
                           "[left]\nkind = \"obstacle\"\ngap = \"0.1-0.2*t\"\ndashpot = 0.3\n"})
    for (const char* method : {"rigid", "cvode", "ida", "arkode", "odeint", "exponential", "fully_discrete"}) {
      const bool fixed = std::string(left).find("fixed") != std::string::npos;
      const std::vector<std::string> settings = {"mesh.mass=consistent", "contact.epsilon=1e-3"};
      const std::string rest = start + method_text(method, 0.5);
      const Recording chain = run_of("[[bar]]\nmass = 2.0\n[[bar]]\nelements = 8\n" + of_bar + left + rest, settings);
      const Recording one =
          run_of("[bar]\n" + of_bar + left + (fixed ? "" : "mass = 2.0\n") + "[mesh]\nelements = 8\n" + rest, settings);
      ASSERT_EQ(chain.events.size(), one.events.size()) << method << left;
      EXPECT_LT(distance(chain.u, one.u), 1e-6) << method << left;
      EXPECT_NEAR(chain.statistics.account->left.impulse, one.statistics.account->left.impulse, 1e-5) << method << left;
    }
}

// A ram that a spring holds to a bar strikes the wall: as a wall, a penalty of 1e-7 and the scheme have it.
TEST(RigidBodies, ARamOnASpringMeetsAWallByAllMethodsAlike) {
  const std::string text =
      "[[bar]]\nmass = 0.5\nvelocity = -1.0\n[[bar]]\nlength = 1.0\nelements = 8\nviscosity = 0.1\nvelocity = -1.0\n"
      "[[joint]]\nkind = \"spring\"\nstiffness = 3.0\ndamping = 0.1\n[left]\nkind = \"obstacle\"\ngap = 0.1\n";
  const std::vector<std::string> settings = {"contact.epsilon=1e-7", "mesh.mass=consistent", "time.end=3"};
  const Recording truth = run_of(text + method_text("rigid", 0.0), settings);
  ASSERT_EQ(truth.events.size(), 2U);
  for (const char* method : {"cvode", "arkode", "ida", "fully_discrete"}) {
    const Recording found = run_of(text + method_text(method, 0.0), settings);
    EXPECT_LT(distance(found.u, truth.u), 1e-3) << method;
    EXPECT_NEAR(found.statistics.account->left.impulse, truth.statistics.account->left.impulse, 5e-3) << method;
    EXPECT_NEAR(found.statistics.energy->balance_error(), 0.0, 1e-4) << method;
  }
}

// A ram, a cap and a pile: the row of the ram tells the force on the cap, its spring, dashpot and force included, and
// `[side]` is in the row of the pile. The scheme has the same impacts without rebound, each at most a step off, at a
// speed of 2.
TEST(RigidBodies, ARamOnACapIsToldByItsRow) {
  const std::string pile = "length = 1.0\nelements = 20\nviscosity = 0.05\nvelocity = 0.0\n",
                    joints = "[[joint]]\nkind = \"contact\"\ngap = {}\n[[joint]]\nkind = \"contact\"\ngap = {}\n";
  for (const bool mirrored : {false, true})
    for (const char* at_ram : {"", "stiffness = 3.0\ndashpot = 0.2\n", "force = \"0.5*sin(t)\"\n", "side"}) {
      const bool side = at_ram == std::string("side");
      const std::string ram = fmt::format("mass = 2.0\nvelocity = {}\n", mirrored ? -2.0 : 2.0),
                        cap = "mass = 0.5\nvelocity = 0.0\n",
                        last = "kind = \"free\"\n" + std::string(side ? "" : at_ram),
                        rest = side ? "[side]\nstiffness = 2.0\ndrag = 0.3\n" : "";
      const std::string text =
          (mirrored ? "[[bar]]\n" + pile + "[[bar]]\n" + cap + "[[bar]]\n" + ram +
                          fmt::format(fmt::runtime(joints), 0.05, 0.1) + "[left]\nkind = \"fixed\"\n[right]\n"
                    : "[[bar]]\n" + ram + "[[bar]]\n" + cap + "[[bar]]\n" + pile +
                          fmt::format(fmt::runtime(joints), 0.1, 0.05) + "[right]\nkind = \"fixed\"\n[left]\n") +
          last + rest + method_text("{}", 0.0);
      const auto run = [&](const char* method, const char* step) {
        std::string scene = text;
        scene.replace(scene.find("{}"), 2, method);
        return run_of(scene, {"time.end=2.0", std::string("method.step=") + step});
      };
      const Recording found = run("rigid", "1.0"), scheme = run("fully_discrete", "5e-5");
      EXPECT_LT(distance(scheme.u, found.u), 2.0 * 2.0 * 5e-5) << at_ram << mirrored;
      for (const std::size_t k : {0, 1}) {
        const auto impulse = [k](const Recording& of) { return of.statistics.account->joints.at(k).impulse; };
        EXPECT_NEAR(impulse(found), impulse(scheme), 2e-3) << at_ram << mirrored << k;
      }
      EXPECT_EQ(found.events.front().where, Where::joint);
      EXPECT_NEAR(found.events.front().time, 0.05, 1e-3) << at_ram << mirrored;
      EXPECT_NEAR(found.statistics.energy->balance_error(), 0.0, 1e-8) << at_ram << mirrored;
    }
}

// The impulse of the obstacle of a body, less that of the bar that presses on the body, is the body's change of
// momentum: rows tell both, whatever the mass of the bar. The scheme has them at a step of 1e-4.
TEST(RigidBodies, AnObstacleOfABodyBearsTheNextBarToo) {
  for (const char* mass : {"fourth_order", "consistent", "lumped"})
    for (const bool mirrored : {false, true})
      for (const double gap : {0.0, 0.05}) {
        const double speed = mirrored ? 1.0 : -1.0;
        const std::string
            body = fmt::format("[[bar]]\nmass = 1.0\nvelocity = {}\n", speed),
            bar = fmt::format("[[bar]]\nlength = 1.0\nelements = 20\nviscosity = 0.05\nvelocity = {}\n", speed),
            rest = fmt::format(
                "[[joint]]\nkind = \"contact\"\ngap = {}\n[{}]\nkind = \"obstacle\"\ngap = 0.1\nside = \"{}\"\n", gap,
                mirrored ? "right" : "left", mirrored ? "above" : "below");
        const std::string text = (mirrored ? bar + body : body + bar) + rest,
                          what = fmt::format("{} {} {}", mass, mirrored, gap);
        const std::vector<std::string> settings = {std::string("mesh.mass=") + mass, "time.end=3"};
        const Recording found = run_of(text + method_text("rigid", 0.0), settings),
                        scheme = run_of(text + method_text("fully_discrete", 0.0), settings);
        EXPECT_LT(distance(scheme.u, found.u), 1e-3) << what;
        const std::size_t nodes = found.mesh.nodes(), at = mirrored ? nodes - 1 : 0;
        const double gained = found.v[(found.times.size() - 1) * nodes + at] - speed;
        const auto of_obstacle = [&](const Recording& of) {
          return mirrored ? -of.statistics.account->right.impulse : of.statistics.account->left.impulse;
        };
        const auto of_joint = [](const Recording& of) { return of.statistics.account->joints.at(0).impulse; };
        EXPECT_GT(of_joint(found), 0.1) << what;
        EXPECT_NEAR(of_obstacle(found) - of_joint(found), mirrored ? -gained : gained, 1e-7) << what;
        EXPECT_NEAR(of_obstacle(found), of_obstacle(scheme), 5e-3) << what;
        EXPECT_NEAR(of_joint(found), of_joint(scheme), 5e-3) << what;
        EXPECT_NEAR(found.statistics.energy->balance_error(), 0.0, 1e-7) << what;
      }
}

// A body of mass 2 and speed 1 strikes one of mass 1 that rests at a wall. Two springs that are each critically damped
// throw both back, for every epsilon alike; by another integrator of the two bodies at 0.0409258992 and 0.211126278. An
// impact of restitution 0 leaves both at rest.
TEST(RigidBodies, TwoPenaltiesAtOnceHaveALimitOfTheirOwn) {
  const auto speeds = [](const std::string& method, double epsilon) {
    const Recording found = run_of(
        "[[bar]]\nmass = 1.0\nvelocity = 0.0\n[[bar]]\nmass = 2.0\nvelocity = -1.0\n" + far_bar +
            "[[joint]]\nkind = \"contact\"\ngap = 0.05\n[[joint]]\nkind = \"contact\"\ngap = 5.0\n[left]\nkind = "
            "\"obstacle\"\ngap = 0.0\n" +
            method_text(method, 0.0),
        {fmt::format("contact.epsilon={}", epsilon)});
    const std::span<const double> v = found.velocity(found.times.size() - 1);
    return std::array{v[0], v[1]};
  };
  for (const double epsilon : {1e-5, 1e-7})
    for (const char* method : {"cvode", "ida", "arkode", "odeint", "exponential"}) {
      const auto [first, second] = speeds(method, epsilon);
      EXPECT_NEAR(first, 0.0409258992, 1e-6) << method << epsilon;
      EXPECT_NEAR(second, 0.211126278, 1e-6) << method << epsilon;
    }
  for (const char* method : {"rigid", "fully_discrete"}) {
    const auto [first, second] = speeds(method, 1e-6);
    EXPECT_NEAR(first, 0.0, 1e-9) << method;
    EXPECT_NEAR(second, 0.0, 1e-9) << method;
  }
}

TEST(RigidBodies, WhatIsNotTakenIsSaid) {
  const auto complaint = [](const std::string& text, const std::string& left, const char* method) -> std::string {
    try {
      (void)parse_scene(text + left + method_text(method, 0.0), "");
    } catch (const SceneError& error) {
      return error.what();
    }
    return "";
  };
  const std::string ram =
      "[[bar]]\nmass = 2.0\nvelocity = -1.0\n" + far_bar + "[[joint]]\nkind = \"contact\"\ngap = 0.5\n";
  EXPECT_NE(complaint(ram, "[left]\nkind = \"fixed\"\n", "cvode").find("leave the body out"), std::string::npos);
}

}  // namespace
}  // namespace viscobar::chain_bodies

// A scene that says what there is, and nothing of how to compute it.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "cli/command.hpp"
#include "support/falling_bar.hpp"
#include "viscobar/case/recording.hpp"
#include "viscobar/input/scene_file.hpp"

namespace viscobar {
namespace {

std::string plain(const std::string& bar, const std::string& ends, const std::string& initial, double end) {
  return fmt::format("[bar]\nlength = 1\n{}\n{}\n[initial]\n{}\n[time]\nend = {}\n", bar, ends, initial, end);
}
const std::string at_left = "[left]\nkind = \"obstacle\"\ngap = 0.1\n";
const std::string touching = "[left]\nkind = \"obstacle\"\ngap = 0\n";
const std::string at_right = "[right]\nkind = \"obstacle\"\ngap = 0.2\nside = \"above\"\n";
const std::string below_right = "[right]\nkind = \"obstacle\"\ngap = 0.1\n";

struct Plain {
  std::string ends, initial;
  double end;
};
const Plain scenes[] = {
    {at_left, "velocity = -1", 4},
    {touching, "velocity = -0.5", 4},
    {touching, "displacement = \"0.5*x\"", 6},
    {at_left, "velocity = \"-0.5-x\"", 4},
    {at_left + below_right, "velocity = \"-x*(1-x)\"", 4},
    {at_left + at_right, "velocity = -1", 6},
    {at_right, "velocity = 1", 4},
};

// The reference is exact without viscosity; with it, the limit epsilon = 0 on eight times as many elements.
TEST(Defaults, ChangeContactAsOftenAsTheFineReference) {
  for (const char* viscosity : {"0", "0.001", "0.01", "0.1", "1"})
    for (const Plain& scene : scenes) {
      const std::string text = plain(fmt::format("viscosity = {}", viscosity), scene.ends, scene.initial, scene.end);
      const bool undamped = std::string(viscosity) == "0";
      const std::vector<std::string> fine =
          undamped ? std::vector<std::string>{"method.name=characteristics"}
                   : std::vector<std::string>{"method.name=rigid", "mesh.mass=fourth_order", "mesh.elements=800",
                                              "method.relative_tolerance=1e-8"};
      const Recording by_default = record(parse_scene(text, "plain.toml").run);
      const Recording reference = record(parse_scene(text, "plain.toml", fine).run);
      EXPECT_EQ(by_default.events.size(), reference.events.size()) << text;
    }
}

TEST(Defaults, NoMethodRefusesThemAndNoneChattersAtAnEnd) {
  for (const MethodName method : all_methods)
    for (const char* viscosity : {"0", "0.01"}) {
      if (method == MethodName::characteristics && std::string(viscosity) != "0") continue;
      const std::string text = plain(fmt::format("viscosity = {}", viscosity), at_left, "velocity = -1", 4);
      const Case run = parse_scene(text, "plain.toml", std::vector{fmt::format("method.name={}", name(method))}).run;
      const Recording recording = record(run);
      // Without viscosity cvode and odeint do not take massless nodes, and finite_difference never does. What odeint is
      // wrong by as the bar leaves closes the contact again for an instant.
      const bool massless =
          resolve(run).mass != Mass::consistent && resolve(run).mass != Mass::lumped && method != MethodName::odeint;
      const std::size_t least = massless ? 2 : recording.events.size();
      EXPECT_EQ(recording.events.size(), least) << name(method) << ", viscosity " << viscosity;
    }
}

TEST(Defaults, OfTheLibraryAreThoseOfAFile) {
  Case run;
  run.scene = falling_bar(0.1, 1.0, 0.0);
  run.method = automatic_method(run).method;
  EXPECT_TRUE(faults(resolve(run)).empty());
  const Case file = parse_scene(plain("", at_left, "velocity = -1", 1), "plain.toml").run;
  EXPECT_EQ(run.method, file.method);
  EXPECT_EQ(run.elements, file.elements);
  EXPECT_EQ(resolve(run).mass, resolve(file).mass);
  run.method = MethodName::arkode;
  EXPECT_TRUE(faults(resolve(run)).empty());
  EXPECT_EQ(resolve(run).mass, Mass::redistributed);
}

TEST(Defaults, OfAnInitialDatumIsZeroAndNothingAtAllIsRefused) {
  const std::string bar = "[bar]\nlength = 1\n", end = "[time]\nend = 1\n";
  const auto read = [&](const std::string& rest) { return parse_scene(bar + rest + end, "bare.toml").run; };
  EXPECT_EQ(read("[initial]\nvelocity = 1\n").scene.displacement(0.5), 0.0);
  EXPECT_EQ(read("[initial]\ndisplacement = \"x\"\n").scene.velocity(0.5), 0.0);
  EXPECT_EQ(read("[load]\ndensity = 1\n").scene.velocity(0.5), 0.0);
  EXPECT_THROW(read(""), SceneError);
}

TEST(Defaults, OfASpanIsAMethodThatDoesNotBounce) {
  const std::string text = plain("viscosity = 0.1", "[span]\ngap = 0.1\n", "velocity = -1", 2);
  const Case run = parse_scene(text, "span.toml").run;
  EXPECT_EQ(run.method, MethodName::fully_discrete);
  const Recording recording = record(run);
  // It falls flat and stays: every node closes once.
  EXPECT_EQ(recording.events.size(), run.elements + 1);
}

TEST(Defaults, AValueIsTakenOutByAnEmptySetting) {
  const std::string text = plain("", at_left, "velocity = -1", 1) + "[contact]\nepsilon = 1e-3\n[span]\ngap = 1\n";
  const auto read = [&](std::vector<std::string> settings) { return parse_scene(text, "s.toml", settings).run; };
  EXPECT_TRUE(read({}).epsilon);
  EXPECT_FALSE(read({"contact.epsilon="}).epsilon);
  EXPECT_FALSE(read({"span.gap="}).scene.span);
  EXPECT_EQ(read({"contact.epsilon=", "contact.epsilon=2"}).epsilon, 2.0);
}

TEST(Defaults, AnEndOfAnotherKindForgetsTheGapOfTheFile) {
  const std::string text = plain("", at_left, "velocity = -1", 1);
  EXPECT_TRUE(std::holds_alternative<Free>(
      parse_scene(text, "s.toml", std::vector<std::string>{"left.kind=free"}).run.scene.left));
  // One that is asked for in the same breath is a contradiction.
  EXPECT_THROW(parse_scene(text, "s.toml", std::vector<std::string>{"left.kind=free", "left.gap=1"}), SceneError);
}

using DefaultsOfTheCommand = testing_cli::Command;

TEST_F(DefaultsOfTheCommand, TheTemplateRunsByEveryMethodThatFits) {
  ASSERT_EQ(viscobar("new s.toml").code, 0);
  for (const char* method :
       {"automatic", "cvode", "ida", "arkode", "odeint", "rigid", "fully_discrete", "finite_difference"}) {
    const auto ended = viscobar(fmt::format("run s.toml --json -o out --set method.name={}", method));
    EXPECT_EQ(ended.code, 0) << method << ended.error;
    if (std::string(method) == "finite_difference") continue;  // its nodes have mass
    EXPECT_LE(ended.json()["events"].get<int>(), 8) << method;
    EXPECT_TRUE(ended.json()["warnings"].empty()) << method;
  }
}

TEST_F(DefaultsOfTheCommand, WhatTheWarningOfChatterAdvisesCanBeFollowedByOneSetting) {
  std::ofstream(directory_ / "s.toml") << plain("viscosity = 0", at_left, "velocity = -1", 4)
                                       << "[contact]\nepsilon = 1e-6\n[method]\nname = \"cvode\"\n";
  const auto advice = viscobar("check s.toml").error;
  EXPECT_NE(advice.find("method.name = \"arkode\""), std::string::npos) << advice;
  EXPECT_EQ(advice.find("mesh.mass"), std::string::npos) << advice;  // cvode does not take it here
  const auto followed = viscobar("run s.toml --json -o out --set method.name=arkode");
  EXPECT_EQ(followed.code, 0);
  EXPECT_EQ(followed.json()["events"], 2);
}

}  // namespace
}  // namespace viscobar

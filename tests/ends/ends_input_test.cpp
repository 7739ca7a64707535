// Inputs of ends that scene files and scenes of functions may give, and those that are refused.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>

#include "input/formula.hpp"
#include "viscobar/case/recording.hpp"
#include "viscobar/input/scene_file.hpp"

namespace viscobar {
namespace {

std::string scene(const std::string& ends, const std::string& more = "") {
  return fmt::format("[bar]\nlength = 1\n{}\n[initial]\nvelocity = -1\n[time]\nend = 1\n{}", ends, more);
}

std::string mistake(const std::string& text) {
  try {
    parse_scene(text, "scene");
  } catch (const SceneError& error) {
    return error.diagnostics.front().text();
  }
  return "";
}

void expect_mistake(const std::string& text, const std::string& key, const std::string& words) {
  const std::string found = mistake(text);
  EXPECT_NE(found.find(key + ":"), found.npos) << found << "\n" << text;
  EXPECT_NE(found.find(words), found.npos) << found << "\n" << text;
}

TEST(EndKeys, ThatDoNotBelongToTheEndAreRefusedByName) {
  expect_mistake(scene("[left]\nkind = \"fixed\"\nforce = 1"), "left.force", "belongs to a free end or an obstacle");
  expect_mistake(scene("[left]\nkind = \"fixed\"\nstiffness = 1"), "left.stiffness", "belongs to a free end");
  expect_mistake(scene("[right]\nkind = \"free\"\nmotion = \"t\""), "right.motion", "belongs to a fixed end");
  expect_mistake(scene("[right]\nkind = \"free\"\ngap = \"1+t\""), "right.gap", "belongs to an obstacle");
}

TEST(EndKeys, WithValuesOutOfRangeAreRefused) {
  expect_mistake(scene("[left]\nkind = \"free\"\nstiffness = -1"), "left.stiffness", "must not be negative");
  expect_mistake(scene("[left]\nkind = \"free\"\ndashpot = \"t\""), "left.dashpot", "must be a number");
  expect_mistake(scene("[left]\nkind = \"obstacle\"\ngap = -1"), "left.gap", "must not be negative");
  expect_mistake(scene("[left]\nkind = \"obstacle\"\ngap = \"-1\""), "left.gap", "must not be negative");
  expect_mistake(scene("[left]\nkind = \"obstacle\"\ngap = \"t-1\""), "left.gap", ">= 0");
  expect_mistake(scene("[left]\nkind = \"obstacle\"\ngap = \"x\""), "left.gap", "");
  expect_mistake(scene("[left]\nkind = \"free\"\nforce = \"1/t\""), "left.force", "at t = 0");
  expect_mistake(scene("[left]\nkind = \"fixed\"\nmotion = \"cos(t)\""), "left.motion", "must be 0 at t = 0");
  expect_mistake(scene("[left]\nkind = \"obstacle\"\ngap = \"log(t)\""), "left.gap",
                 "must be finite and >= 0, is -inf");
  EXPECT_EQ(mistake(scene("[left]\nkind = \"obstacle\"\ngap = \"log(t)\"")).find("initial displacement"),
            std::string::npos);
  expect_mistake(scene("[left]\nkind = \"fixed\"\nmotion = 0.5"), "left.motion", "must be 0 at t = 0");
}

TEST(EndKeys, ThatDoNotGoWithTheRestAreRefusedWithWhatToUse) {
  const std::string mounted = "[left]\nkind = \"obstacle\"\ngap = 0.1\nstiffness = 1\n";
  expect_mistake(scene(mounted, "[mesh]\nmass = \"redistributed\"\n[method]\nname = \"rigid\"\n"), "mesh.mass",
                 "use \"fourth_order\"");
  expect_mistake(scene("[left]\nkind = \"free\"\nstiffness = 1e5\n", "[method]\nname = \"characteristics\"\n"),
                 "left.stiffness", "use rigid");
  expect_mistake(scene("[left]\nkind = \"obstacle\"\ngap = \"0.1+t\"\n[span]\ngap = 1"), "left.gap",
                 "leave [span] out");
  // Left to choose, the program takes what fits.
  const Case chosen = parse_scene(scene(mounted), "").run;
  EXPECT_EQ(chosen.method, MethodName::characteristics);
  const Case stiff = parse_scene(scene(mounted), "", std::vector<std::string>{"left.stiffness=1e5"}).run;
  EXPECT_EQ(stiff.method, MethodName::rigid);
  EXPECT_NE(stiff.warning.find("left.stiffness makes for a motion"), std::string::npos) << stiff.warning;
  EXPECT_EQ(
      resolve(parse_scene(scene(mounted, "[contact]\nepsilon = 1e-3\n[method]\nname = \"arkode\"\n"), "").run).mass,
      Mass::consistent);
}

TEST(EndKeys, OfAScenesOwnFunctionsAreHeldLikeFormulas) {
  const std::string text = scene(
      "[left]\nkind = \"obstacle\"\ngap = \"0.1-0.05*sin(3*t)\"\nforce = \"0.5*cos(2*t)\"\nstiffness = 0.5\n[right]\nkind "
      "= \"fixed\"\nmotion = \"-t+0.5*t^2\"",
      "[mesh]\nelements = 10\nmass = \"consistent\"\n[contact]\nepsilon = 1e-3\n[method]\nname = \"cvode\"\n");
  const Case of_text = parse_scene(text, "").run;
  Case of_functions = of_text;
  of_functions.scene.left_input.force = EndForce{[](double t) { return 0.5 * std::cos(2 * t); }};
  of_functions.scene.left_input.motion =
      EndMotion{[](double t) { return 0.05 * std::sin(3 * t); }, [](double t) { return 0.05 * 3 * std::cos(3 * t); },
                [](double t) { return -0.05 * 9 * std::sin(3 * t); }};
  of_functions.scene.right_input.motion =
      EndMotion{[](double t) { return -t + 0.5 * t * t; }, [](double t) { return -1 + t; }, [](double) { return 1.0; }};
  const Recording a = record(of_text), b = record(of_functions);
  for (std::size_t i = 0; i < a.u.size(); ++i) EXPECT_NEAR(a.u[i], b.u[i], 1e-6);
  of_functions.scene.right_input.motion->acceleration = {};
  const auto found = validate(of_functions.scene);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].key, "right.motion");
}

TEST(EndKeys, ThatAreAbsentLeaveNothingInTheSystem) {
  const BarSystem system =
      resolve(parse_scene(scene("[left]\nkind = \"free\"\nforce = 0\nstiffness = 0"), "").run).system();
  EXPECT_FALSE(system.loaded());
  EXPECT_FALSE(system.frame().moving());
  EXPECT_TRUE(system.supports().empty());
}

TEST(EndMotion, ThatJumpsStopsTheRunWithItsTime) {
  const Case run = parse_scene(
                       "[bar]\nlength = 1\n[left]\nkind = \"fixed\"\nmotion = \"t < 0.5 ? 0 : 0.1\"\n[time]\nend = 1\n"
                       "[method]\nname = \"cvode\"\n",
                       "")
                       .run;
  try {
    record(run);
    FAIL();
  } catch (const IntegrationError& error) {
    EXPECT_EQ(error.failure, Failure::load);
    EXPECT_NE(std::string(error.what()).find("jumps at t = 0.5"), std::string::npos) << error.what();
  }
}

// Against differences of the values, which are wrong by step^2 times a derivative further on, and by rounding / step^2.
TEST(FormulaDerivative, HasTheDerivativesOfWhatFormulasKnow) {
  for (const char* text :
       {"t", "3", "t^2-2*t+1", "t^3/(1+t)", "sin(2*t)*cos(t)", "tan(t/3)", "exp(-t)*log(1+t)", "sqrt(1+t^2)",
        "abs(t-2)*t", "min(t^2,3*t)", "max(t,0.5,t^2)", "t < 1 ? t^3 : 3*t-2", "(1+t)^t", "2^t", "-t^-2", "t^0.5",
        "(1-cos(3*t))^2", "1/(1+exp(-4*(t-0.5)))", "(t > 0.2 && t < 9) * t^2"}) {
    const Formula formula(text, "t");
    const TimeFunction f = formula.of_t(), slope_at = formula.derivative_of_t(1), bend_at = formula.derivative_of_t(2);
    for (const double t : {0.3, 0.77, 1.4}) {
      const double step = 1e-4;
      const double slope = slope_at(t), bend = bend_at(t), before = f(t - step), after = f(t + step);
      EXPECT_NEAR(slope, (after - before) / (2 * step), 1e-6 * (1 + std::abs(slope))) << text << " at " << t;
      EXPECT_NEAR(bend, (after - 2 * f(t) + before) / (step * step), 1e-5 * (1 + std::abs(bend)))
          << text << " at " << t;
    }
  }
  const auto at_zero = [](const char* text) {
    const Formula f(text, "t");
    return std::array{f.of_t()(0.0), f.derivative_of_t(1)(0.0), f.derivative_of_t(2)(0.0)};
  };
  EXPECT_EQ(at_zero("t^2"), (std::array{0.0, 0.0, 2.0}));
  EXPECT_EQ(at_zero("t^1"), (std::array{0.0, 1.0, 0.0}));
}

}  // namespace
}  // namespace viscobar

// Sensitivities and parameters in scene files.
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "input/formula.hpp"
#include "viscobar/case/recording.hpp"
#include "viscobar/input/scene_file.hpp"

namespace {

using namespace viscobar;

const std::string scene_text = R"~(
[bar]
length = 1.2
viscosity = 0.08
[left]
kind = "obstacle"
gap = 0.1
[initial]
displacement = "depth*x*(1.2 - x)"
velocity = "-speed*(1 + 0.2*x)"
[load]
profile = "amplitude*cos(x)"
history = "sin(omega*t)"
[parameters]
speed = 1.0
depth = 0.05
amplitude = 0.4
omega = 2.0
[sensitivity]
of = ["parameters.speed", "parameters.depth", "parameters.amplitude", "parameters.omega", "bar.length"]
[time]
end = 2.5
[mesh]
elements = 12
[method]
relative_tolerance = 1e-10
)~";

// Central differences of runs over 1e-4: their error is the square of that and 1e-10 over it.
TEST(SceneSensitivities, AreTheSlopesOfRunsForParametersOfFormulasAndForTheLength) {
  const SceneFile scene = parse_scene(scene_text, "scene");
  EXPECT_EQ(scene.run.method, MethodName::rigid);
  const Recording with = record(scene.run);
  ASSERT_EQ(with.sensitivities.size(), 5u);
  const double values[] = {1.0, 0.05, 0.4, 2.0, 1.2};
  for (std::size_t k = 0; k < 5; ++k) {
    constexpr double step = 1e-4;
    const auto moved = [&](double by) {
      const std::vector<std::string> changes = {scene.run.directions[k].key + "=" + std::to_string(values[k] + by),
                                                "sensitivity.of="};
      return record(parse_scene(scene_text, "scene", changes).run);
    };
    const Recording more = moved(step), less = moved(-step);
    double largest = 0.0, worst = 0.0;
    for (std::size_t i = 0; i < with.u.size(); ++i) {
      const double slope = (more.u[i] - less.u[i]) / (2.0 * step);
      largest = std::max(largest, std::abs(slope));
      worst = std::max(worst, std::abs(with.sensitivities[k].u[i] - slope));
    }
    EXPECT_LT(worst, 1e-5 * largest) << with.sensitivities[k].key;
    ASSERT_EQ(more.events.size(), with.events.size());
    for (std::size_t i = 0; i < with.events.size(); ++i)
      EXPECT_NEAR(with.events[i].sensitivities[k].time, (more.events[i].time - less.events[i].time) / (2.0 * step),
                  1e-5)
          << with.sensitivities[k].key;
  }
}

TEST(SceneSensitivities, SurviveTheDescriptionOfTheScene) {
  const SceneFile scene = parse_scene(scene_text, "scene");
  EXPECT_NE(scene.description().find("\"amplitude\": 0.4"), std::string::npos);
  EXPECT_NE(scene.description().find("parameters.omega"), std::string::npos);
}

// Asking for them never changes the motion: the method is that of the plain run, or the scene is refused.
TEST(SceneSensitivities, ChangeNoMethodAndAreRefusedWhereItHasNone) {
  const auto method = [](const std::string& more) {
    return parse_scene("[bar]\nlength = 1.0\n[initial]\nvelocity = -1.0\n[time]\nend = 1.0\n" + more, "scene")
        .run.method;
  };
  const std::string left = "[left]\nkind = \"obstacle\"\ngap = 0.1\n", of = "[sensitivity]\nof = [\"bar.modulus\"]\n";
  const std::string span = "[span]\ngap = 0.1\n", epsilon = "[contact]\nepsilon = 1e-3\n";
  const auto refusal = [&](const std::string& text) -> std::string {
    try {
      method(text + of);
    } catch (const SceneError& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_EQ(method(left), MethodName::characteristics);
  EXPECT_NE(refusal(left).find("characteristics, chosen for the scene, has no derivatives"), std::string::npos);
  EXPECT_NE(refusal(left).find("method.name = \"rigid\""), std::string::npos) << refusal(left);
  EXPECT_EQ(method(span), MethodName::fully_discrete);
  EXPECT_NE(refusal(span).find("fully_discrete, chosen for the scene, has no derivatives"), std::string::npos);
  EXPECT_NE(refusal(span).find("method.name = \"arkode\""), std::string::npos) << refusal(span);
  EXPECT_NE(refusal(left + "[method]\nname = \"odeint\"\n").find("odeint has no derivatives"), std::string::npos);
  for (const std::string& text : {left + epsilon, span + epsilon}) EXPECT_EQ(method(text + of), method(text)) << text;
}

TEST(SceneSensitivities, RefuseAJumpThatMoves) {
  const std::string scene =
      "[bar]\nlength = 1.0\n[initial]\nvelocity = \"x < edge ? -1 : -2\"\n[parameters]\nedge = 0.5\n[time]\nend = 1.0\n"
      "[sensitivity]\nof = [\"parameters.edge\"]\n";
  try {
    parse_scene(scene, "scene");
    ADD_FAILURE();
  } catch (const SceneError& error) {
    EXPECT_NE(std::string(error.what()).find("a jump that moves has no derivative"), std::string::npos);
  }
}

TEST(FormulaDerivative, IsExactForEveryFunctionThatFormulasKnow) {
  const Parameters parameters = {{"a", 0.7}, {"tau", 1.3}};
  for (const char* text : {"sin(a*x)*cos(a*t)", "tan(a)", "exp(-a*x^2)", "log(a+x)", "sqrt(a*x+1)", "abs(a-1)*x",
                           "min(a, x, 2)", "max(a*x, t)", "a^x", "x^a", "x^3/a - -a", "a > 0.5 ? x : t", "tau*a^2"}) {
    const Formula formula(text, "xt", parameters);
    const SpaceTimeFunction slope = formula.derivative("a");
    const double step = 1e-6, x = 0.4, t = 0.9;
    const auto at = [&](double a) { return Formula(text, "xt", {{"a", a}, {"tau", 1.3}}).of_x_t()(x, t); };
    const double difference = (at(0.7 + step) - at(0.7 - step)) / (2.0 * step);
    EXPECT_NEAR(slope ? slope(x, t) : 0.0, difference, 1e-8) << text;
  }
  EXPECT_TRUE(Formula("a > 0.5 ? x : t", "xt", parameters).moves_jump("a"));
  EXPECT_FALSE(Formula("a > 0.5 ? x : t", "xt", parameters).moves_jump("x"));
  EXPECT_FALSE(Formula("tau*t", "t", parameters).derivative("a"));
}

// A kink of the displacement lies on a node: the bar has a derivative, and each of its meshes two, whose mean it is.
// The two differ by some tenth of it; the difference quotient of a step that is a thousandth of an element has their
// mean.
TEST(SceneSensitivities, OfAKinkOnANodeAreTheMeanOfItsSides) {
  const std::string text =
      "[bar]\nlength = 1.0\nviscosity = 0.1\n[left]\nkind = \"obstacle\"\ngap = 0.1\n[initial]\ndisplacement = \"0.1*abs(x-a)\"\n"
      "velocity = -1.0\n[parameters]\na = 0.5\n[time]\nend = 1.0\n[mesh]\nelements = 30\n[method]\nname = \"rigid\"\n"
      "relative_tolerance = 1e-10\n";
  const Recording with = record(parse_scene(text, "scene", {{"sensitivity.of=[\"parameters.a\"]"}}).run);
  constexpr double step = 3e-5;
  const auto moved = [&](double by) {
    return record(parse_scene(text, "scene", {{"parameters.a=" + std::to_string(0.5 + by)}}).run);
  };
  const Recording more = moved(step), less = moved(-step);
  double largest = 0.0, worst = 0.0;
  for (std::size_t i = 0; i < with.u.size(); ++i) {
    const double slope = (more.u[i] - less.u[i]) / (2.0 * step);
    largest = std::max(largest, std::abs(slope));
    worst = std::max(worst, std::abs(with.sensitivities[0].u[i] - slope));
  }
  EXPECT_LT(worst, 1e-3 * largest);
}

}  // namespace

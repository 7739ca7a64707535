// Questions with one right answer: a fit from the truth, a datum behind a turning point, a stop that is soft on
// purpose.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <sstream>
#include <string>
#include <vector>

#include "cli/command.hpp"
#include "support/scene_text.hpp"

namespace viscobar {
namespace {

class Answers : public testing_cli::Command {
 protected:
  void write(const char* file, const std::string& text) const { std::ofstream(directory_ / file) << text; }

  nlohmann::json fitted(const std::string& arguments) const {
    const testing_cli::Ended ended = viscobar("fit scene.toml --json -o fitted " + arguments);
    EXPECT_EQ(ended.code, 0) << arguments << ended.error;
    return ended.code == 0 ? ended.json() : nlohmann::json::object();
  }
};

// The model of a fit is that of the run: its data leave no residual at the truth, where it also ends from beside. The
// elastic bar's velocities jump at samples, at the contact's and where only a wave passes.
TEST_F(Answers, AFitHasTheMethodTheLawAndTheMassOfTheRun) {
  struct {
    const char *scene, *key, *method;
    double truth, beside;
  } const fits[] = {{"span", "bar.viscosity", "fully_discrete", 0.2, 0.23},
                    {"throw", "bar.modulus", "characteristics", 1.0, 1.03},
                    {"throw", "bar.density", "characteristics", 1.0, 0.98},
                    {"throw", "left.gap", "characteristics", 0.1, 0.11}};
  const std::string span =
      "[bar]\nlength = 1.0\nviscosity = 0.2\n[span]\ngap = 0.1\n[initial]\nvelocity = \"-sin(pi*x)\"\n[time]\nend = "
      "2.0\n[mesh]\nelements = 20\n[output]\nevery = 0.02\n";
  const std::string elastic =
      "bar.length = 1.0\nleft.kind = \"obstacle\"\nleft.gap = 0.1\ninitial.velocity = -1\n"
      "time.end = 3.0\nmesh.elements = 20\noutput.every = 0.02\n";
  for (const auto& [scene, key, method, truth, beside] : fits) {
    write("scene.toml", scene == std::string("span") ? span : elastic);
    ASSERT_EQ(viscobar("run scene.toml -q --no-estimate -o made").code, 0);
    for (const double start : {truth, beside}) {
      SCOPED_TRACE(fmt::format("{} of {} from {}", key, scene, start));
      const auto json = fitted(fmt::format("--data made/ends.csv --parameters {0} --set {0}={1}", key, start));
      EXPECT_EQ(json["method"], method);
      const auto& found = json["parameters"][key];
      // The rounding of the data, 2^-53 of each, and the steps of 1e-9 below which a search ends.
      EXPECT_LE(std::abs(found["estimate"].get<double>() - truth),
                4.0 * found["standard_deviation"].get<double>() + 1e-8 * truth)
          << found;
      EXPECT_LT(json["residual"], 1e-3);
    }
  }
}

TEST_F(Answers, AFitFindsTheNumberOfASection) {
  const std::string rest =
      "[right]\nkind = \"free\"\nmass = 0.5\nstiffness = 2.0\n[time]\nend = 2.0\n[mesh]\nelements = 8\n";
  for (const auto& [key, text] :
       {std::pair("bar.section",
                  "[bar]\nlength = 1.0\nviscosity = 0.1\nsection = 1.5\n[initial]\nvelocity = \"x*x\"\n"),
        std::pair("bar.2.section",
                  "[[bar]]\nlength = 1.0\nviscosity = 0.1\nvelocity = \"x*x\"\n[[bar]]\nlength = "
                  "0.5\nviscosity = 0.1\nvelocity = 1.0\nsection = 1.5\n")}) {
    write("scene.toml", text + rest);
    ASSERT_EQ(viscobar("run scene.toml -q --no-estimate -o made").code, 0);
    const auto json = fitted(fmt::format("--data made/ends.csv --parameters {0} --set {0}=1.2", key));
    EXPECT_NEAR(json["parameters"][key]["estimate"].get<double>(), 1.5, 1e-5) << key;
  }
}

// A lone mass falls by 1/2 under g = 1 and bounces; seven times later it is on its third way up and down. With n
// bounces of speeds e^k its height then is e^(n + 1) s - s^2 / 2, s = 7 - 2 (e + ... + e^n). From 0.8 up to 0.95 that
// has a turning point in each flight, and none is as high as the datum.
TEST_F(Answers, AFitPassesTurningPointsThatDoNotReachTheDatum) {
  write("scene.toml",
        "bar.length = 2.0\nbar.modulus = 1e-12\nleft.kind = \"obstacle\"\nleft.gap = 0.5\n"
        "right.kind = \"fixed\"\nload.density = -1\ntime.end = 8.0\nmesh.elements = 1\n"
        "mesh.mass = \"lumped\"\ncontact.restitution = 0.8\ncontact.epsilon = 1e-9\n"
        "method.name = \"cvode\"\n");
  const double e = 0.98, s = 7.0 - 2.0 * (e + e * e + e * e * e);
  write("data.csv", fmt::format("t,u_left\n8,{}\n", e * e * e * e * s - 0.5 * s * s - 0.5));
  const auto found = fitted("--data data.csv --parameters contact.restitution")["parameters"]["contact.restitution"];
  // The spring lasts pi (m epsilon)^(1/2) = 1e-4 in each of three bounces; the datum's deviation is 1 %.
  EXPECT_NEAR(found["estimate"], e, 3e-4);
  EXPECT_LT(found["standard_deviation"], 0.1);
}

// Contacts that are shorter than the interval of the samples: the integrals of what was sampled lead away from the
// truth, to a valley whose residual is 7e-2 deviations.
TEST_F(Answers, AFitFromTheTruthStaysThere) {
  write("scene.toml",
        "bar.length = 1.0\nbar.viscosity = 0.02\nleft.kind = \"obstacle\"\nleft.gap = 0.1\nright.kind = \"obstacle\"\n"
        "right.gap = 0.2\nright.side = \"above\"\ninitial.velocity = -1\ntime.end = 3.0\nmesh.elements = 30\n"
        "mesh.mass = \"lumped\"\ncontact.epsilon = 1e-4\ncontact.restitution = 0.5\nmethod.name = \"odeint\"\n"
        "output.every = 0.03\n");
  ASSERT_EQ(viscobar("run scene.toml -q --no-estimate -o made").code, 0);
  for (const double start : {0.5, 0.501}) {
    const auto json = fitted(fmt::format(
        "--data made/ends.csv --parameters contact.restitution,right.gap --set contact.restitution={}", start));
    EXPECT_NEAR(json["parameters"]["contact.restitution"]["estimate"], 0.5, 1e-6) << start;
    EXPECT_NEAR(json["parameters"]["right.gap"]["estimate"], 0.2, 1e-6) << start;
    EXPECT_LT(json["residual"], 1e-6) << start;
  }
}

// A mass that falls and bounces; coarse samples of its velocity tell the gap by their jumps alone, to 4e-5, and no
// derivative leads to the minimum of another mesh, 1.4e-3 away.
TEST_F(Answers, AFitOfJumpsCountsTheErrorOfItsMesh) {
  write("scene.toml",
        "bar.length = 1.0\nbar.viscosity = 0.05\nleft.kind = \"obstacle\"\nleft.gap = 0.2\nleft.mass = 1.0\n"
        "contact.restitution = 0.5\nload.density = -1.5\ntime.end = 3.0\nmesh.elements = 20\noutput.every = 0.15\n");
  ASSERT_EQ(viscobar("run scene.toml --set mesh.elements=160 -q --no-estimate -o made").code, 0);
  std::istringstream made(read_text(directory_ / "made/ends.csv"));
  std::string data, line;
  for (std::ptrdiff_t column = -1; std::getline(made, line);) {
    std::vector<std::string> fields;
    std::istringstream rest(line);
    for (std::string field; std::getline(rest, field, ',');) fields.push_back(field);
    if (column < 0) column = std::ranges::find(fields, "v_left") - fields.begin();
    data += fields[0] + "," + fields[static_cast<std::size_t>(column)] + "\n";
  }
  write("data.csv", data);
  for (const char* start : {"left.gap=0.05", "left.gap=0.1"}) {
    const auto found =
        fitted(std::string("--data data.csv --parameters left.gap --set ") + start)["parameters"]["left.gap"];
    EXPECT_LT(std::abs(found["estimate"].get<double>() - 0.2), 4.0 * found["standard_deviation"].get<double>());
    EXPECT_LT(found["standard_deviation"], 0.02);
  }
}

// A mass on a spring has u(2) = cos 2 w, k = w^2, and a datum of -1 +- 0.01 is its turning point: the deviation by the
// slope there is anything, S rises by one where 2 w = pi +- 0.1415, which is k = pi^2 / 4 +- 0.22. The fit ends within
// 0.01 of it, for S is flat. Within these bounds: at 2 w = 3 pi there is another one, which is told.
TEST_F(Answers, AFitAtATurningPointHasTheDeviationOfTheCurve) {
  write("scene.toml",
        "bar.length = 1.0\nbar.modulus = 1e-12\nbar.density = 1e-9\nleft.kind = \"free\"\nleft.mass = 1\n"
        "left.stiffness = 4.0\nright.kind = \"fixed\"\ninitial.displacement = \"1-x\"\ntime.end = 2.0\n"
        "mesh.elements = 1\nmesh.mass = \"lumped\"\n");
  write("data.csv", "t,u_left\n2,-1\n");
  for (const char* start : {"4", "3"}) {
    const std::string fit = std::string("--data data.csv --parameters left.stiffness --set left.stiffness=") + start;
    const auto found = fitted(fit + " --bounds left.stiffness=1:6")["parameters"]["left.stiffness"];
    EXPECT_NEAR(found["estimate"], 2.467, 0.01);
    EXPECT_GT(found["standard_deviation"], 0.15);
    EXPECT_LT(found["standard_deviation"], 0.3);
    const testing_cli::Ended free = viscobar("fit scene.toml --json -o free " + fit);
    EXPECT_EQ(free.code, 1);
    EXPECT_NE(free.json()["warnings"].dump().find("starts disagree"), std::string::npos);
    EXPECT_NEAR(free.json()["parameters"]["left.stiffness"]["estimate"], 2.467, 0.01);
  }
}

TEST_F(Answers, AStopOfAGivenStiffnessIsNoObstacleThatIsTooSoft) {
  write("scene.toml", falling_bar_with({{"contact.epsilon", "1.0"}}));
  const auto told = [&](const std::string& arguments) {
    const testing_cli::Ended ended = viscobar(arguments + " --json");
    EXPECT_EQ(ended.code, 0) << ended.error;
    return ended.code == 0 ? ended.json()["warnings"].dump() : "";
  };
  for (const std::string command : {"check scene.toml", "run scene.toml --no-estimate -o out"})
    EXPECT_NE(told(command).find("right if such a stop is meant"), std::string::npos) << told(command);
  write("scene.toml", falling_bar_with({{"contact.epsilon", "1.0"}, {"contact.law", "\"spring_damper\""}}));
  const std::string stop = " --set contact.epsilon= --set contact.stiffness=1";
  for (const std::string command : {"check scene.toml", "run scene.toml --no-estimate -o out"})
    EXPECT_EQ(told(command + stop), "[]");
}

// From t = 1/2 on the obstacle is where nothing comes to: the touch at 0.1 is the only one.
TEST_F(Answers, AnObstacleMayJumpAway) {
  write("scene.toml", falling_bar_with({{"left.gap", "\"t < 0.5 ? 0.1 : 9\""}}));
  const testing_cli::Ended ended = viscobar("run scene.toml --no-estimate -o out --json --set contact.epsilon=");
  ASSERT_EQ(ended.code, 0) << ended.error;
  EXPECT_EQ(ended.json()["contact"]["left"]["closings"], 1);
  EXPECT_NEAR(ended.json()["contact"]["left"]["time_in_contact"], 0.4, 1e-5);
}

}  // namespace
}  // namespace viscobar

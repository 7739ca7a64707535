// viscobar run --sensitivity, and viscobar fit.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <sstream>
#include <string>
#include <tuple>

#include "cli/command.hpp"
#include "support/bar_above_an_obstacle.hpp"
#include "support/hdf5_attribute.hpp"

namespace {

using namespace viscobar;
using Sensitivity = testing_cli::Command;

const std::string scene_text = std::string(bar_above_an_obstacle) + R"(
[initial]
velocity = "-speed"
[parameters]
speed = 1.0
[output]
every = 0.02
)";

TEST_F(Sensitivity, HasAFileAndAPartOfTheSummary) {
  std::ofstream(directory_ / "bar.toml") << scene_text;
  const auto run = viscobar("run bar.toml --sensitivity left.gap,parameters.speed -o results --json --figures");
  ASSERT_EQ(run.code, 0) << run.error;
  const auto told = run.json()["sensitivity"];
  ASSERT_EQ(told.size(), 2u);
  EXPECT_EQ(told["left.gap"]["contact_times"].size(), 2u);
  EXPECT_NEAR(told["left.gap"]["contact_times"][0], 1.0, 1e-6);
  EXPECT_NEAR(told["parameters.speed"]["contact_times"][0], -0.1, 1e-6);
  EXPECT_NEAR(told["parameters.speed"]["impulse_left"], run.json()["contact"]["left"]["impulse"], 1e-5);
  EXPECT_TRUE(told["left.gap"]["until"].is_null());
  std::istringstream csv(read_text(directory_ / "results/sensitivity.csv"));
  std::string line;
  std::getline(csv, line);
  EXPECT_TRUE(line.starts_with("t,u_left/left.gap,v_left/left.gap,reaction_left/left.gap,u_right/left.gap,")) << line;
  EXPECT_TRUE(line.ends_with("reaction_right/parameters.speed"));
  std::size_t rows = 0;
  while (std::getline(csv, line)) ++rows;
  EXPECT_EQ(rows, 151u);
  EXPECT_TRUE(testing_cli::fs::exists(directory_ / "results/figures/sensitivity-1.svg"));
  EXPECT_EQ(viscobar("info --verify results").code, 0);
  // The next run has none, and leaves no old one behind.
  ASSERT_EQ(viscobar("run bar.toml -o results --quiet").code, 0);
  EXPECT_FALSE(testing_cli::fs::exists(directory_ / "results/sensitivity.csv"));
  EXPECT_EQ(viscobar("info --verify results").code, 0);
}

TEST_F(Sensitivity, HasUnitsInTheFieldFile) {
  const std::string units = "[units]\nlength = \"m\"\ntime = \"s\"\nmass = \"kg\"\n";
  std::ofstream(directory_ / "bar.toml") << scene_text << units;
  const auto unit = [&](const std::string& scene, const std::string& key, const std::string& more = "") {
    const auto run =
        viscobar("run " + scene + " --sensitivity " + key + " -o results --quiet --set time.end=0.1 " + more);
    EXPECT_EQ(run.code, 0) << run.error;
    return attribute(directory_ / "results/field.h5", ("sensitivity/" + key + "/u").c_str(), "units");
  };
  EXPECT_EQ(unit("bar.toml", "bar.density"), "m^4/kg");
  EXPECT_EQ(unit("bar.toml", "parameters.speed"), "none") << "nobody knows its own";
  const std::string penalised = "--set method.name=cvode --set contact.epsilon=1e-3 ";
  EXPECT_EQ(unit("bar.toml", "contact.epsilon", penalised), "kg/(m s^2)");
  EXPECT_EQ(unit("bar.toml", "contact.epsilon", penalised + "--set span.gap=0.5"), "none") << "it has two";
  std::string text = scene_text;
  text.replace(text.find("[left]"), 6, "[span]");
  text.erase(text.find("kind = \"obstacle\""), std::string("kind = \"obstacle\"").size());
  std::ofstream(directory_ / "span.toml") << text << units;
  EXPECT_EQ(unit("span.toml", "contact.epsilon", penalised), "kg/(m^2 s^2)");
}

TEST_F(Sensitivity, IsNoNumberBeyondAGrazeAndAWarningSaysSo) {
  std::ofstream(directory_ / "bar.toml") << scene_text;
  // Thrown up from the obstacle's edge under a load that turns it back just above it.
  const auto run = viscobar(
      "run bar.toml --sensitivity left.gap -o results --json --set left.gap=0.49999999998 --set load.density=1.0 "
      "--set method.relative_tolerance=1e-11 --set mesh.mass=consistent");
  ASSERT_EQ(run.code, 0) << run.error;
  EXPECT_TRUE(run.json()["sensitivity"]["left.gap"]["impulse_left"].is_null());
  EXPECT_NEAR(run.json()["sensitivity"]["left.gap"]["until"], 1.0, 1e-3);
  EXPECT_NE(run.error.find("sensitivities: there are none from t = "), std::string::npos) << run.error;
  EXPECT_NE(read_text(directory_ / "results/sensitivity.csv").find(",nan,"), std::string::npos);
}

TEST_F(Sensitivity, OfAFitFindsWhatMadeTheTrace) {
  std::ofstream(directory_ / "bar.toml") << scene_text;
  ASSERT_EQ(viscobar("run bar.toml -o made --quiet").code, 0);
  const auto found = viscobar(
      "fit bar.toml --data made/ends.csv --parameters bar.viscosity,parameters.speed --set bar.viscosity=0.2 "
      "--set parameters.speed=1.2 -o fitted --json");
  ASSERT_EQ(found.code, 0) << found.error;
  const auto json = found.json();
  EXPECT_NEAR(json["parameters"]["bar.viscosity"]["estimate"], 0.08, 1e-4);
  EXPECT_NEAR(json["parameters"]["parameters.speed"]["estimate"], 1.0, 1e-4);
  EXPECT_EQ(json["covariance"].size(), 2u);
  EXPECT_TRUE(json["residual"].is_number());
  EXPECT_GE(json["runs"], 3);
  EXPECT_TRUE(testing_cli::fs::exists(directory_ / "fitted/fit.html"));
  EXPECT_EQ(viscobar("info fitted").code, 0);
  const auto times =
      viscobar("fit bar.toml --events made/events.csv --parameters left.gap --set left.gap=0.2 -o times --json");
  ASSERT_EQ(times.code, 0) << times.error;
  EXPECT_NEAR(times.json()["parameters"]["left.gap"]["estimate"], 0.1, 1e-6);
  // A number of the section, too.
  const std::string cone = "--set 'bar.section=(1+taper*x)^2' --set parameters.taper=";
  ASSERT_EQ(viscobar("run bar.toml -o cone --quiet " + cone + "0.8").code, 0);
  const auto taper =
      viscobar("fit bar.toml --data cone/ends.csv --parameters parameters.taper -o taper --json " + cone + "0.5");
  ASSERT_EQ(taper.code, 0) << taper.error;
  EXPECT_NEAR(taper.json()["parameters"]["parameters.taper"]["estimate"], 0.8, 1e-4);
}

// The data have no noise, and a fit ends within a thousandth of a standard deviation of where they lead.
TEST_F(Sensitivity, OfAFitIsThatOfAGaugeToo) {
  std::ofstream(directory_ / "bar.toml") << scene_text;
  ASSERT_EQ(viscobar("run bar.toml -o made --quiet --set output.gauges=[0.25]").code, 0);
  // The scene names no gauge, and the length, which moves the nodes, is differenced.
  for (const auto& [key, truth, start] : {std::tuple{"bar.viscosity", 0.08, 0.2}, std::tuple{"bar.length", 1.0, 1.1}}) {
    const auto found = viscobar(
        fmt::format("fit bar.toml --data made/gauges.csv --parameters {0} --set {0}={1} -o fitted --json", key, start));
    ASSERT_EQ(found.code, 0) << found.error;
    const auto estimate = found.json()["parameters"][key];
    EXPECT_NEAR(estimate["estimate"], truth, estimate["standard_deviation"].get<double>()) << key;
    EXPECT_LT(estimate["standard_deviation"], 1e-4) << key;
    EXPECT_TRUE(found.json()["residuals"].contains("strain@0.25")) << key;
  }
}

// A run with viscosity 0.38616, modulus 1.61149 and gap 0.18871, with noise of 0.01173. Where the samples beside the
// closing are excused, values fit that close between other samples: gap 0.201 with a deviation of 0.0013.
TEST_F(Sensitivity, OfAFitMeetsSamplesBesideContactChangesAsTheyAre) {
  std::ofstream(directory_ / "bar.toml")
      << "[bar]\nlength = 1.0\nviscosity = 1.38269\nmodulus = 1.05005\n[left]\nkind = \"obstacle\"\ngap = 0.0527947\n"
         "[right]\nkind = \"obstacle\"\ngap = 0.2\n[initial]\nvelocity = \"-1.18282324*(1+0.33497497*x)\"\n[mesh]\n"
         "elements = 12\n[time]\nend = 7.84696\n[method]\nname = \"rigid\"\n";
  std::ofstream data(directory_ / "v.csv");
  data << "t,v_left\n";
  double t = 0.0;
  for (const double v : {-1.172, -0.004, -0.028, -0.009, 0.002, 0.010, 0.160, 0.258, 0.335, 0.332, 0.349, 0.343, 0.339,
                         0.358,  0.348,  0.334,  0.346,  0.337, 0.348, 0.358, 0.357, 0.359, 0.334, 0.344, 0.368, 0.329,
                         0.358,  0.354,  0.338,  0.341,  0.354, 0.352, 0.341, 0.337, 0.367, 0.365, 0.361, 0.355, 0.345,
                         0.342,  0.378,  0.358,  0.373,  0.354, 0.372, 0.369, 0.357, 0.338, 0.344, 0.353, 0.360}) {
    data << t << ',' << v << '\n';
    t += 0.156939247;
  }
  data.close();
  const auto found =
      viscobar("fit bar.toml --data v.csv --parameters bar.viscosity,bar.modulus,left.gap -o fitted --json");
  ASSERT_EQ(found.code, 0) << found.error;
  const auto json = found.json();
  for (const auto& [key, truth] :
       {std::pair{"bar.viscosity", 0.38616}, {"bar.modulus", 1.61149}, {"left.gap", 0.18871}}) {
    const auto& one = json["parameters"][key];
    EXPECT_NEAR(one["estimate"], truth, 3.0 * one["standard_deviation"].get<double>()) << key;
  }
  EXPECT_LT(json["residuals"]["v_left"]["root_mean_square"], 1.5 * 0.01173);
}

// A mass at the end bounces on its obstacle in between samples of exact data: at gap 0.2355 and restitution 0.277,
// whose residual of 1.1 deviations looks like noise, no sample that counts tells either of them.
TEST_F(Sensitivity, OfAFitByBouncesFindsThemOrSaysThatItDidNot) {
  std::ofstream(directory_ / "bar.toml")
      << "[bar]\nlength = 1.0\nviscosity = 0.05\n[left]\nkind = \"obstacle\"\ngap = 0.2\nmass = 1.0\n[contact]\n"
         "restitution = 0.5\n[load]\ndensity = -1.5\n[time]\nend = 3.0\n[mesh]\nelements = 20\n[output]\n"
         "every = 0.15\n";
  ASSERT_EQ(viscobar("run bar.toml -o made --quiet").code, 0);
  std::istringstream csv(read_text(directory_ / "made/ends.csv"));
  std::ofstream data(directory_ / "v.csv");
  for (std::string line; std::getline(csv, line);) {
    const std::size_t u = line.find(','), v = line.find(',', u + 1);
    data << line.substr(0, u) << line.substr(v, line.find(',', v + 1) - v) << '\n';
  }
  data.close();
  for (const auto& [gap, restitution, finds] : {std::tuple{0.1, 0.8, false}, {0.3, 0.9, true}, {0.1, 0.2, true}}) {
    const auto found = viscobar(
        fmt::format("fit bar.toml --data v.csv --parameters left.gap,contact.restitution --set left.gap={} --set "
                    "contact.restitution={} -o fitted --json",
                    gap, restitution));
    const auto estimates = found.json()["parameters"];
    const bool is_true = std::abs(estimates["left.gap"]["estimate"].get<double>() - 0.2) < 1e-3 &&
                         std::abs(estimates["contact.restitution"]["estimate"].get<double>() - 0.5) < 1e-3;
    EXPECT_EQ(is_true || !finds, true) << gap;
    EXPECT_EQ(found.code == 0, is_true) << gap << " " << found.out;
  }
}

// A bar that starts in contact: behind a gap of 0 the model jumps, and what else is asked for is found beside it.
TEST_F(Sensitivity, OfAFitAtABoundWhereTheModelJumpsFindsTheRest) {
  const std::string scene = "'" VISCOBAR_SOURCE_DIR "/examples/scenes/rebound.toml'";
  ASSERT_EQ(viscobar("run " + scene + " --set bar.viscosity=0.12 -o made --quiet").code, 0);
  const auto found =
      viscobar("fit " + scene + " --data made/ends.csv --parameters bar.viscosity,left.gap -o fitted --json");
  const auto json = found.json();
  EXPECT_NEAR(json["parameters"]["bar.viscosity"]["estimate"], 0.12, 1e-6);
  EXPECT_LT(json["parameters"]["bar.viscosity"]["standard_deviation"], 1e-6);
  EXPECT_EQ(json["parameters"]["left.gap"]["estimate"], 0.0);
  EXPECT_EQ(json["parameters"]["left.gap"]["at_bound"], true);
  EXPECT_EQ(found.code, 1);
}

TEST_F(Sensitivity, OfAFitSaysWhatIsWrongWithItsData) {
  std::ofstream(directory_ / "bar.toml") << scene_text;
  const auto refused = [&](const std::string& data, const std::string& what, const std::string& more = "") {
    std::ofstream(directory_ / "data.csv") << data;
    const auto run = viscobar("fit bar.toml --data data.csv --parameters left.gap " + more);
    EXPECT_EQ(run.code, 2) << data;
    EXPECT_NE(run.error.find(what), std::string::npos) << run.error;
  };
  refused("t,u_lefft\n0,1\n", "data.csv:1:2: u_lefft: unknown column; nearest is \"u_left\"");
  refused("u_left\n1\n", "t: is missing");
  refused("t,u_left\n0,1\n1,x\n", "data.csv:3:2: u_left: \"x\" is no number");
  refused("t,u_left\n0,1\n1\n", "has 1 values for 2 columns");
  refused("t,u_left\n0.1,\n0.2,\n", "u_left has no value");
  refused("t,u_left,v_left\n0.1,1,NA\n0.2,2,\n", "v_left has no value");
  refused("t,u_left\n0,0\n3000,0.2\n1500,0.1\n",
          "data.csv:3: the last time is 3000, and the scene ends at 3: is it in another unit, such as milliseconds for "
          "seconds (3)? If it is not, say --set time.end=3000");
  refused("t,u_left\n0,0\n15,0.1\n30,0.2\n", "such as milliseconds for seconds (0.03)");
  refused("t,u_left\n0,0\n1,0.1\n3,0.2\n", "such as seconds for milliseconds (3000)", "--set time.end=3000");
  refused("t [ms],u_left\n0,0\n1,0.1\n3,0.2\n", "such as seconds for milliseconds (3)", "--set units.time=s");
  refused("t,u_left [V]\n0,0\n1,0.1\n", "u_left is in V, and the scene's unit of it is mm", "--set units.length=mm");
  refused("t,u_left\n", "holds no data");
  refused("t\n0\n", "has no column of values");
  refused("t,u_left\n0,1\n1,1\n", "is no LOW:HIGH", "--bounds left.gap=0.5");
  refused("t,u_left\n0,1\n1,1\n", "is none of left.gap", "--bounds bar.modulus=1:2");
  EXPECT_EQ(viscobar("fit bar.toml --parameters left.gap").code, 2);
}

TEST_F(Sensitivity, OfAFitRefusesContactTimesWhereNothingCanTouch) {
  std::ofstream(directory_ / "bar.toml") << scene_text;
  std::ofstream(directory_ / "events.csv") << "t,where,change\n300,left,opening\n0.1,left,closing\n";
  const auto late = viscobar("fit bar.toml --events events.csv --parameters left.gap");
  EXPECT_EQ(late.code, 2);
  EXPECT_NE(late.error.find("events.csv:2: the last time is 300, and the scene ends at 3"), std::string::npos)
      << late.error;
  for (const std::string where :
       {"right", "span:3", "span:-1", "span:", "span:x", "span:99999999999999999999", "top"}) {
    std::ofstream(directory_ / "events.csv") << "t,where,change\n0.5," << where << ",closing\n";
    const auto run = viscobar("fit bar.toml --events events.csv --parameters left.gap");
    EXPECT_EQ(run.code, 2) << where;
    EXPECT_NE(run.error.find(" at t = 0.5"), std::string::npos) << run.error;
  }
  std::ofstream(directory_ / "events.csv") << "t,where,change\n";
  EXPECT_NE(viscobar("fit bar.toml --events events.csv --parameters left.gap").error.find("holds no data"),
            std::string::npos);
  std::ofstream(directory_ / "events.csv") << "t,where,change\n0.5,span:21,closing\n";
  EXPECT_EQ(viscobar("fit bar.toml --events events.csv --parameters span.gap --set left.kind=free --set left.gap= "
                     "--set span.gap=0.1")
                .code,
            2);
}

// A micrometre, where the scene counts in metres.
TEST_F(Sensitivity, OfAFitCountsDeviationsInTheUnitsOfTheirFile) {
  std::ofstream(directory_ / "bar.toml") << scene_text;
  std::ofstream(directory_ / "data.csv") << "t [s],u_left [mm]\n0,0\n0.05,-50\n0.1,-100\n0.15,-101\n0.2,-100\n";
  std::ofstream(directory_ / "events.csv") << "t [ms],where,change\n100,left,closing\n";
  const auto fit = viscobar(
      "fit bar.toml --data data.csv --events events.csv --parameters left.gap --deviation u_left=1e-3 "
      "--deviation events=0.2 --set units.time=s --set units.length=m -o fitted --json");
  const auto residuals = fit.json()["residuals"];
  EXPECT_NEAR(residuals["u_left"]["deviation"], 1e-6, 1e-18);
  EXPECT_NEAR(residuals["events"]["deviation"], 2e-4, 1e-16);
}

TEST_F(Sensitivity, OfAFitSaysHowItReadItsDataAndFindsCodesOfMissingValues) {
  std::ofstream(directory_ / "bar.toml") << scene_text;
  ASSERT_EQ(viscobar("run bar.toml -o made --quiet").code, 0);
  std::istringstream csv(read_text(directory_ / "made/ends.csv"));
  std::ofstream data(directory_ / "data.csv");
  data << "\xef\xbb\xbfTime [ms];u_left [mm];temperature\n# recorder 7\n";
  std::string line;
  std::getline(csv, line);
  for (int k = 0; std::getline(csv, line); ++k) {
    const double t = std::stod(line), u = std::stod(line.substr(line.find(',') + 1));
    std::string number = k % 20 == 7 ? "-9999" : std::to_string(1e3 * u);
    if (const auto point = number.find('.'); point != number.npos) number[point] = ',';
    data << static_cast<int>(std::round(1e3 * t)) << ";" << number << ";20\n";
  }
  data.close();
  const auto fit = viscobar(
      "fit bar.toml --data data.csv --parameters bar.viscosity --set bar.viscosity=0.2 --set units.time=s "
      "--set units.length=m -o fitted --json");
  ASSERT_EQ(fit.code, 0) << fit.error;
  const auto json = fit.json();
  EXPECT_NEAR(json["parameters"]["bar.viscosity"]["estimate"], 0.08, 1e-4);
  ASSERT_EQ(json["data"].size(), 1u);
  const std::string read = json["data"][0];
  for (const char* part : {"151 rows, t [ms] from 0 to 3000", "of u_left [mm]", "semicolons", "decimal commas",
                           "1 line of comments", "columns temperature left out"})
    EXPECT_NE(read.find(part), std::string::npos) << part << "\n" << read;
  ASSERT_EQ(json["warnings"].size(), 1u);
  EXPECT_NE(json["warnings"][0].get<std::string>().find("of u_left are -9999"), std::string::npos);
}

}  // namespace

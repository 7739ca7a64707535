#include <cmath>
#include <cstdio>
#include <fstream>
#include <numbers>

#include "cli/command.hpp"

namespace viscobar {
namespace {

class Gauges : public testing_cli::Command {
 protected:
  // A mode of a bar that is fixed at the left: u = sin(pi x / 2) exp(-d t) (cos w t + d / w sin w t).
  Gauges() {
    std::ofstream(directory_ / "mode.toml") << R"toml(
[bar]
length = 1.0
viscosity = 0.1
[left]
kind = "fixed"
[right]
kind = "free"
[initial]
displacement = "sin(pi*x/2)"
velocity = 0
[time]
end = 2.0
[mesh]
elements = 40
[method]
name = "rigid"
relative_tolerance = 1e-10
[output]
every = 0.1
gauges = [0.25, 1.0, 0.333]
)toml";
  }
  static constexpr double k = std::numbers::pi / 2, h = 1.0 / 40, end = 2.0;
  static constexpr double mode_error = k * end * (k * h) * (k * h) * (k * h) * (k * h) / 480;
  // u(1, t) of the mode, for that viscosity.
  static double mode(double viscosity, double t) {
    const double d = 0.5 * viscosity * k * k, w = std::sqrt(k * k - d * d);
    return std::exp(-d * t) * (std::cos(w * t) + d / w * std::sin(w * t));
  }
  std::vector<std::vector<double>> rows(const std::string& file) const {
    std::istringstream lines(read_text(directory_ / file));
    std::string line, cell;
    std::getline(lines, line);
    std::vector<std::vector<double>> all;
    while (std::getline(lines, line)) {
      std::istringstream cells(line);
      all.emplace_back();
      while (std::getline(cells, cell, ',')) all.back().push_back(std::stod(cell));
    }
    return all;
  }
};

// The rows (1, 10, 1)/12 have omega^2 = k^2 (1 + (k h)^4 / 240 + ...): over the run the phase is off by omega T (k h)^4
// / 480, u and v by that and their sizes, 1 and k, and strains by k of it.
TEST_F(Gauges, TellTheMotionOfAModeAtTheirPlaces) {
  ASSERT_EQ(viscobar("run mode.toml -q -o out").code, 0);
  const std::string header = read_text(directory_ / "out/gauges.csv");
  EXPECT_EQ(
      header.substr(0, header.find('\n')),
      "t,u@0.25,v@0.25,strain@0.25,stress@0.25,u@1,v@1,strain@1,stress@1,u@0.333,v@0.333,strain@0.333,stress@0.333");
  const auto table = rows("out/gauges.csv");
  ASSERT_EQ(table.size(), 21u);
  const double d = 0.05 * k * k, w = std::sqrt(k * k - d * d), allowed = 4.0 * mode_error;
  for (const auto& row : table) {
    const double t = row[0], decay = std::exp(-d * t);
    const double u = decay * (std::cos(w * t) + d / w * std::sin(w * t)), v = -decay * k * k / w * std::sin(w * t);
    for (std::size_t g = 0; g < 3; ++g) {
      const double x = std::array{0.25, 1.0, 0.333}[g];
      EXPECT_NEAR(row[4 * g + 1], u * std::sin(k * x), allowed) << t << " " << x;
      EXPECT_NEAR(row[4 * g + 2], v * std::sin(k * x), 2 * allowed) << t << " " << x;
      EXPECT_NEAR(row[4 * g + 3], u * k * std::cos(k * x), 4 * allowed) << t << " " << x;
      EXPECT_NEAR(row[4 * g + 4], (u + 0.1 * v) * k * std::cos(k * x), 4 * allowed) << t << " " << x;
    }
  }
  EXPECT_EQ(viscobar("info --verify out").code, 0);
}

TEST_F(Gauges, OfARunThatWasStoppedGoOn) {
  ASSERT_EQ(viscobar("run mode.toml -q --checkpoint 0.5 -o whole").code, 0);
  ASSERT_EQ(viscobar("run mode.toml -q --checkpoint 0.5 --wall-time 1e-9s -o out").code, 130);
  ASSERT_EQ(viscobar("resume -q out").code, 0);
  EXPECT_EQ(read_text(directory_ / "out/gauges.csv"), read_text(directory_ / "whole/gauges.csv"));
  ASSERT_EQ(viscobar("run mode.toml -q -o whole --set output.gauges=[]").code, 0);
  EXPECT_FALSE(testing_cli::fs::exists(directory_ / "whole/gauges.csv"));
}

TEST_F(Gauges, WrongOnesAreNamed) {
  const auto error = [&](const std::string& value) {
    const auto ended = viscobar("check mode.toml --set 'output.gauges=" + value + "'");
    EXPECT_EQ(ended.code, 2) << value;
    return ended.error;
  };
  EXPECT_NE(error("[0.5, 1.5]").find("must lie on the bar, in [0, 1], and 1.5 does not"), std::string::npos);
  EXPECT_NE(error("[0.5, 0.5]").find("has 0.5 twice"), std::string::npos);
  EXPECT_NE(error("[-0.5]").find("must not be negative"), std::string::npos);
  EXPECT_NE(error("0.5").find("must be a list of numbers, such as [0.0, 0.25], is a number"), std::string::npos);
  EXPECT_NE(error("[\"a\"]").find("must be a list of numbers"), std::string::npos);
}

// The two sides of a joint and its force: data of a comparison, and of a fit, which finds what made them.
TEST_F(Gauges, SoAreJointsDataOfOthers) {
  std::ofstream(directory_ / "pair.toml")
      << "[[bar]]\nlength = 1.0\nviscosity = 0.02\nvelocity = 1.0\n[[bar]]\nlength = 1.0\nviscosity = "
         "0.02\nmodulus = 2.0\n[[joint]]\nkind = \"contact\"\ngap = 0.05\n[time]\nend = 3.0\n[mesh]\nelements = "
         "40\n[method]\nname = \"rigid\"\n";
  ASSERT_EQ(viscobar("run pair.toml -q -o out").code, 0);
  const auto judged = viscobar("compare pair.toml --with out/joints.csv --json -o judged");
  EXPECT_EQ(judged.code, 0) << judged.error;
  const auto fitted = viscobar(
      "fit pair.toml --set bar.2.modulus=1.5 --data out/joints.csv --parameters bar.2.modulus --json -o fitted");
  ASSERT_EQ(fitted.code, 0) << fitted.error;
  EXPECT_NEAR(fitted.json()["parameters"]["bar.2.modulus"]["estimate"].get<double>(), 2.0, 1e-4) << fitted.out;
  // A number that a bar does not say begins at what it is then.
  EXPECT_EQ(viscobar("fit pair.toml --data out/joints.csv --parameters bar.1.modulus -q -o other").code, 0);
}

// A file of our own gauges is the bar to our own error; another gap is not.
TEST_F(Gauges, AreHeldAgainstTheBarItself) {
  ASSERT_EQ(viscobar("run mode.toml -q -o out").code, 0);
  const auto judged = viscobar("compare mode.toml --with out/gauges.csv,out/ends.csv=0.1 --json -o judged");
  ASSERT_EQ(judged.code, 0) << judged.error;
  const auto json = judged.json();
  ASSERT_EQ(json["judged"].size(), 2u);
  for (const auto& [of, column] : {std::pair(0, "u@0.333"), std::pair(1, "u_right")}) {
    const auto& told = json["judged"][of]["columns"][column];
    EXPECT_LT(told["largest"].get<double>(), 4.0 * mode_error + told["own_error"].get<double>()) << column;
  }
  EXPECT_EQ(json["judged"][0]["label"], "out/gauges.csv");
  EXPECT_EQ(json["judged"][1]["step"], 0.1);
  EXPECT_TRUE(testing_cli::fs::exists(directory_ / "judged/judge.html"));
  EXPECT_EQ(viscobar("info judged --json").json()["results"][0]["kind"], "judge");
  // Tables leave out the folders that all files are in.
  const std::string together = viscobar("compare mode.toml --with out/gauges.csv,out/ends.csv -o judged").out;
  EXPECT_NE(together.find("\n  gauges.csv "), std::string::npos) << together;
  EXPECT_NE(together.find("\n  ends.csv "), std::string::npos) << together;
  const std::string apart_from = viscobar("compare mode.toml --with out/gauges.csv,./out/ends.csv -o judged").out;
  EXPECT_NE(apart_from.find("\n  out/gauges.csv "), std::string::npos) << apart_from;
  const auto other = viscobar("compare mode.toml --set bar.viscosity=0.2 --with out/gauges.csv --json -o other").json();
  double apart = 0.0;  // of the two modes, at the output times
  for (int n = 0; n <= 20; ++n) apart = std::max(apart, std::abs(mode(0.1, 0.1 * n) - mode(0.2, 0.1 * n)));
  const auto& told = other["judged"][0]["columns"]["u@1"];
  EXPECT_NEAR(told["largest"].get<double>(), apart, 4.0 * mode_error + told["own_error"].get<double>());
  EXPECT_TRUE(told["told_apart"].get<bool>());
  EXPECT_EQ(viscobar("compare mode.toml --with nothing.csv -o no").code, 2);
  EXPECT_EQ(viscobar("compare mode.toml --with out/ends.csv=x -o no").code, 2);
}

// A place that is written with an exponent, of a bar shorter than the unit of its lengths.
TEST_F(Gauges, AtPlacesWithAnExponentAreReadAgain) {
  std::ofstream(directory_ / "small.toml")
      << "[bar]\nlength = 2e-4\nmodulus = 1e-8\nviscosity = 1e-9\n[initial]\nvelocity = \"1e-4*cos(pi*x/2e-4)\"\n[time]\n"
         "end = 2.0\n[mesh]\nelements = 20\n[output]\ngauges = [7.5e-5]\n";
  ASSERT_EQ(viscobar("run small.toml -q --no-estimate -o out").code, 0);
  const auto fit =
      viscobar("fit small.toml --data out/gauges.csv --parameters bar.viscosity --set bar.viscosity=2e-9 --json");
  ASSERT_EQ(fit.code, 0) << fit.error;
  EXPECT_NEAR(fit.json()["parameters"]["bar.viscosity"]["estimate"].get<double>(), 1e-9, 1e-12);
}

// 0.7 + 0.1 is less than 0.8 by its rounding: that is the joint nevertheless, where the left bar is read, and the end.
TEST_F(Gauges, AtJointsAndEndsAreThereUpToTheRoundingOfLengths) {
  const std::string two =
      "[[bar]]\nlength = 0.7\nviscosity = 0.1\nvelocity = -1.0\n[[bar]]\nlength = 0.1\nviscosity = 0.1\n";
  const std::string rest =
      "[left]\nkind = \"obstacle\"\ngap = 0.1\n[time]\nend = 1.0\n[mesh]\nelements = 40\n[output]\ngauges = ";
  std::ofstream(directory_ / "two.toml") << two << rest << "[0.8]\n";
  const auto ended = viscobar("run two.toml -q --no-estimate -o two");
  EXPECT_EQ(ended.code, 0) << ended.error;
  const auto fit = viscobar("fit two.toml --data two/gauges.csv --parameters bar.1.viscosity --json");
  EXPECT_EQ(fit.code, 0) << fit.error;
  std::ofstream(directory_ / "three.toml") << two << "[[bar]]\nlength = 0.5\nmodulus = 9.0\nviscosity = 0.1\n"
                                           << rest << "[0.79999, 0.8]\n";
  ASSERT_EQ(viscobar("run three.toml -q --no-estimate -o three").code, 0);
  const std::string table = read_text(directory_ / "three" / "gauges.csv");
  const std::string last = table.substr(table.rfind('\n', table.size() - 2) + 1);
  double t, u, v, before, stress, at;
  ASSERT_EQ(std::sscanf(last.c_str(), "%lf,%lf,%lf,%lf,%lf,%lf,%lf,%lf", &t, &u, &v, &before, &stress, &u, &v, &at), 8);
  EXPECT_NEAR(at / before, 1.0, 0.01);
}

// Contact changes belong to the file before them; each --with has an order of its own.
TEST_F(Gauges, ContactChangesOfOthersAreJudgedAndSchemesAreKeptApart) {
  const std::string scene =
      "mode.toml --set left.kind=free --set right.kind=obstacle --set right.gap=0.1 "
      "--set initial.displacement=0 --set initial.velocity=-1";
  ASSERT_EQ(viscobar("run " + scene + " -q -o a").code, 0);
  ASSERT_EQ(viscobar("run " + scene + " -q -o b --set bar.viscosity=0.2").code, 0);
  const auto json = viscobar("compare " + scene +
                             " --with a/ends.csv=0.1,a/events.csv,b/ends.csv=0.05 --with b/ends.csv=0.01 --with "
                             "a/events.csv --json -o judged")
                        .json();
  ASSERT_EQ(json["judged"].size(), 4u);
  EXPECT_EQ(json["judged"][0]["sample"], 0.0);  // its contacts are those of a/events.csv
  EXPECT_TRUE(json["judged"][2]["columns"]["u_right"]["order"].is_null());
  EXPECT_EQ(json["judged"][2]["columns"]["v_right"]["order_of"], "mean");
  for (const std::size_t s : {std::size_t{0}, std::size_t{3}}) {
    const auto& contact = json["judged"][s]["contacts"].at(0);
    EXPECT_EQ(contact["verdict"], "found");
    EXPECT_NEAR(contact["delay"].get<double>(), 0.0, 1e-4);  // on 40 elements
  }
  const auto refused = [&](const std::string& with) {
    const auto ended = viscobar("compare " + scene + " -o no --with " + with);
    EXPECT_EQ(ended.code, 2) << with;
    return ended.error;
  };
  EXPECT_NE(refused("a/ends.csv,a/events.csv=0.1").find("have the step of the file before"), std::string::npos);
  std::ofstream(directory_ / "both.csv") << "t,u_left,where\n0,0,left\n";
  EXPECT_NE(refused("both.csv").find("in a file of their own"), std::string::npos);
  std::ofstream(directory_ / "left.csv") << "t,where,change\n0.5,left,closing\n";
  EXPECT_NE(refused("left.csv").find("at the left end, where the scene has no obstacle"), std::string::npos);
}

}  // namespace
}  // namespace viscobar

#include <cmath>
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

// Order 4 of the mesh: (pi h / 2)^4 / 240 of the frequency, over two time units.
TEST_F(Gauges, TellTheMotionOfAModeAtTheirPlaces) {
  ASSERT_EQ(viscobar("run mode.toml -q -o out").code, 0);
  const std::string header = read_text(directory_ / "out/gauges.csv");
  EXPECT_EQ(
      header.substr(0, header.find('\n')),
      "t,u@0.25,v@0.25,strain@0.25,stress@0.25,u@1,v@1,strain@1,stress@1,u@0.333,v@0.333,strain@0.333,stress@0.333");
  const auto table = rows("out/gauges.csv");
  ASSERT_EQ(table.size(), 21u);
  const double k = std::numbers::pi / 2, d = 0.05 * k * k, w = std::sqrt(k * k - d * d), allowed = 1e-7;
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

// A file of our own gauges is the bar to our own error; another gap is not.
TEST_F(Gauges, AreHeldAgainstTheBarItself) {
  ASSERT_EQ(viscobar("run mode.toml -q -o out").code, 0);
  const auto judged = viscobar("compare mode.toml --with out/gauges.csv,out/ends.csv=0.1 --json -o judged");
  ASSERT_EQ(judged.code, 0) << judged.error;
  const auto json = judged.json();
  ASSERT_EQ(json["judged"].size(), 2u);
  EXPECT_LT(json["judged"][0]["columns"]["u@0.333"]["largest"], 1e-7);
  EXPECT_LT(json["judged"][1]["columns"]["u_right"]["largest"], 1e-7);
  EXPECT_EQ(json["judged"][1]["step"], 0.1);
  EXPECT_TRUE(testing_cli::fs::exists(directory_ / "judged/judge.html"));
  EXPECT_EQ(viscobar("info judged --json").json()["results"][0]["kind"], "judge");
  const auto other = viscobar("compare mode.toml --set bar.viscosity=0.2 --with out/gauges.csv --json -o other").json();
  EXPECT_GT(other["judged"][0]["columns"]["u@1"]["largest"], 0.05);
  EXPECT_LT(other["judged"][0]["columns"]["u@1"]["own_error"], 0.01);
  EXPECT_EQ(viscobar("compare mode.toml --with nothing.csv -o no").code, 2);
  EXPECT_EQ(viscobar("compare mode.toml --with out/ends.csv=x -o no").code, 2);
}

}  // namespace
}  // namespace viscobar

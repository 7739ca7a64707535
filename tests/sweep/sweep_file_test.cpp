#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <sstream>
#include <stdexcept>

#include "input/described_scene.hpp"
#include "support/scene_text.hpp"
#include "support/scratch.hpp"
#include "sweep/sweep_results.hpp"
#include "sweep/sweep_table.hpp"
#include "viscobar/sweep/sweep.hpp"

namespace viscobar {
namespace {

namespace fs = std::filesystem;

const std::string scene = falling_bar_with({{"mesh.elements", "9"}});

class SweepFileTest : public testing::Test {
 protected:
  SweepFileTest() { write("scene.toml", scene); }

  void write(const char* name, const std::string& text) const { std::ofstream(scratch_ / name) << text; }

  SweepFile read(const std::string& text, const std::vector<std::string>& overrides = {}) const {
    write("sweep.toml", text);
    return read_sweep(scratch_ / "sweep.toml", overrides);
  }

  /// "line:column: key: message" of everything wrong.
  std::vector<std::string> faults(const std::string& text) const {
    try {
      const SweepFile sweep = read(text);
      plan_cases(sweep);
      return {};
    } catch (const SceneError& error) {
      std::vector<std::string> texts;
      for (const Diagnostic& found : error.diagnostics) texts.push_back(found.text().substr(found.source.size() + 1));
      return texts;
    }
  }

  template <class Value>
  std::vector<Value> values(const std::string& key, const std::string& text) const {
    const SweepFile sweep = read("scene = \"scene.toml\"\n[vary]\n" + key + " = " + text + "\n");
    return std::get<std::vector<Value>>(sweep.plan.keys.front().values);
  }

  const Scratch scratch_;
};

TEST_F(SweepFileTest, TakesNamesQuotedDottedOrInATableAlike) {
  const std::string head = "scene = \"scene.toml\"\n";
  for (const std::string vary : {"[vary]\n\"bar.viscosity\" = [1, 2.5]\n\"mesh.elements\" = [3]\n",
                                 "[vary]\nbar.viscosity = [1, 2.5]\nmesh.elements = [3]\n",
                                 "[vary.bar]\nviscosity = [1, 2.5]\n[vary.mesh]\nelements = [3]\n"}) {
    const SweepFile sweep = read(head + vary);
    ASSERT_EQ(sweep.plan.keys.size(), 2u) << vary;
    EXPECT_EQ(sweep.plan.keys[0].key, "bar.viscosity");
    EXPECT_EQ(std::get<std::vector<double>>(sweep.plan.keys[0].values), (std::vector{1.0, 2.5}));
    EXPECT_EQ(std::get<std::vector<std::int64_t>>(sweep.plan.keys[1].values), (std::vector<std::int64_t>{3}));
  }
}

TEST_F(SweepFileTest, TakesKeysOfBarsInLineAndTheirJointsAlike) {
  const std::string head = "scene = \"scene.toml\"\n";
  for (const std::string text : {"[set]\n\"bar.2.density\" = 2.0\n[vary]\n\"joint.1.gap\" = [1, 2.5]\n",
                                 "[set]\nbar.2.density = 2.0\n[vary]\njoint.1.gap = [1, 2.5]\n",
                                 "[set.bar.2]\ndensity = 2.0\n[vary.joint.1]\ngap = [1, 2.5]\n"}) {
    const SweepFile sweep = read(head + text);
    ASSERT_EQ(sweep.plan.keys.size(), 1u) << text;
    EXPECT_EQ(sweep.plan.keys[0].key, "joint.1.gap");
    EXPECT_EQ(sweep.settings, (std::vector<Setting>{std::pair(std::string("bar.2.density"), SceneValue(2.0))}));
  }
  EXPECT_EQ(faults(head + "[vary]\njoint.1.gapp = [1, 2.5]\n"),
            (std::vector<std::string>{"3:9: joint.1.gapp: unknown key; nearest is \"gap\""}));
}

TEST_F(SweepFileTest, KeepsTheOrderOfTheFile) {
  const SweepFile sweep =
      read("scene = \"scene.toml\"\n[vary]\ntime.end = [1]\nbar.length = [1]\nmesh.mass = [\"paper\"]\n");
  EXPECT_EQ(sweep.plan.keys[0].key, "time.end");
  EXPECT_EQ(sweep.plan.keys[1].key, "bar.length");
  EXPECT_EQ(sweep.plan.keys[2].key, "mesh.mass");
}

TEST_F(SweepFileTest, ARangeByDecadesHitsThePowersOfTenExactly) {
  const auto down = values<double>("contact.epsilon", "{ from = 1e-2, to = 1e-8, per_decade = 2 }");
  ASSERT_EQ(down.size(), 13u);
  const double exact[] = {1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8};
  for (std::size_t k = 0; k < 7; ++k) EXPECT_EQ(down[2 * k], exact[k]);
  // A power and a product, each rounded once.
  EXPECT_NEAR(down[1] / 1e-2, std::pow(10.0, -0.5), 4e-16);
  EXPECT_EQ(values<double>("bar.viscosity", "{ from = 3e-2, to = 3, per_decade = 1 }"), (std::vector{3e-2, 0.3, 3.0}));
  EXPECT_EQ(values<double>("bar.viscosity", "{ from = 1, to = 50, per_decade = 1 }"), (std::vector{1.0, 10.0}));
}

TEST_F(SweepFileTest, ARangeByCountIsEvenOrGeometricAndHasBothEnds) {
  EXPECT_EQ(values<double>("left.gap", "{ from = 0, to = 1, count = 5 }"), (std::vector{0.0, 0.25, 0.5, 0.75, 1.0}));
  const auto log = values<double>("bar.viscosity", "{ from = 1, to = 16, count = 5, spacing = \"log\" }");
  ASSERT_EQ(log.size(), 5u);
  for (std::size_t k = 0; k < 5; ++k) EXPECT_NEAR(log[k], std::pow(2.0, k), 4e-16 * std::pow(2.0, k));
  EXPECT_EQ(log.back(), 16.0);
}

TEST_F(SweepFileTest, ARangeByCountOfRoundNumbersHasRoundNumbers) {
  const auto expect = [&](const std::string& range, std::vector<double> round) {
    EXPECT_EQ(values<double>("left.gap", range), round) << range;
  };
  std::vector<double> gaps, through_zero;
  for (int k = 0; k <= 14; ++k) gaps.push_back(std::strtod(fmt::format("{}e-6", 5 * k).c_str(), nullptr));
  for (int k = -10; k <= 10; ++k) through_zero.push_back(std::strtod(fmt::format("{}e-1", k).c_str(), nullptr));
  expect("{ from = 0, to = 7e-5, count = 15 }", gaps);
  expect("{ from = 0.1, to = 0.7, count = 7 }", {0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7});
  expect("{ from = 1e-4, to = 1e-1, count = 4, spacing = \"log\" }", {1e-4, 1e-3, 1e-2, 1e-1});
  const auto symmetric = values<double>("left.force", "{ from = -1, to = 1, count = 21 }");
  EXPECT_EQ(symmetric, through_zero);
  // A third is no round number, and keeps its digits.
  EXPECT_NEAR(values<double>("left.gap", "{ from = 0, to = 1, count = 4 }")[1], 1.0 / 3.0, 1e-16);
}

TEST_F(SweepFileTest, ARangeMayEndBelowTheNormalNumbers) {
  EXPECT_EQ(values<double>("bar.viscosity", "{ from = 1.01e-308, to = 1e-310, per_decade = 1 }"),
            (std::vector{1.01e-308, 1.01e-309, 1.01e-310}));
  EXPECT_EQ(values<double>("bar.viscosity", "{ from = 5e-324, to = 1e-17, per_decade = 1 }").back(), 5e-18);
}

TEST_F(SweepFileTest, ARangeOfWholeNumbersIsRoundedAndHasEachOnce) {
  EXPECT_EQ(values<std::int64_t>("mesh.elements", "{ from = 1, to = 100, per_decade = 4 }"),
            (std::vector<std::int64_t>{1, 2, 3, 6, 10, 18, 32, 56, 100}));
}

TEST_F(SweepFileTest, FormulasAndNumbersMayStandInOneList) {
  EXPECT_EQ(values<std::string>("initial.velocity", "[-1, \"-x*(1-x)\", 0.5]"),
            (std::vector<std::string>{"-1", "-x*(1-x)", "0.5"}));
}

TEST_F(SweepFileTest, FormulasMayUseTheParametersOfTheSceneAndOfTheSweep) {
  write("scene.toml", scene + "[parameters]\na = 1\n");
  EXPECT_EQ(
      faults("scene = \"scene.toml\"\n[set]\nleft.gap = \"b+0.1*t\"\n[vary]\ninitial.velocity = [\"-a\", \"b*x\"]\n"
             "parameters.b = [1.5, 2]\n"),
      std::vector<std::string>{});
}

TEST_F(SweepFileTest, ListsAreSetForAllCases) {
  const SweepFile sweep = read(
      "scene = \"scene.toml\"\n[set]\nmesh.elements = 2\nmesh.nodes = [0, 0.3, 1]\noutput.write = [\"ends\"]\n[vary]\nleft.gap = [0.1, 0.2]\n");
  const Case run = parse_scene_with(sweep.scene_text, "scene", case_of(sweep, 1).settings).run;
  EXPECT_EQ(run.mesh().node(1), 0.3);
  EXPECT_TRUE(run.files.ends && !run.files.field);
}

// Two elements a bar would be left on the coarse mesh.
TEST_F(SweepFileTest, ACaseThatACoarseMeshWouldRefuseIsSound) {
  std::string chain;
  for (int k = 0; k < 14; ++k) chain += "[[bar]]\nlength = 1\n";
  write("scene.toml",
        chain + "[initial]\nvelocity = 1\n[time]\nend = 1\n[mesh]\nelements = 100\nmass = \"fourth_order\"\n");
  const std::string sweep = "scene = \"scene.toml\"\n[vary]\nbar.2.viscosity = [0.1, 0.2]\n";
  EXPECT_EQ(faults(sweep), std::vector<std::string>{});
  for (const double cost : plan_cases(read(sweep))) EXPECT_GT(cost, 0.0);
}

TEST_F(SweepFileTest, AMeasuredSeriesOfABarInLineIsFoundBesideItsScene) {
  fs::create_directory(scratch_ / "below");
  write("below/section.csv", "x,A\n0,1\n0.5,1.2\n1,1.5\n");
  write("below/scene.toml",
        "[[bar]]\nlength = 1\nsection = { file = \"section.csv\", column = \"A\" }\n[[bar]]\nlength = 1\n"
        "[initial]\nvelocity = 1\n[time]\nend = 1\n");
  const SweepFile sweep = read("scene = \"below/scene.toml\"\n[vary]\nbar.2.viscosity = [0.1, 0.2]\n");
  const auto row = run_case(sweep.scene_text, case_of(sweep, 0));
  EXPECT_TRUE(row && row->completed) << row->error;
}

TEST_F(SweepFileTest, ErrorsVaryAsNumbersPercentagesOrBoth) {
  EXPECT_EQ(values<double>("accuracy.error", "[0.01, 2e-3]"), (std::vector<double>{0.01, 2e-3}));
  EXPECT_EQ(values<double>("accuracy.error", "{ from = 1e-2, to = 1e-3, per_decade = 1 }"),
            (std::vector<double>{1e-2, 1e-3}));
  const std::string both = "scene = \"scene.toml\"\n[vary]\naccuracy.error = [0.01, \"0.5 %\"]\n";
  EXPECT_EQ(faults(both), std::vector<std::string>{});
  const SweepFile sweep = read(both);
  for (std::size_t i = 0; i < 2; ++i) {
    const auto request =
        parse_scene_with(sweep.scene_text, sweep.scene_source, case_of(sweep, i).settings).accuracy.value();
    EXPECT_EQ(request.relative, i == 1);
    EXPECT_EQ(request.error, i == 1 ? 0.005 : 0.01);
  }
}

TEST_F(SweepFileTest, SettingsHoldForAllCasesThoseOfTheCommandLineLast) {
  const SweepFile sweep =
      read("scene = \"scene.toml\"\n[set]\ntime.end = 2\nmethod.name = \"ida\"\n[vary]\nbar.viscosity = [1]\n",
           {"time.end=3"});
  std::vector<std::string> texts;
  for (const Setting& setting : case_of(sweep, 0).settings) texts.push_back(text_of(setting));
  EXPECT_EQ(texts,
            (std::vector<std::string>{"time.end=2.0", "method.name=\"ida\"", "time.end=3", "bar.viscosity=1.0"}));
}

TEST_F(SweepFileTest, EverythingWrongIsSaidAtOnceWithItsPlaceAndTheNearestKey) {
  const auto found = faults(
      "scenee = \"none.toml\"\ncombine = \"gird\"\n[set]\nbar.viscosity = [1]\ntime.end = -1\n[vary]\n"
      "bar.lenght = [1.0]\nbar.density = [1.0, -2.0, \"x\"]\ncontact.epsilon = { from = 1e-2, to = 0, per_decade = 2 "
      "}\n"
      "mesh.elements = { from = 9, to = 20, count = 3, per_decade = 2 }\nmesh.mass = { from = 1, to = 2, count = 2 }\n"
      "method.name = \"cvode\"\nleft.gap = []\nmehs.elements = [1]\ntime.end = [1]\n");
  EXPECT_EQ(
      found,
      (std::vector<std::string>{
          "1:1: scenee: unknown key; nearest is \"scene\"",
          "1:10: scene: \"none.toml\" does not exist",
          "2:11: combine: cannot be \"gird\"; nearest is \"grid\"",
          "4:17: bar.viscosity: must be one value, is an array",
          "5:12: time.end: must be positive, is -1",
          "7:5: bar.lenght: unknown key; nearest is \"length\"",
          "8:21: bar.density: must be positive, is -2",
          "8:27: bar.density: must be a number, is a string",
          "9:39: contact.epsilon: to must be positive in a logarithmic range",
          "10:49: mesh.elements: excludes count: a range has one or the other",
          "11:13: mesh.mass: takes no numbers, so give a list of its values, not a range",
          "12:15: method.name: must be a list of values, or a range { from, to, count }, or { from, to, per_decade "
          "}; a single value belongs into [set]",
          "13:12: left.gap: is an empty list",
          "14:6: mehs.elements: unknown table; nearest is [mesh]",
          "15:6: time.end: is given twice: in [set], or in [vary]",
      }));
}

TEST_F(SweepFileTest, ASceneIsToldFromASweep) {
  try {
    read(scene);
    FAIL() << "a scene was taken for a sweep";
  } catch (const SceneError& error) {
    ASSERT_EQ(error.diagnostics.size(), 1u) << error.what();
    EXPECT_NE(error.diagnostics[0].message.find("this is a scene"), std::string::npos) << error.what();
  }
}

TEST_F(SweepFileTest, ACombinationThatDoesNotFitIsARowNotAnEnd) {
  const SweepFile sweep = read("scene = \"scene.toml\"\n[vary]\ninitial.displacement = [0, -1]\n");
  const std::vector<double> costs = plan_cases(sweep);
  EXPECT_GT(costs[0], 0.0);
  EXPECT_EQ(costs[1], 0.0);
  const SweepRow good = run_case(sweep.scene_text, case_of(sweep, 0)).value(),
                 bad = run_case(sweep.scene_text, case_of(sweep, 1)).value();
  EXPECT_TRUE(good.completed) << good.error;
  EXPECT_EQ(good.error, "");
  EXPECT_EQ(good[Quantity::reached_time], 1.0);
  EXPECT_FALSE(bad.completed);
  EXPECT_EQ(bad.error, "initial.displacement: penetrates the obstacle of [left]: u_0(0) = -1 < -gap = -0.1");
  EXPECT_EQ(bad[Quantity::steps], 0.0);
  EXPECT_TRUE(std::isnan(bad[Quantity::energy_final]));
}

TEST_F(SweepFileTest, TheImpulseOfAnElasticImpactIsTwiceTheMomentum) {
  // alpha = 0, rho = E = L = 1 at speed -1: reaction 1 for 2 L/c = 2, so impulse 2.
  const SweepFile sweep = read(
      "scene = \"scene.toml\"\n[set]\nbar.viscosity = 0\nmesh.elements = 200\ntime.end = 4\nmesh.mass = "
      "\"redistributed\"\n"
      "[vary]\nmethod.name = [\"rigid\"]\n");
  const SweepRow row = run_case(sweep.scene_text, case_of(sweep, 0)).value();
  ASSERT_TRUE(row.completed) << row.error;
  // The remainder is the strain that dispersion leaves in the bar, the momentum of O(h^(2/3)) of it.
  EXPECT_NEAR(row[Quantity::impulse_left], 2.0, 2.0 * std::pow(1.0 / 200.0, 2.0 / 3.0));
  EXPECT_TRUE(std::isnan(row[Quantity::impulse_right])) << "there is no obstacle";
  EXPECT_LT(row[Quantity::u_left_min], -0.1 + 1e-6);
  EXPECT_EQ(row[Quantity::u_left_max], row[Quantity::u_left_final]);
}

TEST_F(SweepFileTest, TheTableGivesBackEveryRowBitForBit) {
  const SweepFile sweep =
      read("scene = \"scene.toml\"\n[vary]\ninitial.displacement = [0, -1]\nbar.viscosity = [0.1, 0]\n");
  std::vector<SweepRow> rows;
  for (const std::size_t i : {3, 0, 1}) {
    rows.push_back(run_case(sweep.scene_text, case_of(sweep, i)).value());
    SweepTable table(scratch_ / "sweep.h5", sweep.plan, sweep.identity());  // opened anew for each
    table.write(rows.back());
    table.commit();
  }
  const std::vector<SweepRow> back = SweepTable(scratch_ / "sweep.h5", sweep.plan, sweep.identity()).read();
  ASSERT_EQ(back.size(), 3u);
  const std::vector<const SweepRow*> written = {&rows[1], &rows[2], &rows[0]},
                                     read_back = {&back[0], &back[1], &back[2]};
  for (const auto& columns : {sweep_columns(sweep.plan), timing_columns()})
    EXPECT_EQ(csv_of(columns, read_back), csv_of(columns, written));
}

TEST_F(SweepFileTest, EveryColumnIsDocumented) {
  std::ostringstream page;
  page << std::ifstream(VISCOBAR_SOURCE_DIR "/docs/sweep.md").rdbuf();
  for (const QuantityColumn& column : quantity_columns()) {
    const std::string row = "| `" + column.name + "` | " + column.unit + " | " + column.meaning + " |";
    EXPECT_NE(page.str().find(row), std::string::npos) << row;
  }
}

TEST_F(SweepFileTest, EveryExampleIsASweepWhoseCasesCanRun) {
  std::size_t found = 0;
  for (const auto& entry : fs::directory_iterator(VISCOBAR_SOURCE_DIR "/examples/sweeps")) {
    if (entry.path().extension() != ".toml") continue;
    ++found;
    const std::vector<double> costs = plan_cases(read_sweep(entry.path()));
    EXPECT_GT(*std::min_element(costs.begin(), costs.end()), 0.0) << entry.path();
  }
  EXPECT_GE(found, 3u);
}

TEST_F(SweepFileTest, TheTableOfAnotherSweepIsNotTouched) {
  const std::string head = "scene = \"scene.toml\"\n[vary]\n";
  const SweepFile one = read(head + "bar.viscosity = [0.1, 0.2]\n"),
                  other = read(head + "bar.viscosity = [0.1, 0.3]\n");
  SweepTable(scratch_ / "sweep.h5", one.plan, one.identity()).close();
  EXPECT_THROW(SweepTable(scratch_ / "sweep.h5", other.plan, other.identity()), std::invalid_argument);
  EXPECT_NO_THROW(SweepTable(scratch_ / "sweep.h5", one.plan, one.identity()));
}

}  // namespace
}  // namespace viscobar

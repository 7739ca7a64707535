// Series of measured values, in files and in scenes.
#include "input/series.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include "input/described_scene.hpp"
#include "input/trace_file.hpp"
#include "support/maximum_norm.hpp"
#include "viscobar/case/recording.hpp"

namespace viscobar::testing_series {
namespace {

using characteristics::FunctionOfTime;
constexpr double end = 7.0;

FunctionOfTime spline(const std::vector<double>& t, const std::vector<double>& y) {
  return function_of(std::make_shared<Series>(t, y, Interpolation::cubic, Outside::goes_on));
}

// h^4 for the spline, h^2 for its second derivative; a cubic it gives back.
TEST(Series, OfSamplesIsACubicSpline) {
  const auto through = [](std::size_t n, auto&& f) {
    std::vector<double> t, y;
    for (std::size_t i = 0; i <= n; ++i)
      t.push_back(end * std::pow(static_cast<double>(i) / static_cast<double>(n), 1.1)), y.push_back(f(t.back()));
    return spline(t, y);
  };
  const auto cubic = [](double t) { return 1.0 + t * (2.0 - t * (0.5 - 0.1 * t)); };
  const FunctionOfTime same = through(9, cubic);
  EXPECT_NEAR(same.start, 1.0, 1e-14);
  const auto off = [&](std::size_t n, bool curvature) {
    const FunctionOfTime f = through(n, [](double t) { return std::sin(t); });
    double most = 0.0;
    for (double t = 0.0; t < end; t += 0.01)
      most = std::max(most, curvature ? std::abs(f.motion.acceleration(t) + std::sin(t))
                                      : std::abs(f.motion.displacement(t) - std::sin(t)));
    return most;
  };
  for (double t = 0.0; t < end; t += 0.01) EXPECT_NEAR(same.motion.displacement(t), cubic(t) - 1.0, 1e-12);
  EXPECT_NEAR(std::log2(off(40, false) / off(80, false)), 4.0, 0.5);
  EXPECT_NEAR(std::log2(off(40, true) / off(80, true)), 2.0, 0.5);
  EXPECT_FALSE(same.motion.breaks(0.0, end));
}

// Between two samples it keeps between their values, and where they stay it stays, whatever jumps beside them.
TEST(Series, OfSamplesDoesNotSwingBesideAJump) {
  struct Samples {
    std::vector<double> t, y;
  };
  for (const Samples& samples :
       {Samples{{0, .5, 1, 1.001, 2, 2.5, 3}, {0, 0, 0, 1, 1, 1, 1}}, Samples{{0, .001, 1, 2, 3}, {0, 5, 5, 5, 5}},
        Samples{{0, 1, 2, 2.999, 3}, {2, 2, 2, 2, -1}}, Samples{{0, 1, 2, 3, 4, 5, 6}, {0, 0, 1, 1, 0, 0, 0}},
        Samples{{0, 1, 1.01, 2, 2.01, 3}, {0, 1, 11, 12, 2, 3}},
        Samples{{0, 1, 1.0001, 1.0002, 2, 3}, {0, 0, 1e6, 0, 0, 0}}}) {
    const FunctionOfTime f = spline(samples.t, samples.y);
    // Rounding of the polynomial pieces, whose coefficients are as large as the samples.
    const double rounding = 1e-14 * (1.0 + *std::ranges::max_element(samples.y));
    for (std::size_t i = 0; i + 1 < samples.t.size(); ++i)
      for (double s = 0.0; s <= 1.0; s += 1.0 / 64.0) {
        const auto [low, high] = std::minmax(samples.y[i], samples.y[i + 1]);
        const double value = f.start + f.motion.displacement(samples.t[i] + s * (samples.t[i + 1] - samples.t[i]));
        EXPECT_GE(value, low - rounding) << samples.y[1] << " " << i << " " << s;
        EXPECT_LE(value, high + rounding) << samples.y[1] << " " << i << " " << s;
      }
  }
}

// Steps of any height at any time, once among samples that are near, between others that are far: none leaves the range
// of its samples.
TEST(Series, OfRandomStepsKeepsToTheirRange) {
  std::mt19937_64 engine(1);
  const auto draw = [&] { return static_cast<double>(engine() >> 11) * 0x1p-53; };
  for (int k = 0; k < 300; ++k) {
    std::vector<double> t{0.0}, y{0.0};
    while (t.size() < 12) {
      t.push_back(t.back() + std::pow(10.0, -4.0 * draw()));
      y.push_back(draw() < 0.6 ? y.back() : y.back() + std::pow(10.0, 3.0 * draw()) * (draw() < 0.5 ? -1.0 : 1.0));
    }
    const FunctionOfTime f = spline(t, y);
    const auto [low, high] = std::ranges::minmax(y);
    for (double at = 0.0; at <= t.back(); at += t.back() / 997.0) {
      EXPECT_GE(f.start + f.motion.displacement(at), low - 1e-13 * (high - low)) << k << " " << at;
      EXPECT_LE(f.start + f.motion.displacement(at), high + 1e-13 * (high - low)) << k << " " << at;
    }
  }
}

// Its second derivative jumps where slopes are limited; a step ends there.
TEST(Series, HasABreakWhereItsSecondDerivativeJumps) {
  std::mt19937_64 engine(2);
  std::size_t found = 0;
  for (int k = 0; k < 100; ++k) {
    std::vector<double> t, y;
    for (int i = 0; i < 8; ++i) t.push_back(i), y.push_back(static_cast<double>(engine() >> 11) * 0x1p-53);
    const FunctionOfTime f = spline(t, y);
    for (int i = 1; i < 7; ++i) {
      const double before = f.motion.acceleration(i - 1e-9), after = f.motion.acceleration(i);
      if (std::abs(after - before) < 1e-4) continue;  // a slope of 1e4 or less, and the step of 1e-9
      ++found;
      EXPECT_EQ(f.motion.breaks(i - 0.5, i + 0.5), i) << k;
    }
  }
  EXPECT_GT(found, 50u);
}

/// A folder with a file record.csv, of a force in kN of time in ms.
class Records : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = std::filesystem::path(testing::TempDir()) /
              fmt::format("series_{}", testing::UnitTest::GetInstance()->current_test_info()->name());
    std::filesystem::create_directories(folder_);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  void write(const std::string& name, const std::string& text) const { std::ofstream(folder_ / name) << text; }
  SceneFile scene(const std::string& text, std::span<const std::string> settings = {}) const {
    return parse_scene(text, (folder_ / "scene.toml").string(), settings);
  }
  std::string refused(const std::string& text) const {
    try {
      scene(text);
    } catch (const SceneError& error) {
      return error.what();
    }
    return "";
  }

  std::filesystem::path folder_;
};

const std::string bar = "[bar]\nlength = 1\nviscosity = 0.05\n[time]\nend = 2\n[mesh]\nelements = 20\n";

std::string rows(std::size_t n, double last, auto&& f, const std::string& names = "time,F\n") {
  std::string text = names;
  for (std::size_t k = 0; k <= n; ++k) {
    const double t = last * static_cast<double>(k) / static_cast<double>(n);
    text += fmt::format("{:.17g},{:.17g}\n", t, f(t));
  }
  return text;
}

double apart(const Recording& a, const Recording& b) { return distance(a.u, b.u); }

TEST_F(Records, HaveTheirTimesInTheColumnThatTimeNames) {
  write("record.csv", rows(
                          16, 2.0, [](double t) { return t; }, "clock,F\n"));
  const auto left = [](const std::string& more) {
    return bar + "[left]\nkind = \"free\"\nforce = { file = \"record.csv\", column = \"F\", " + more + " }\n";
  };
  const Recording named = record(scene(left("time = \"clock\"")).run);
  EXPECT_EQ(named.u, record(scene(left("t = \"clock\"")).run).u);
  EXPECT_THROW(scene(left("time = \"clock\", t = \"clock\"")), SceneError);
  EXPECT_THROW(scene(bar + "[left]\nkind = \"free\"\nforce = { time = [0, 2], values = [0, 1] }\n"), SceneError);
}

// The spline is wrong by h^4, lines by h^2, and so is what they move.
TEST_F(Records, OfAForceMoveTheBarAsItsFormulaDoes) {
  const auto f = [](double t) { return 0.3 * std::sin(3.0 * t); };
  for (const std::string method : {"cvode", "ida", "arkode", "odeint", "rigid", "exponential", "characteristics"}) {
    const std::string rest = "[method]\nname = \"" + method + "\"\nrelative_tolerance = 1e-10\n" +
                             (method == "characteristics" ? "[units]\n" : "") + "[left]\nkind = \"free\"\n";
    const auto with = [&](const std::string& force) {
      std::vector<std::string> settings;
      if (method == "characteristics") settings.push_back("bar.viscosity=0");
      return record(scene(bar + rest + "force = " + force, settings).run);
    };
    const Recording exact = with("\"0.3*sin(3*t)\"");
    for (const auto& [kind, order] : {std::pair{"cubic", 4.0}, {"linear", 2.0}}) {
      double off[2];
      for (const std::size_t level : {0u, 1u}) {
        write(fmt::format("record{}.csv", level), rows(16 << level, 2.0, f));
        off[level] = apart(
            with(fmt::format("{{ file = \"record{}.csv\", column = \"F\", interpolation = \"{}\" }}", level, kind)),
            exact);
      }
      EXPECT_GT(std::log2(off[0] / off[1]), order - 0.5) << method << " " << kind << " " << off[0] << " " << off[1];
    }
  }
}

TEST_F(Records, HaveUnitsAScaleAndAnotherNameForTheirTimes) {
  write("record.txt", "zeit [ms];\"F [kN]\"\n-10;0,0\n0;1,5\n1000;2,5\n2000;0,5\n3000;0,5\n");
  const SceneFile read = scene(bar +
                               "[units]\nlength = \"m\"\ntime = \"s\"\nforce = \"N\"\nstress = \"N\"\n[left]\n"
                               "kind = \"free\"\nforce = { file = \"record.txt\", column = \"F\", t = \"zeit\", "
                               "interpolation = \"linear\" }\n[right]\nkind = \"free\"\n"
                               "force = { file = \"record.txt\", column = \"F\", t = \"zeit\", scale = 2.0 }\n");
  EXPECT_DOUBLE_EQ(read.run.scene.right_input.force->value(1.0), 5.0);
  const TimeFunction& force = read.run.scene.left_input.force->value;
  EXPECT_DOUBLE_EQ(force(0.0), 1500.0);
  EXPECT_DOUBLE_EQ(force(0.5), 2000.0);
  EXPECT_DOUBLE_EQ(force(1.5), 1500.0);
  EXPECT_DOUBLE_EQ(force(2.5), 500.0);
  const NextBreak& breaks = read.run.scene.left_input.force->breaks;
  EXPECT_EQ(breaks(0.0, 9.0), 1.0);
  EXPECT_EQ(breaks(1.0, 9.0), 2.0);
}

TEST(UnitRatio, IsThatOfProductsQuotientsAndPowers) {
  const auto ratio = [](const char* from, const char* to) { return unit_ratio(from, to).value(); };
  EXPECT_DOUBLE_EQ(ratio("kN", "N"), 1e3);
  EXPECT_DOUBLE_EQ(ratio("kN", "MPa mm^2"), 1e3);
  EXPECT_DOUBLE_EQ(ratio("N", "kg m/s^2"), 1.0);
  EXPECT_DOUBLE_EQ(ratio("t mm/ms^2", "MN"), 1.0);
  EXPECT_DOUBLE_EQ(ratio("Pa", "kg/(m s^2)"), 1.0);
  EXPECT_DOUBLE_EQ(ratio("MPa", "N/mm²"), 1.0);
  EXPECT_DOUBLE_EQ(ratio("m/s2", "mm s^-2"), 1e3);
  EXPECT_DOUBLE_EQ(ratio("µm/m", "%"), 1e-4);
  EXPECT_DOUBLE_EQ(ratio("\xb5m", "mm"), 1e-3);  // in Latin-1
  EXPECT_DOUBLE_EQ(ratio("N\xb7mm\xb2/s\xb3", "N m^2/s^3"), 1e-6);
  EXPECT_DOUBLE_EQ(ratio("km/h", "m/s"), 1.0 / 3.6);
  EXPECT_DOUBLE_EQ(ratio("1/ms", "1/s"), 1e3);
  EXPECT_DOUBLE_EQ(ratio("in", "mm"), 25.4);
  EXPECT_DOUBLE_EQ(ratio("lbf/in^2", "psi"), 1.0);
  EXPECT_DOUBLE_EQ(ratio("N*m", "kg m²/s²"), 1.0);
  for (const auto& [from, to] : {std::pair{"kN", "Pa"},
                                 {"m", "s"},
                                 {"V", "mV"},
                                 {"N/(m", "N/m"},
                                 {"m^", "m"},
                                 {"", "m"},
                                 {"m//s", "m/s"},
                                 {"m s^", "m s"},
                                 {"2", "1"},
                                 {"m)", "m"},
                                 {"m ", "m"}})
    EXPECT_FALSE(unit_ratio(from, to)) << from << " " << to;
}

// N = A s: a bar with a section takes a force, and one without a force per area.
TEST_F(Records, OfAForceHaveTheUnitOfTheWholeSection) {
  write("record.csv", "t [s],F [kN]\n0,0\n3,1\n");
  const std::string rest =
      "[units]\nlength = \"m\"\ntime = \"s\"\nstress = \"Pa\"\n[left]\nkind = \"free\"\n"
      "force = { file = \"record.csv\", column = \"F\", interpolation = \"linear\" }\n";
  std::string with = bar;
  with.insert(with.find("[time]"), "section = 1e-4\n");
  EXPECT_DOUBLE_EQ(scene(with + rest).run.scene.left_input.force->value(3.0), 1000.0);
  EXPECT_NE(refused(bar + rest).find("column F is in kN, and the scene's unit for it is Pa"), std::string::npos);
}

TEST_F(Records, AUnitThatTheSceneCannotPlaceIsRefusedAndNotPassedOver) {
  write("record.csv", "t [s],F [kN]\n0,0\n3,1\n");
  const std::string force =
      "[left]\nkind = \"free\"\nforce = { file = \"record.csv\", column = \"F\", interpolation = \"linear\" }\n";
  EXPECT_NE(refused(bar + "[units]\ntime = \"s\"\nforce = \"N\"\n" + force)
                .find("column F is in kN, and [units] of the scene does not say"),
            std::string::npos);
  EXPECT_EQ(refused(bar + force), "");  // a scene without units
}

// A free bar of mass 1 that is pushed for a thousandth of its run has the momentum of that push.
TEST_F(Records, WithAPulseInAQuietStretchAreNotPassedBy) {
  std::vector<double> t, y;
  for (int k = 0; k <= 4000; ++k) {
    t.push_back(0.0005 * k);
    const double s = (t.back() - 1.3) / 0.001;
    y.push_back(std::abs(s) < 1.0 ? 100.0 * (1.0 + std::cos(std::numbers::pi * s)) : 0.0);
  }
  std::string places = "", values = "";
  for (std::size_t k = 0; k < t.size(); ++k)
    places += fmt::format("{:.17g},", t[k]), values += fmt::format("{:.17g},", y[k]);
  for (const std::string kind : {"cubic", "linear"})
    for (const std::string method : {"cvode", "ida", "arkode", "odeint", "rigid"}) {
      const Recording run = record(
          scene(bar +
                fmt::format("[left]\nkind = \"free\"\nforce = {{ t = [{}], values = [{}], interpolation = \"{}\" }}\n"
                            "[method]\nname = \"{}\"\n",
                            places, values, kind, method))
              .run);
      // The rule of trapezia, exact for lines; the spline of four values a flank is off by a hundredth.
      double impulse = 0.0;
      for (std::size_t k = 0; k + 1 < t.size(); ++k) impulse += 0.5 * (t[k + 1] - t[k]) * (y[k] + y[k + 1]);
      double momentum = 0.0;
      const auto v = run.velocity(run.times.size() - 1);
      for (std::size_t j = 0; j + 1 < v.size(); ++j) momentum += 0.5 * (v[j] + v[j + 1]) / 20.0;
      EXPECT_NEAR(momentum, impulse, (kind == "cubic" ? 0.05 : 0.005) * impulse) << method << " " << kind;
    }
}

TEST_F(Records, MoveEndsAndObstaclesAndAreInitialData) {
  const auto d = [](double t) { return 0.05 * (1.0 - std::cos(4.0 * t)); };
  write("d.csv", rows(80, 2.0, d, "t,d\n"));
  write("gap.csv", rows(
                       80, 2.0, [&](double t) { return 0.1 - d(t); }, "t,gap\n"));
  write("u.csv", rows(
                     60, 1.0, [](double x) { return 0.1 * std::sin(2.0 * x); }, "x,u\n"));
  const std::string moved = "[method]\nname = \"rigid\"\nrelative_tolerance = 1e-9\n";
  const auto near = [&](const std::string& series, const std::string& formula) {
    const Recording a = record(scene(bar + moved + series).run), b = record(scene(bar + moved + formula).run);
    EXPECT_LT(apart(a, b), 1e-5) << series;
    EXPECT_EQ(a.events.size(), b.events.size()) << series;
  };
  near("[left]\nkind = \"fixed\"\nmotion = { file = \"d.csv\", column = \"d\" }",
       "[left]\nkind = \"fixed\"\nmotion = \"0.05*(1-cos(4*t))\"");
  const std::string thrown = "[initial]\nvelocity = -0.5\n[left]\nkind = \"obstacle\"\ngap = ";
  near(thrown + "{ file = \"gap.csv\", column = \"gap\" }", thrown + "\"0.1-0.05*(1-cos(4*t))\"");
  near("[initial]\ndisplacement = { file = \"u.csv\", column = \"u\" }", "[initial]\ndisplacement = \"0.1*sin(2*x)\"");
  near("[initial]\nvelocity = { file = \"u.csv\", column = \"u\", scale = -2.0 }",
       "[initial]\nvelocity = \"-0.2*sin(2*x)\"");
}

// Its load has a kink at each sample, which an error estimate may not see: where no step ends there, 150 samples leave
// 39 tolerances, 600 leave 66, and with them 4.9 and 4.2 (bar of 20 elements).
TEST_F(Records, OfAMotionLeaveNoErrorAtTheirSamples) {
  for (const std::size_t samples : {150u, 600u}) {
    write("d.csv", rows(
                       samples, 3.0, [](double t) { return 0.1 * (1.0 - std::cos(6.0 * t)); }, "t,d\n"));
    const auto by = [&](const std::string& method, double tolerance) {
      return record(
          scene(fmt::format("[bar]\nlength = 1\n[right]\nkind = \"fixed\"\nmotion = {{ file = \"d.csv\", column "
                            "= \"d\" }}\n[time]\nend = 3\n[mesh]\nelements = 20\nmass = \"consistent\"\n"
                            "[method]\nname = \"{}\"\nrelative_tolerance = {}\n",
                            method, tolerance))
              .run);
    };
    const Recording exact = by("arkode", 1e-13);
    for (const std::string method : {"odeint", "arkode"}) {
      const Recording run = by(method, 1e-9);
      double most = apart(run, exact);
      for (std::size_t k = 0; k < run.v.size(); ++k) most = std::max(most, std::abs(run.v[k] - exact.v[k]));
      EXPECT_LT(most, 1e-8) << method << " " << samples;
    }
  }
}

// Between a few values, far from even, too: the spline stays between them.
TEST(Series, OfTwoOrThreeValuesStaysBetweenThem) {
  for (const std::vector<double>& t :
       {std::vector<double>{0, 0.01, 1}, {0, 0.5, 1}, {0, 0.99, 1}, {0, 1e-12, 1}, {0, 1}}) {
    const std::vector<double> y = t.size() == 2 ? std::vector<double>{0, 1} : std::vector<double>{0, 1, 0};
    const Series series(t, y, Interpolation::cubic, Outside::goes_on);
    for (double at = 0.0; at <= 1.0; at += 1.0 / 512.0) {
      EXPECT_GE(series(at), -1e-12) << t[1] << " " << at;
      EXPECT_LE(series(at), 1.0 + 1e-12) << t[1] << " " << at;
    }
  }
}

// The schemes look a step beyond the end, where a series that ends there goes on.
TEST_F(Records, ThatEndWithTheRunAreTheFormulaToTheLastRow) {
  for (const std::string method : {"fully_discrete", "finite_difference"})
    for (const std::string table :
         {"[left]\nkind = \"fixed\"\nmotion = ", "[initial]\nvelocity = -0.5\n[left]\nkind = \"obstacle\"\ngap = "}) {
      const bool gap = table.ends_with("gap = ");
      const auto by = [&](const std::string& motion) {
        return record(scene(bar + table + motion + "\n[method]\nname = \"" + method + "\"\nstep = 1e-3\n").run);
      };
      const Recording formula = by(gap ? "\"0.3-0.1*t\"" : "\"-0.1*t\"");
      const Recording series = by(gap ? "{ t = [0, 2], values = [0.3, 0.1] }" : "{ t = [0, 2], values = [0, -0.2] }");
      EXPECT_LT(apart(series, formula), 1e-12) << method << gap;
      for (std::size_t k = 0; k < formula.v.size(); ++k) ASSERT_NEAR(series.v[k], formula.v[k], 1e-9) << method << gap;
    }
}

TEST_F(Records, AreRefusedWithWhatIsWrong) {
  write("record.csv", "t,F\n0,1\n1,2\n1,3\n2,0\n");
  const auto force = [&](const std::string& table) {
    return refused(bar + "[left]\nkind = \"free\"\nforce = " + table);
  };
  const auto expect = [&](const std::string& table, const std::string& words) {
    const std::string what = force(table);
    EXPECT_NE(what.find("left.force: "), std::string::npos) << table << ": " << what;
    EXPECT_NE(what.find(words), std::string::npos) << table << ": " << what;
  };
  const std::string linear = "interpolation = \"linear\"";
  EXPECT_EQ(force("{ file = \"record.csv\", column = \"F\", " + linear + " }"), "");
  expect("{ file = \"record.csv\", column = \"F\" }", "two values at t = 1: a jump");
  expect("{ file = \"none.csv\", column = \"F\" }", "none.csv");
  expect("{ file = \"record.csv\", column = \"Q\" }", "Q is missing; the columns are t, F");
  write("holes.csv", "t,F\n0,1\n1,nan\n1.5,\n2,0\n");
  expect("{ file = \"holes.csv\", column = \"F\" }",
         "holes.csv, line 3: f \"nan\" is no number, and the run needs one");
  expect("{ file = \"holes.csv\", column = \"F\" }", "holes.csv, line 4: f \"\" is no number");
  write("glued.csv", "t,F\n0,1\n1,2\n0,1\n1,2\n2,0\n");
  expect("{ file = \"glued.csv\", column = \"F\" }", "glued.csv, line 4: t must not decrease: 0 comes after 1");
  write("empty.csv", "");
  expect("{ file = \"empty.csv\", column = \"F\" }", "F is missing: the file has no values");
  expect("{ t = [0, 1], values = [0, 1], column = \"F\" }", "column is one of a file");
  expect("{ file = \"record.csv\" }", "a file and a column");
  expect("{ file = \"record.csv\", colum = \"F\" }", "nearest is \"column\"");
  expect("{ t = [0, 1], values = [1] }", "t has 2 numbers and values 1");
  expect("{ t = [1, 0], values = [1, 1] }", "must not decrease");
  expect("{ t = [0, 1], values = [1, 1] }", "has values from t = 0 to 1, and the run goes from 0 to 2; outside");
  expect("{ t = [0, 100, 300], values = [0, 1, 1] }",
         "has values up to t = 300, and the run ends at 2: are they in different units");
  EXPECT_EQ(force("{ t = [0, 100, 300], values = [0, 1, 1], outside = \"hold\" }"), "");
  expect("{ t = [0, 1], values = [1, 1], outside = \"none\" }", "outside cannot be \"none\"");
  EXPECT_EQ(force("{ t = [0, 1], values = [1, 1], outside = \"hold\" }"), "");
  EXPECT_NE(refused(bar + "[left]\nkind = \"fixed\"\nmotion = { t = [0, 2], values = [0, 1], outside = \"zero\" }")
                .find("the motion of a fixed end does not jump"),
            std::string::npos);
  EXPECT_NE(refused(bar + "[load]\ndensity = { t = [0, 2], values = [0, 1] }").find("of one variable"),
            std::string::npos);
  EXPECT_NE(
      refused(bar + "[left]\nkind = \"free\"\nstiffness = { t = [0, 2], values = [0, 1] }\n[initial]\nvelocity = 1\n")
          .find("must be a number, is a table"),
      std::string::npos);
}

TEST_F(Records, AreToldByTheirWholeNameAndHaveToBeAsTheyWere) {
  write("record.csv", "t,F\n0,1\n1,2\n2,0\n");
  const SceneFile read = scene(bar + "[left]\nkind = \"free\"\nforce = { file = \"record.csv\", column = \"F\" }\n");
  const std::string description = read.description();
  const SceneFile again = described_scene(description, "a checkpoint elsewhere");
  EXPECT_EQ(again.description(), description);
  EXPECT_EQ(record(again.run).u, record(read.run).u);
  EXPECT_EQ(scene(scene_text(read.values)).description(), description);
  write("record.csv", "t,F\n0,1\n1,2\n2,0.5\n");
  try {
    described_scene(description, "a checkpoint elsewhere");
    FAIL();
  } catch (const SceneError& error) {
    EXPECT_NE(std::string(error.what()).find("has changed since"), std::string::npos) << error.what();
  }
}

}  // namespace
}  // namespace viscobar::testing_series

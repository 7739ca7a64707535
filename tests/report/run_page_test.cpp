#include "report/run/run_page.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <regex>
#include <sstream>

#include "report/page_reader.hpp"
#include "support/scene_text.hpp"
#include "support/scratch.hpp"
#include "text/number.hpp"
#include "viscobar/record/record_run.hpp"

namespace viscobar {
namespace {

SceneFile free_bar() {
  SceneFile scene = bouncing_bar();
  scene.run.scene.left = Free{};
  scene.run.epsilon.reset();
  return scene;
}

// Tests in a browser, tests/browser, show that the scripts load nothing.
TEST(Report, NeedsNothingFromOutside) {
  const Html report = page(bouncing_bar());
  // The image itself apart, which is too long for std::regex.
  const std::string html = without_scripts(report.html);
  const std::size_t image = html.find("data:image/png"), end = html.find('"', image);
  ASSERT_NE(image, std::string::npos);
  const std::string text = html.substr(0, image + 5) + html.substr(end);
  EXPECT_FALSE(std::regex_search(text, std::regex(R"re((src|href)\s*=\s*"(?!data:)|@import|url\((?!#)|<link)re")));
  EXPECT_FALSE(std::regex_search(report.html.substr(0, report.html.find("</head>")), std::regex("<script")));
}

TEST(Report, CarriesTheDisplacementToAPartIn65535OfItsRange) {
  const SceneFile scene = bouncing_bar();
  const BarSystem system = resolve(scene.run).system();
  ReportData data(scene.run, system);
  std::vector<double> u(system.mesh().nodes()), v(u.size());
  const auto displacement = [](int k, std::size_t j) { return std::sin(0.7 * k + 0.3 * static_cast<double>(j)); };
  for (int k = 0; k < 5; ++k) {
    for (std::size_t j = 0; j < u.size(); ++j) u[j] = displacement(k, j);
    data.add(Snapshot{.time = 0.1 * k, .u = u, .v = v});
  }
  const auto field = nlohmann::json::parse(field_json(data.field, field_colours(scene.run, data)));
  const double low = field["low"], high = field["high"];
  // Base64 by its definition, four digits to three bytes.
  const std::string text = field["u"], digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::vector<unsigned> bytes;
  for (std::size_t i = 0; i + 3 < text.size(); i += 4) {
    unsigned group = 0;
    for (std::size_t k = 0; k < 4; ++k)
      group = group << 6 | (text[i + k] == '=' ? 0U : static_cast<unsigned>(digits.find(text[i + k])));
    for (const unsigned shift : {16U, 8U, 0U}) bytes.push_back(group >> shift & 0xff);
  }
  // Rounding to the nearest of 65535 steps, and the nine digits of the ends of the range.
  const double bound = 0.5 * (high - low) / 65535 + 1e-8;
  for (int k = 0; k < 5; ++k)
    for (std::size_t j = 0; j < u.size(); ++j) {
      const std::size_t at = 2 * (static_cast<std::size_t>(k) * u.size() + j);
      EXPECT_NEAR(low + (high - low) * (bytes[at] + 256 * bytes[at + 1]) / 65535, displacement(k, j), bound);
    }
}

TEST(Report, MarksEveryContactChangeOfAnOrdinaryRun) {
  const Html report = page(bouncing_bar());
  const nlohmann::json events = data_of(report)["events"];
  EXPECT_GE(events["happened"], 2);
  EXPECT_EQ(events["every"], 1);
  for (const char* column : {"t", "place", "closes", "velocity"})
    EXPECT_EQ(events[column].size(), events["happened"].get<std::size_t>()) << column;
  EXPECT_EQ(events["places"], nlohmann::json({"left"}));
}

/// Columns of a table by their names.
std::map<std::string, std::vector<std::string>> columns_of(const std::string& csv) {
  std::istringstream lines(csv);
  std::string line, cell;
  std::getline(lines, line);
  std::vector<std::string> names;
  for (std::istringstream head(line); std::getline(head, cell, ',');) names.push_back(cell);
  std::map<std::string, std::vector<std::string>> columns;
  while (std::getline(lines, line)) {
    std::istringstream row(line);
    for (const std::string& name : names) std::getline(row, cell, ','), columns[name].push_back(cell);
  }
  return columns;
}

// Numbers of the page have nine digits. A line in a picture is drawn to half of 1/1000 of a pixel, in a frame of 182
// whose axis is at most 2.2 times as long as the largest value: to 6.1e-6 of that.
TEST(Report, SaysWhatEventsAndSummarySayAndDrawsEachContactWithItsPeak) {
  const std::vector<std::pair<std::string, std::string>> two = {
      {"right.kind", "\"obstacle\""}, {"right.side", "\"above\""}, {"right.gap", "0.1"}, {"time.end", "4.0"}};
  const auto with = [](std::vector<std::pair<std::string, std::string>> all, const char* method,
                       std::vector<std::pair<std::string, std::string>> more) {
    all.emplace_back("method.name", std::string("\"") + method + "\"");
    all.insert(all.end(), more.begin(), more.end());
    return all;
  };
  const std::vector<std::pair<std::string, std::string>> span = {
      {"left.kind", "\"free\""}, {"span.gap", "0.1"}, {"initial.velocity", "\"-1-x/10\""}};
  std::vector<std::string> scenes;
  for (const char* method : {"rigid", "cvode", "characteristics", "fully_discrete", "exponential"})
    scenes.push_back(falling_bar_with(
        with(two, method, {{"bar.viscosity", std::string(method) == "characteristics" ? "0.0" : "0.05"}})));
  for (const char* method : {"arkode", "fully_discrete"}) {
    std::string text = falling_bar_with(with(span, method, {{"output.every", "0.05"}}));
    text.erase(text.find("left.gap"), text.find("initial") - text.find("left.gap"));
    scenes.push_back(text);
  }
  // Between two outputs, a chatter, and a bar that lies on its obstacle.
  scenes.push_back(falling_bar_with({{"output.every", "0.5"}, {"time.end", "3.0"}, {"method.name", "\"rigid\""}}));
  scenes.push_back(falling_bar_with({{"bar.viscosity", "0.003"},
                                     {"mesh.mass", "\"consistent\""},
                                     {"contact.epsilon", "1e-6"},
                                     {"time.end", "3.0"},
                                     {"method.name", "\"cvode\""}}));
  scenes.push_back(falling_bar_with({{"load.density", "-1"}, {"units.length", "\"m\""}, {"time.end", "3.0"}}));
  ASSERT_EQ(scenes.size(), 10u);
  std::size_t contacts = 0;
  for (const std::string& text : scenes) {
    SCOPED_TRACE(text);
    const Scratch scratch;
    record_run(parse_scene(text, "scene"), scratch.path());
    const Html report{read_text(scratch / "report.html")};
    const auto summary = nlohmann::json::parse(read_text(scratch / "summary.json"));
    auto events = columns_of(read_text(scratch / "events.csv"));
    const nlohmann::json data = data_of(report);
    EXPECT_TRUE(report.has("<dt>Whole run</dt><dd>" + readable(summary["wall_seconds"], 3) + " s</dd>"));
    EXPECT_EQ(report.has("Work done on the bar"), summary["scene"].contains("load"));
    EXPECT_FALSE(report.has("magnified by 0"));
    ASSERT_EQ(data["events"]["t"].size(), events["t"].size());
    for (std::size_t k = 0; k < events["t"].size(); ++k)
      EXPECT_NEAR(data["events"]["t"][k], std::stod(events["t"][k]), 1e-8);
    for (const std::string place : {"left", "right", "span"}) {
      if (!summary["contact"].contains(place)) continue;
      const nlohmann::json &support = data["supports"][place], &told = summary["contact"][place];
      const nlohmann::json &parts = support["contact"], &peaks = support["peaks"];
      ASSERT_EQ(parts.size(), peaks.size()) << place;
      double peak = 0.0, time = 0.0;
      for (std::size_t k = 0; k + 1 < parts.size(); k += 2, ++contacts) {
        EXPECT_GE(peaks[k], parts[k].get<double>() - 1e-8);
        EXPECT_LE(peaks[k], parts[k + 1].get<double>() + 1e-8);
        peak = std::max(peak, std::abs(peaks[k + 1].get<double>()));
        time += parts[k + 1].get<double>() - parts[k].get<double>();
      }
      if (place != "span") {
        EXPECT_EQ(parts.size() / 2, told["closings"]);
      }
      const double most = told["max_reaction"];
      EXPECT_NEAR(peak, most, 1e-8 * most) << place;
      EXPECT_NEAR(time, told["time_in_contact"], 1e-8 * static_cast<double>(parts.size() + 1)) << place;
      EXPECT_NEAR(largest_of(report, "reactions", place == "span" ? place : place + " end"), most, 1e-5 * most);
      // The contact row of an end without mass, or held without a spring: its stress is the reaction.
      if (place == "left" && (summary["method"] == "rigid" || summary["method"] == "characteristics")) {
        EXPECT_GE(largest_of(report, "end-stress", "s(0, t)"), most * (1.0 - 1e-5));
      }
    }
  }
  EXPECT_GT(contacts, 100u) << "with the chatter's";
}

TEST(Report, ShowsWhatTheSceneHas) {
  const Html report = page(bouncing_bar());
  for (const char* heading :
       {"Displacement over space and time", "The bar", "Ends", "Reactions", "Energy", "Contact changes"})
    EXPECT_TRUE(report.has(std::string("<h2>") + heading)) << heading;
  EXPECT_TRUE(report.has("in contact"));
  EXPECT_TRUE(report.has("contact springs"));
  EXPECT_TRUE(report.has("A &lt;bounce&gt; &amp; back"));
}

// The spring of epsilon = 1e-3 stops the mass of a node; a massless one on an undamped bar answers with E V / c.
TEST(Report, SaysWhereThePeakOfAnImpactHasNoLimit) {
  SceneFile scene = bouncing_bar();
  const char* words = "Peak reaction: the peak of an impact has no limit";
  EXPECT_TRUE(page(scene).has(words));
  scene.run.scene.bar.viscosity = 0.0;
  scene.run.mass = Mass::redistributed;
  scene.run.method = MethodName::ida;
  EXPECT_FALSE(page(scene).has(words));
  EXPECT_TRUE(page(scene).has("peak reaction"));
}

TEST(Report, LeavesOutWhatTheSceneDoesNotHave) {
  const Html report = page(free_bar());
  EXPECT_TRUE(report.has("<h2>Ends"));
  for (const char* absent :
       {"<h2>Reactions", "in contact", "contact springs", "<h2>Contact", "penetration", "obstacle"})
    EXPECT_FALSE(report.has(absent)) << absent;
}

TEST(Report, AFixedEndHasNoTrace) {
  SceneFile scene = bouncing_bar();
  scene.run.scene.right = Fixed{};
  const Html report = page(scene);
  EXPECT_TRUE(report.has("u(0, t)"));
  EXPECT_FALSE(report.has("u(L, t)"));
}

TEST(Report, MarksContactUnderASpan) {
  SceneFile scene = free_bar();
  scene.run.epsilon = 1e-3;
  scene.run.scene.span = Obstacle{0.1};
  const Html report = page(scene);
  EXPECT_TRUE(report.has("in contact"));
  EXPECT_TRUE(report.has("under the whole span"));
  EXPECT_TRUE(report.has("span, its nodes together"));
}

// Fed with snapshots and events, not computed: 10^6 output times of 60 nodes, 10^5 contact changes; and 10^5 elements.
TEST(Report, OfAVeryLongRunStaysBelowTwoMegabytesAndSaysWhatItThinned) {
  SceneFile scene = bouncing_bar();
  scene.run.scene.right = Obstacle{0.1};
  scene.run.elements = 60;
  const BarSystem system = resolve(scene.run).system();
  ReportData data(scene.run, system);
  Outcome outcome;
  std::vector<double> u(system.mesh().nodes()), v(u.size(), 1.0);
  constexpr int count = 1'000'000;
  for (int k = 0; k < count; ++k) {
    std::fill(u.begin(), u.end(), std::sin(1e-3 * k) + std::sin(0.77 * k));
    data.add(Snapshot{
        .time = 1e-6 * k, .u = u, .v = v, .reaction_left = std::sin(0.9 * k), .reaction_right = std::cos(0.8 * k)});
    if (k % 10 == 0) {
      const Event event{1e-6 * k, k % 40 < 20 ? Where::left : Where::right, 0,
                        k % 20 ? Change::opening : Change::closing, k == 700'000 ? -9.0 : -1.0};
      data.add(event);
      ++outcome.events;
    }
  }
  const Html report{report_page(resolve(scene.run), system, outcome, data).html()};
  EXPECT_LT(report.html.size(), 2'000'000u);
  const nlohmann::json events = data_of(report)["events"];
  EXPECT_EQ(events["happened"], count / 10);
  EXPECT_LE(events["t"].size(), 2000u);
  EXPECT_EQ(events["every"], 64);
  // The fastest of all is among those kept, at its own time.
  const auto fastest = std::find(events["velocity"].begin(), events["velocity"].end(), -9.0);
  ASSERT_NE(fastest, events["velocity"].end());
  EXPECT_EQ(events["t"][static_cast<std::size_t>(fastest - events["velocity"].begin())], 0.7);
}

TEST(Report, OfAVeryFineMeshStaysBelowTwoMegabytesAndSaysWhatItThinned) {
  SceneFile scene = bouncing_bar();
  scene.run.elements = 100'000;
  const BarSystem system = resolve(scene.run).system();
  ReportData data(scene.run, system);
  std::vector<double> u(system.mesh().nodes()), v(u.size(), 1.0);
  for (int k = 0; k < 500; ++k) {
    for (std::size_t j = 0; j < u.size(); ++j) u[j] = 1e-3 * k * static_cast<double>(j % 1000);
    data.add(Snapshot{.time = 1e-2 * k, .u = u, .v = v});
  }
  const Html report{report_page(resolve(scene.run), system, {}, data).html()};
  EXPECT_LT(report.html.size(), 2'000'000u);
  EXPECT_TRUE(report.has("every 2nd output time and every 250th node"));
}

TEST(Report, ListsTheFirstFiftyChangesAndCountsTheRest) {
  const SceneFile scene = bouncing_bar();
  const BarSystem system = resolve(scene.run).system();
  ReportData data(scene.run, system);
  Outcome outcome;
  for (int i = 0; i < 1000; ++i) {
    data.add({0.001 * i, Where::left, 0, i % 2 ? Change::opening : Change::closing, 0.0});
    ++outcome.events;
  }
  const std::string html = report_page(resolve(scene.run), system, outcome, data).html();
  EXPECT_NE(html.find("and 950 more"), std::string::npos);
}

TEST(Report, ARunThatNeverBeganHasAPageWithoutPictures) {
  const SceneFile scene = bouncing_bar();
  const BarSystem system = resolve(scene.run).system();
  Outcome outcome;
  outcome.ending = Ending::failed;
  outcome.error = "no step";
  const std::string html = report_page(resolve(scene.run), system, outcome, ReportData(scene.run, system)).html();
  EXPECT_NE(html.find("no step"), std::string::npos);
  EXPECT_EQ(html.find("<svg"), std::string::npos);
  EXPECT_EQ(html.find("<script"), std::string::npos);
}

TEST(Report, WritesItsFiguresOnlyWhenAskedTo) {
  const Scratch scratch;
  record_run(bouncing_bar(), scratch.path());
  EXPECT_FALSE(std::filesystem::exists(scratch / "figures"));
  RecordOptions options;
  options.figures = true;
  record_run(bouncing_bar(), scratch.path(), options);
  for (const char* name : {"bar", "displacement", "left-end", "right-end", "reactions", "energy"})
    EXPECT_TRUE(read_text(scratch / ("figures/" + std::string(name) + ".svg")).ends_with("</svg>\n")) << name;
}

TEST(Report, AMotionlessBarHasAPage) {
  SceneFile scene = free_bar();
  scene.run.scene.velocity = [](double) { return 0.0; };
  const Html report = page(scene);
  EXPECT_TRUE(report.has("<h2>Energy"));
  EXPECT_FALSE(report.has("nan"));
  EXPECT_FALSE(report.has("inf,"));
}

}  // namespace
}  // namespace viscobar

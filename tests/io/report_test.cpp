#include "io/report.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <regex>

#include "io/scratch.hpp"

namespace viscobar {
namespace {

struct Page {
  std::string html;
  bool has(const std::string& text) const { return html.find(text) != std::string::npos; }
};

Page page(const SceneFile& scene) {
  const Scratch scratch;
  record_run(scene, scratch.path());
  return {read_text(scratch / "report.html")};
}

SceneFile free_bar() {
  SceneFile scene = bouncing_bar();
  scene.run.scene.left = Free{};
  scene.run.epsilon.reset();
  return scene;
}

TEST(Report, NeedsNothingFromOutside) {
  const Page report = page(bouncing_bar());
  // The image itself apart, which is too long for std::regex.
  const std::size_t image = report.html.find("data:image/png"), end = report.html.find('"', image);
  ASSERT_NE(image, std::string::npos);
  const std::string text = report.html.substr(0, image + 5) + report.html.substr(end);
  EXPECT_FALSE(
      std::regex_search(text, std::regex(R"re((src|href)\s*=\s*"(?!data:)|@import|url\((?!#)|<script|<link)re")));
  EXPECT_FALSE(report.has("http:"));
  EXPECT_FALSE(report.has("https:"));
}

TEST(Report, ShowsWhatTheSceneHas) {
  const Page report = page(bouncing_bar());
  for (const char* heading :
       {"Displacement over space and time", "Profiles", "Ends", "Reactions", "Energy", "Contact changes"})
    EXPECT_TRUE(report.has(std::string("<h2>") + heading)) << heading;
  EXPECT_TRUE(report.has("in contact"));
  EXPECT_TRUE(report.has("contact springs"));
  EXPECT_TRUE(report.has("A &lt;bounce&gt; &amp; back"));
}

TEST(Report, LeavesOutWhatTheSceneDoesNotHave) {
  const Page report = page(free_bar());
  EXPECT_TRUE(report.has("<h2>Ends"));
  for (const char* absent :
       {"<h2>Reactions", "in contact", "contact springs", "<h2>Contact", "penetration", "obstacle"})
    EXPECT_FALSE(report.has(absent)) << absent;
}

TEST(Report, AFixedEndHasNoTrace) {
  SceneFile scene = bouncing_bar();
  scene.run.scene.right = Fixed{};
  const Page report = page(scene);
  EXPECT_TRUE(report.has("u(0, t)"));
  EXPECT_FALSE(report.has("u(L, t)"));
}

TEST(Report, MarksContactUnderASpan) {
  SceneFile scene = free_bar();
  scene.run.epsilon = 1e-3;
  scene.run.scene.span = Obstacle{0.1};
  const Page report = page(scene);
  EXPECT_TRUE(report.has("in contact"));
  EXPECT_TRUE(report.has("under the whole span"));
  EXPECT_TRUE(report.has("Under the span: nodes closed"));
}

TEST(Report, OfALongRunStaysSmallAndSaysWhatItThinned) {
  SceneFile scene = bouncing_bar();
  scene.run.elements = 1000;
  scene.run.scene.displacement = [](double x) { return 0.01 * std::sin(40 * x); };
  scene.run.output_every = 1e-4;
  const Page report = page(scene);
  EXPECT_LT(report.html.size(), 1u << 20);
  EXPECT_TRUE(report.has("every 32nd output time and every 3rd node"));
}

TEST(Report, ListsTheFirstFiftyChangesAndCountsTheRest) {
  const SceneFile scene = bouncing_bar();
  const BarSystem system = make_system(scene.run);
  ReportData data(scene.run, system);
  ContactSummary contact(scene.run.scene);
  Outcome outcome;
  for (int i = 0; i < 1000; ++i) {
    data.add({0.001 * i, Where::left, 0, i % 2 ? Change::opening : Change::closing, 0.0});
    ++outcome.events;
  }
  const std::string html = report_html(scene.run, system, outcome, contact, data);
  EXPECT_NE(html.find("and 950 more"), std::string::npos);
}

TEST(Report, ARunThatNeverBeganHasAPageWithoutPictures) {
  const SceneFile scene = bouncing_bar();
  const BarSystem system = make_system(scene.run);
  Outcome outcome;
  outcome.ending = Ending::failed;
  outcome.error = "no step";
  const std::string html =
      report_html(scene.run, system, outcome, ContactSummary(scene.run.scene), ReportData(scene.run, system));
  EXPECT_NE(html.find("no step"), std::string::npos);
  EXPECT_EQ(html.find("<svg"), std::string::npos);
}

TEST(Report, AMotionlessBarHasAPage) {
  SceneFile scene = free_bar();
  scene.run.scene.velocity = [](double) { return 0.0; };
  const Page report = page(scene);
  EXPECT_TRUE(report.has("<h2>Energy"));
  EXPECT_FALSE(report.has("nan"));
  EXPECT_FALSE(report.has("inf,"));
}

}  // namespace
}  // namespace viscobar

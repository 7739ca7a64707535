#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "report/compare/compare_tables.hpp"
#include "viscobar/case/recording.hpp"
#include "viscobar/input/scene_file.hpp"
#include "viscobar/report/reports.hpp"

namespace viscobar {
namespace {

// A bar at rest whose left end is said to be in contact for half a unit of time from each of these times on.
Solver in_contact(std::vector<double> closings) {
  return [closings](const Case& run) {
    Recording recording;
    recording.mesh = run.mesh();
    recording.times = run.output_times();
    recording.u.assign(recording.times.size() * recording.mesh.nodes(), 0.0);
    for (const double t : closings) {
      recording.events.push_back({t, Where::left, 0, Change::closing, -1.0});
      recording.events.push_back({t + 0.5, Where::left, 0, Change::opening, 1.0});
    }
    return recording;
  };
}

Case ten_units() {
  Case run;
  run.elements = 2;
  run.end = 10.0;
  return run;
}

TEST(ContactTable, AMissedContactDoesNotShiftTheRowsOfTheLaterOnes) {
  const Contender contenders[] = {{"all", ten_units(), in_contact({1, 3, 5, 7})},
                                  {"some", ten_units(), in_contact({1, 5.1, 7, 9})}};
  const Table table = contact_table(compare(contenders), NumberText::terminal());
  std::vector<std::pair<std::string, std::string>> found;
  for (const auto& row : table.rows) found.emplace_back(row[1], row[2]);
  const std::vector<std::pair<std::string, std::string>> expected = {{"all", "1"},  {"some", "1"},   {"all", "3"},
                                                                     {"all", "5"},  {"some", "5.1"}, {"all", "7"},
                                                                     {"some", "7"}, {"some", "9"}};
  EXPECT_EQ(found, expected);
}

// A scheme need not tell the closing of a contact that its scene begins with, nor reactions.
TEST(ContactPicture, DrawsAContactThatIsClosedFromTheStartOn) {
  const SceneFile scene = parse_scene(
      "[bar]\nlength = 1.0\n[initial]\nvelocity = -1.0\n[left]\nkind = \"obstacle\"\ngap = 0.0\n[right]\nkind = \"free\"\n[mesh]\nelements = 2\n"
      "[time]\nend = 10.0\n",
      "scene");
  const Solver untold = [](const Case& run) {
    Recording recording = in_contact({0.0})(run);
    recording.events.erase(recording.events.begin());
    return recording;
  };
  const Contender contenders[] = {{"told", scene.run, in_contact({0.0})}, {"untold", scene.run, untold}};
  const PicturedPage page = compare_report(scene, {}, compare(contenders)).page;
  const std::string& figure = std::ranges::find(page.figures, "contact-left", &FigureFile::name)->svg;
  std::vector<std::string> widths;
  for (const std::string name : {"told", "untold"}) {
    const std::string key = "data-key=\"" + name + "\" d=\"M";
    const std::size_t at = figure.find(key);
    ASSERT_NE(at, figure.npos) << name;
    const std::string box = figure.substr(at + key.size(), figure.find('v', at) - at - key.size());
    widths.push_back(box.substr(0, box.find(' ')) + box.substr(box.find('h')));
  }
  EXPECT_EQ(widths[0], widths[1]);
}

TEST(ContactPicture, DrawsTheContactsOfEachJoint) {
  const SceneFile scene = parse_scene(
      "[[bar]]\nlength = 0.5\nviscosity = 0.05\nvelocity = 1.0\n[[bar]]\nlength = 0.7\nviscosity = 0.05\n[[bar]]\nmass = 0.2\n"
      "[[joint]]\nkind = \"contact\"\ngap = 0.05\n[[joint]]\nkind = \"contact\"\n[left]\nkind = \"free\"\n[right]\nkind = \"free\"\n"
      "[time]\nend = 1.0\n[method]\nname = \"rigid\"\n",
      "scene");
  const auto run = [](const Case& of) { return record(of); };
  const Contender contenders[] = {{"one", scene.run, run}, {"other", scene.run, run}};
  const PicturedPage page = compare_report(scene, {}, compare(contenders)).page;
  for (const char* name : {"contact-joint-1", "contact-joint-2"}) {
    const auto figure = std::ranges::find(page.figures, name, &FigureFile::name);
    ASSERT_NE(figure, page.figures.end()) << name;
    for (const char* method : {"one", "other"})
      EXPECT_NE(figure->svg.find(fmt::format("data-key=\"{}\" d=\"M", method)), std::string::npos) << name << method;
  }
}

TEST(OrderText, GivesTheOrderBetweenTwoLevelsAndOfAll) {
  OrderStudy study;
  study.rows = {{10, std::nullopt, {4e-2, 0.0, 1e-2, 0.0}}, {20, std::nullopt, {1e-2, 0.0, 5e-3, 0.0}}};
  study.displacement_l2 = SequenceOrder{{2.0, 0.0}, 0.01, 0, 1};
  const std::string text = order_text(study);
  EXPECT_NE(text.find("      20     -   0.01   2.00      0.005   1.00"), std::string::npos) << text;
  EXPECT_NE(text.find("order of u in L2: 2.00 +- 0.01"), std::string::npos) << text;
  EXPECT_NE(text.find("order of the end traces: not settled"), std::string::npos) << text;
  EXPECT_EQ(text.find("v in L2:"), std::string::npos) << "no errors of it are there: " << text;
}

}  // namespace
}  // namespace viscobar

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <regex>

#include "report/page_reader.hpp"
#include "support/scene_text.hpp"

namespace viscobar {
namespace {

const std::string bar = "[[bar]]\nlength = 1.0\nvelocity = ";
const std::string contact = "[[joint]]\nkind = \"contact\"\ngap = 0.05\n";

std::string end_of(double time, double every, const std::string& method = "rigid") {
  return fmt::format("[time]\nend = {}\n[output]\nevery = {}\n[method]\nname = \"{}\"\n", time, every, method);
}

std::size_t count(const std::string& text, const std::string& pattern) {
  const std::regex regex(pattern);
  return static_cast<std::size_t>(
      std::distance(std::sregex_iterator(text.begin(), text.end(), regex), std::sregex_iterator()));
}

// Equal elastic bars: N = Z v / 2 = 0.5 for 2 L/c = 2 from t = 0.05 on, whose impulse is the momentum of the first.
TEST(Report, HasForcesAndContactsOfJointsAndAStripABar) {
  const std::string end = "[time]\nend = 3.0\n[output]\nevery = 0.01\n";
  const Html report =
      page(parse_scene(bar + "1.0\n" + bar + "0.0\n[[joint]]\nkind = \"contact\"\ngap = 0.05\n" + end, "scene"));
  EXPECT_TRUE(report.has("Forces at joints over time"));
  EXPECT_TRUE(report.has(">joint 1</td><td>1</td><td>2</td><td>1</td><td>0.5</td>"));
  EXPECT_TRUE(report.has("data-level=\"1\""));
  const Html bonded = page(parse_scene(bar + "1.0\n" + bar + "0.0\n" + end, "scene"));
  EXPECT_FALSE(bonded.has("Forces at joints"));
}

// The bars meet at elements of 0.1; the smallest, of 0.2 / 20, are behind a bond, far from every contact.
TEST(Report, TellsTheSmallestElementOfBarsInLineWithoutAPlace) {
  const std::string line = bar + "1.0\nelements = 10\n" + bar + "0.0\nelements = 10\n";
  const std::string last = "[[bar]]\nlength = 0.2\nelements = 20\n";
  const Html report = page(parse_scene(line + last + contact + end_of(0.5, 0.1), "scene"));
  EXPECT_TRUE(report.has("<dd>40 <small>h = 0.055 on average, 0.01 the least"));
  EXPECT_FALSE(report.has("at the contacts"));
}

// Drawn as the reactions of ends are: the tolerances of
// Report.SaysWhatEventsAndSummarySayAndDrawsEachContactWithItsPeak. The first bar leaves the second for good after 2
// L/c, between two output times.
TEST(Report, DrawsEachContactOfAJointWithItsPeak) {
  for (const std::string method : {"rigid", "cvode", "fully_discrete", "characteristics", "exponential"}) {
    SCOPED_TRACE(method);
    const std::string viscosity = method == "characteristics" ? "" : "viscosity = 0.02\n";
    const std::string scene =
        bar + "1.0\n" + viscosity + bar + "0.0\n" + viscosity + contact + end_of(3.0, 0.45, method);
    const Scratch scratch;
    record_run(parse_scene(scene, "scene"), scratch.path());
    const Html report{read_text(scratch / "report.html")};
    const auto told = nlohmann::json::parse(read_text(scratch / "summary.json"))["contact"]["joint:1"];
    const nlohmann::json joint = data_of(report)["axial"]["joints"][0];
    const nlohmann::json &parts = joint["contact"], &peaks = joint["peaks"];
    ASSERT_EQ(parts.size(), 2 * told["closings"].get<std::size_t>());
    ASSERT_EQ(peaks.size(), parts.size());
    double peak = 0.0, time = 0.0;
    for (std::size_t k = 0; k + 1 < parts.size(); k += 2) {
      EXPECT_GE(peaks[k], parts[k].get<double>() - 1e-8);
      EXPECT_LE(peaks[k], parts[k + 1].get<double>() + 1e-8);
      peak = std::max(peak, peaks[k + 1].get<double>());
      time += parts[k + 1].get<double>() - parts[k].get<double>();
    }
    const double most = told["max_reaction"];
    EXPECT_GT(most, 0.0);
    EXPECT_NEAR(peak, most, 1e-8 * most);
    EXPECT_NEAR(time, told["time_in_contact"], 1e-8 * static_cast<double>(parts.size() + 1));
    EXPECT_NEAR(largest_of(report, "joints", "joint 1"), most, 1e-5 * most);
  }
}

// At each of the six times: a strip for each bar, a block for each rigid body, a stroke for each joint.
TEST(Report, DrawsMembersApartAndRigidBodiesAsBlocks) {
  const std::string ram = "[[bar]]\nmass = 2.0\nvelocity = 1.0\n";
  const Html report = page(parse_scene(ram + bar + "0.0\n" + bar + "0.0\n" + contact + end_of(0.5, 0.05), "scene"));
  const std::string svg = between(report.html, "data-picture=\"axial\"", "<svg ", "<g class=\"legend\">");
  EXPECT_EQ(count(svg, "class=\"solid rigid\""), 6u);
  EXPECT_EQ(count(svg, "class=\"solid\""), 12u);
  EXPECT_EQ(count(svg, "class=\"joint\""), 12u);
  // At the start the face of the ram and that of the bar are the gap apart, magnified as displacements are.
  const nlohmann::json axial = data_of(report)["axial"];
  const double block = axial["block"], shift = axial["members"][1]["shift"], magnification = axial["magnification"];
  EXPECT_DOUBLE_EQ(axial["members"][0]["shift"].get<double>(), -block);
  EXPECT_NEAR(shift, 0.05 * magnification, 1e-9);
  EXPECT_FALSE(axial["members"][0].contains("elements"));
}

// The cap is bonded to the bar before it and parts from the next one.
TEST(Report, ShiftsWhatIsBehindARigidBodyInTheMiddle) {
  const Html report = page(parse_scene(
      bar + "1.0\n[[bar]]\nmass = 0.3\n" + bar + "0.0\n[[joint]]\nkind = \"bonded\"\n" + contact + end_of(0.5, 0.05),
      "scene"));
  const nlohmann::json axial = data_of(report)["axial"], &members = axial["members"];
  EXPECT_EQ(members[1]["nodes"][0], members[0]["nodes"][1]);
  EXPECT_EQ(members[1]["nodes"][0], members[1]["nodes"][1]);
  EXPECT_EQ(members[2]["nodes"][0].get<int>(), members[1]["nodes"][1].get<int>() + 1);
  EXPECT_EQ(members[1]["shift"], 0.0);
  EXPECT_NEAR(members[2]["shift"].get<double>(),
              axial["block"].get<double>() + 0.05 * axial["magnification"].get<double>(), 1e-9);
}

TEST(Report, HasUnitsWhereTheSceneNamesThem) {
  const std::string units = "[units]\nlength = \"m\"\ntime = \"s\"\nmass = \"kg\"\n";
  const Html report = page(parse_scene(units + bar + "1.0\n" + bar + "0.0\n" + contact + end_of(0.5, 0.05), "scene"));
  EXPECT_TRUE(report.has("<i>ρ</i> = 1\u00a0kg/m³"));
  EXPECT_TRUE(report.has("over a gap of 0.05\u00a0m"));
  EXPECT_EQ(data_of(report)["units"]["velocity"], "m/s");
  EXPECT_TRUE(report.has("data-unit=\"m\""));
}

}  // namespace
}  // namespace viscobar

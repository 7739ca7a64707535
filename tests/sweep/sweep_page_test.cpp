#include "sweep/sweep_page.hpp"

#include <gtest/gtest.h>

#include "results/json.hpp"
#include "support/scene_text.hpp"
#include "support/scratch.hpp"

namespace viscobar {
namespace {

SweepFile two_keys(const Scratch& scratch) {
  std::ofstream(scratch / "falling.toml") << falling_bar_with({{"mesh.elements", "5"}});
  return parse_sweep(
      "title = 'Two <keys>'\nscene = 'falling.toml'\n[set]\ntime.end = 0.5\n[vary]\nleft.gap = [0.1, 0.2, 0.9]\n"
      "mesh.mass = ['lumped', 'consistent']\n",
      scratch / "sweep.toml");
}

struct Swept {
  std::vector<SweepRow> rows;
  std::vector<const SweepRow*> pointers;
};

Swept swept(const SweepFile& sweep) {
  Swept all;
  for (std::size_t i = 0; i < sweep.plan.size(); ++i)
    all.rows.push_back(run_case(sweep.scene_text, case_of(sweep, i)).value());
  for (const SweepRow& row : all.rows) all.pointers.push_back(&row);
  return all;
}

Json data_of(const std::string& page) {
  const std::string begin = "id=\"data\">";
  const std::size_t at = page.find(begin) + begin.size();
  return Json::parse(page.substr(at, page.find("</script>", at) - at))["sweep"];
}

TEST(SweepPage, HasEveryCaseWithTheNumbersOfItsRow) {
  const Scratch scratch;
  const SweepFile sweep = two_keys(scratch);
  const Swept all = swept(sweep);
  const std::string page = sweep_page(sweep, all.pointers);
  EXPECT_NE(page.find("Two &lt;keys&gt;"), std::string::npos);
  const Json data = data_of(page);
  ASSERT_EQ(data["keys"].size(), 2u);
  EXPECT_EQ(data["keys"][0]["values"], (Json{0.1, 0.2, 0.9}));
  EXPECT_EQ(data["choice"], (Json{{0, 0}, {0, 1}, {1, 0}, {1, 1}, {2, 0}, {2, 1}}));
  bool found = false;
  for (const Json& column : data["columns"]) {
    ASSERT_EQ(column["values"].size(), 6u);
    if (column["name"] != "u_left_min") continue;
    found = true;
    for (std::size_t row = 0; row < 6; ++row)
      EXPECT_NEAR(column["values"][row], all.rows[row][Quantity::u_left_min], 1e-6);  // seven digits
  }
  EXPECT_TRUE(found);
}

TEST(SweepPage, LeavesOutColumnsThatAreTheSameInAllCases) {
  const Scratch scratch;
  const SweepFile sweep = two_keys(scratch);
  const Swept all = swept(sweep);
  const Json data = data_of(sweep_page(sweep, all.pointers));
  for (const Json& column : data["columns"]) EXPECT_NE(column["name"], "reached_time");
}

TEST(SweepPage, OfFailedCasesTellsTheError) {
  const Scratch scratch;
  const SweepFile sweep = two_keys(scratch);
  Swept all = swept(sweep);
  all.rows[3].completed = false;
  all.rows[3].error = "gave \"up\"";
  EXPECT_EQ(data_of(sweep_page(sweep, all.pointers))["errors"], (Json{{"3", "gave \"up\""}}));
}

TEST(SweepTextTable, HasTheKeysAndTheColumnsThatDiffer) {
  const Scratch scratch;
  const SweepFile sweep = two_keys(scratch);
  const Swept all = swept(sweep);
  const Table table = sweep_text_table(sweep, all.pointers, 4, NumberText::For::terminal);
  ASSERT_EQ(table.rows.size(), 4u);
  EXPECT_EQ(table.header[1], "left.gap");
  EXPECT_EQ(table.rows[2][1], "0.2");
  EXPECT_EQ(table.rows[3][2], "consistent");
  EXPECT_GT(table.header.size(), 4u);
  EXPECT_LE(table.header.size(), 8u) << "for a terminal";
}

}  // namespace
}  // namespace viscobar

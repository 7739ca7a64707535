#include "report/columns.hpp"

#include <gtest/gtest.h>

#include "report/limit/limit_tables.hpp"
#include "viscobar/report/reports.hpp"

namespace viscobar {
namespace {

struct Row {
  std::string word;
  std::size_t count;
  double number;
  std::optional<double> perhaps;
};

std::vector<Column<Row>> columns() {
  return {column("word", "a word", &Row::word),
          {"count", "how many", [](const Row& row) { return cell(row.count); },
           [](const Row& row, const NumberText&) { return fmt::format("{} of 9", row.count); }},
          column("number", "number", &Row::number),
          column("perhaps", "perhaps", &Row::perhaps, true),
          {"null", "null", [](const Row&) { return Cell(); }}};
}

const std::vector<Row> rows = {{"plain", 3, 0.1, {}}, {"with, a \"comma\"", 0, 1.0 / 3.0, {}}};

TEST(Columns, CsvHasAllDigitsAndQuotesWhatNeedsThem) {
  EXPECT_EQ(csv_of(columns(), rows),
            "word,count,number,perhaps,null\nplain,3,0.1,,\n\"with, a \"\"comma\"\"\",0,0.3333333333333333,,\n");
}

TEST(Columns, JsonLeavesOutWhatIsOptionalAndAbsentAndSaysNullOtherwise) {
  EXPECT_EQ(json_of(columns(), rows[0]).dump(), R"({"word":"plain","count":3,"number":0.1,"null":null})");
  EXPECT_EQ(json_of(columns(), Row{"", 1, 2.0, 0.5}).dump(),
            R"({"word":null,"count":1,"number":2.0,"perhaps":0.5,"null":null})");
}

TEST(Columns, ATableHasAFewDigitsAndNoColumnThatNoRowHas) {
  const Table table = table_of(columns(), rows, NumberText::terminal(), 1);
  EXPECT_EQ(table.header, (std::vector<std::string>{"a word", "how many", "number", "null"}));
  EXPECT_EQ(table.rows[0], (std::vector<std::string>{"plain", "3 of 9", "0.1", ""}));
  EXPECT_EQ(table.rows[1], (std::vector<std::string>{"with, a \"comma\"", "0 of 9", "0.333", ""}));
}

TEST(Columns, ArePickedInTheOrderAskedFor) {
  EXPECT_EQ(csv_of(pick(columns(), {"number", "word"}), std::vector<Row>{rows[0]}), "number,word\n0.1,plain\n");
}

TEST(LimitColumns, AreThoseThatScriptsRead) {
  LimitResult result;
  LimitRow& row = result.rows.emplace_back();
  row.epsilon = 0.01, row.elements = 27, row.tolerance = 1e-6, row.events = 4, row.max_penetration = 0.25;
  row.difference_to_scheme_limit = 0.5;
  EXPECT_EQ(limit_csv(result),
            "elements,epsilon,mass,events,max_penetration,difference_to_scheme,difference_to_own_limit,"
            "difference_to_scheme_limit,tolerance,steps,seconds\n27,0.01,consistent,4,0.25,0,,0.5,1e-06,0,0\n");
  EXPECT_EQ(json_of(limit_columns(), row).dump(),
            R"({"epsilon":0.01,"elements":27,"mass":"consistent","events":4,"max_penetration":0.25,)"
            R"("difference_to_scheme":0.0,"difference_to_rigid":0.5,"difference_to_scheme_limit":0.5,)"
            R"("tolerance":1e-06,"steps":0,"seconds":0.0})");
}

}  // namespace
}  // namespace viscobar

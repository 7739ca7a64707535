// Tables of measured values as instruments, spreadsheets and programs write them.
#include "input/trace_file.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <string>

#include "support/scratch.hpp"
#include "viscobar/input/scene_file.hpp"

namespace {

using namespace viscobar;

const std::vector<std::string> known = {"t", "u_left", "v_left", "u_right"};

TraceFile read(const std::string& text) {
  const Scratch scratch;
  const auto file = scratch.path() / "data.csv";
  std::ofstream(file, std::ios::binary) << text;
  return read_traces(file, known, {"t"});
}

std::string error_of(const std::string& text) {
  try {
    read(text);
  } catch (const SceneError& error) {
    return error.what();
  }
  return "none";
}

// Each of these says: u_left is 0, -0.25 and 1.5 at the times 0, 0.5 and 1.
TEST(TraceFile, IsReadAsInstrumentsAndSpreadsheetsWriteIt) {
  for (const std::string text : {
           "t,u_left\n0,0\n0.5,-0.25\n1,1.5\n",
           "\xef\xbb\xbft,u_left\n0,0\n0.5,-0.25\n1,1.5\n",                          // byte order mark
           "\"t\",\"u_left\"\n\"0\",\"0\"\n\"0.5\",\"-0.25\"\n\"1\",\"1.5\"\n",      // quotes
           "t;u_left\n0;0\n0,5;-0,25\n1;1,5\n",                                      // decimal commas
           "\"t\",\"u_left\"\n\"0\",\"0\"\n\"0,5\",\"-0,25\"\n\"1\",\"1,5\"\n",      // the same in quotes
           "sep=;\r\nt;u_left\r\n0;0\r\n0,5;-0,25\r\n1;1,5\r\n",                     // Excel
           "t\tu_left\n0\t0\n0.5\t-0.25\n1\t1.5\n",                                  // tabs
           "t u_left\n0 0\n0.5   -0.25\n1 1.5\n",                                    // blanks
           "t,u_left,\n0,0,\n0.5,-0.25,\n1,1.5,\n",                                  // commas behind
           "t,u_left\n0,0,,\n0.5,-0.25,,\n1,1.5,,\n,,,\n",                           // a spreadsheet's empty cells
           "# a trace\nt,u_left\n0,0\n% noise\n0.5,-0.25\n// end\n1,1.5\n",          // comments
           "# t u_left\n0 0\n5e-1 -2.5e-1\n1e0 1.5e0\n",                             // numpy.savetxt
           "t,u_left\ns,mm\n0,0\n0.5,-0.25\n1,1.5\n",                                // a line of units
           "t [s],u_left [mm]\n0,0\n0.5,-0.25\n1,1.5\n",                             // units in names
           "Time (s);U_Left (mm)\n0;0\n0.5;-0.25\n1;1.5\n",                          //
           "time_s,u_left\n0,0\n0.5,-0.25\n1,1.5\n",                                 //
           "TIME , u left\n0,0\n0.5,-0.25\n1,1.5\n",                                 // capitals, blanks
           "t,u_left\n1,1.5\n0,0\n0.5,-0.25\n",                                      // not sorted
           "t,temperature,u_left,remark\n0,20,0,cold\n0.5,20,-0.25,\n1,21,1.5,x\n",  // other columns
           "Recorder 7\nDate,2026-11-25\nTime,12:00\n\nt,u_left\n0,0\n0.5,-0.25\n1,1.5\n",  // lines before
           "t,u_left\r0,0\r0.5,-0.25\r1,1.5\r",                                             // ends of lines of old
           "t,u_left\n+0,0.0D0\n5.0D-1,\xe2\x88\x92"
           "0.25\n1,1.5d0\n",  // Fortran, a true minus
       }) {
    SCOPED_TRACE(text);
    const TraceFile table = read(text);
    EXPECT_EQ(table.column("t")->values, (std::vector<double>{0.0, 0.5, 1.0}));
    EXPECT_EQ(table.column("u_left")->values, (std::vector<double>{0.0, -0.25, 1.5}));
    EXPECT_TRUE(table.doubts.empty());
  }
}

TEST(TraceFile, InUtf16IsRead) {
  std::string text("\xff\xfe", 2);
  for (const char c : std::string("t\tu_left\r\n0\t1\r\n1\t2\r\n")) text += c, text += '\0';
  EXPECT_EQ(read(text).column("u_left")->values, (std::vector<double>{1.0, 2.0}));
}

TEST(TraceFile, TakesWordsAndEmptyCellsForNoValue) {
  const TraceFile table = read("t,u_left,v_left\n0,NA,1\n1,,nan\n2,#N/A,--\n3,n/a,null\n4,1,2\n");
  EXPECT_EQ(table.rows, 5u);
  for (std::size_t k = 0; k < 4; ++k) EXPECT_TRUE(std::isnan(table.column("u_left")->values[k]));
  EXPECT_NE(table.understood.find("7 values not measured"), std::string::npos) << table.understood;
}

TEST(TraceFile, KeepsRowsOfEqualTimesAndSaysSo) {
  const TraceFile table = read("t,u_left\n0.001,1\n0.001,2\n0.002,3\n");
  EXPECT_EQ(table.rows, 3u);
  EXPECT_NE(table.understood.find("some times are equal"), std::string::npos) << table.understood;
}

TEST(TraceFile, OfMoreThanAMebibyteIsRead) {
  std::string text = "t,u_left\n";
  for (int k = 0; k < 120'000; ++k) text += std::to_string(k) + ",0.125\n";
  ASSERT_GT(text.size(), std::size_t{1} << 20);
  EXPECT_EQ(read(text).rows, 120'000u);
}

TEST(TraceFile, FindsCodesOfMissingValues) {
  for (const std::string code :
       {"-9999", "1e200", "9999", "-999.25", "-32768", "1e30", "-99999.0", "9.96921e36", "2147483647"}) {
    SCOPED_TRACE(code);
    const TraceFile table = read("t,u_left\n0,1\n1,-2.5\n2," + code + "\n3,2\n4," + code + "\n5,0\n");
    EXPECT_TRUE(std::isnan(table.column("u_left")->values[2]));
    EXPECT_TRUE(std::isnan(table.column("u_left")->values[4]));
    EXPECT_EQ(table.column("u_left")->values[1], -2.5);
    ASSERT_EQ(table.doubts.size(), 1u);
    EXPECT_NE(table.doubts[0].find("at t = 2"), std::string::npos) << table.doubts[0];
  }
  // A peak is no code, nor is a number that looks like one among its like.
  for (const std::string text :
       {"t,u_left\n0,1\n1,2\n2,300\n3,1\n", "t,u_left\n0,9000\n1,-9999\n2,8000\n", "t,u_left\n0,100000\n1,100000\n"}) {
    const TraceFile table = read(text);
    EXPECT_TRUE(table.doubts.empty()) << text;
    for (const double value : table.column("u_left")->values) EXPECT_TRUE(std::isfinite(value)) << text;
  }
}

TEST(TraceFile, SaysWhatCannotBeRead) {
  EXPECT_NE(error_of("t,u_lefft\n0,1\n").find("data.csv:1:2: u_lefft: unknown column; nearest is \"u_left\""),
            std::string::npos);
  EXPECT_NE(error_of("t;u_left\n0;0,5\n1;0.5\n").find("decimal commas and decimal points"), std::string::npos);
  EXPECT_NE(error_of("t,u_left\n0,1\n1,2,3\n").find("data.csv:3:1: has 3 values for 2 columns"), std::string::npos);
  EXPECT_NE(error_of("t,u_left\n0,1\n-1,2\n").find("must be a time"), std::string::npos);
  EXPECT_NE(error_of("t,u_left\n0,1\nNA,2\n").find("data.csv:3:1: t: is missing"), std::string::npos);
  EXPECT_NE(error_of("t,u_left\n0,inf\n").find("is no number"), std::string::npos);
  EXPECT_NE(error_of("t,t\n0,1\n").find("is there twice"), std::string::npos);
  for (const std::string text :
       {"", "\n\n", "t,u_left\n", "\"", "t,u_left\n\"", ",,,\n,,\n", "#\n%\n", ";", "\xff\xfe", "sep=;"})
    EXPECT_NE(error_of(text), "none") << text;
}

TEST(TraceFile, KnowsUnitsAndTheirRatios) {
  EXPECT_DOUBLE_EQ(*unit_ratio("ms", "s"), 1e-3);
  EXPECT_DOUBLE_EQ(*unit_ratio("mm/s", "m/s"), 1e-3);
  EXPECT_DOUBLE_EQ(*unit_ratio("m/s", "mm/ms"), 1.0);
  EXPECT_DOUBLE_EQ(*unit_ratio("MPa", "Pa"), 1e6);
  EXPECT_DOUBLE_EQ(*unit_ratio("min", "s"), 60.0);
  EXPECT_DOUBLE_EQ(*unit_ratio("furlong", "furlong"), 1.0);
  EXPECT_FALSE(unit_ratio("m", "s"));
  EXPECT_FALSE(unit_ratio("mm", "m/s"));
  EXPECT_FALSE(unit_ratio("inch", "m"));
}

}  // namespace

#include "io/csv.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <thread>

#include "io/scratch.hpp"
#include "viscobar/io/io_error.hpp"

namespace viscobar {
namespace {

TEST(EndsCsv, WritesNumbersThatReadBackAsTheSameDoubles) {
  const Scratch scratch;
  const std::vector<double> u = {0.1 + 0.2, 5.0, std::nextafter(1.0, 2.0)}, v = {-1e-300, 0.0, 1.0 / 3.0};
  EndsCsv csv(scratch / "ends.csv");
  csv.append({0.1, u, v, 2.0, 1e22});
  csv.close();
  const auto lines = read_lines(scratch / "ends.csv");
  ASSERT_EQ(lines.size(), 2u);
  EXPECT_EQ(lines[0], "t,u_left,v_left,reaction_left,u_right,v_right,reaction_right");
  std::istringstream row(lines[1]);
  for (const double expected : {0.1, u[0], v[0], 2.0, u[2], v[2], 1e22}) {
    std::string cell;
    ASSERT_TRUE(std::getline(row, cell, ','));
    EXPECT_EQ(std::stod(cell), expected);
  }
}

TEST(EventsCsv, NamesTheEndsAndTheNodesOfTheSpan) {
  const Scratch scratch;
  EventsCsv csv(scratch / "events.csv");
  csv.append({0.5, Where::left, 0, Change::closing, -2.0});
  csv.append({0.75, Where::right, 10, Change::opening, 0.25});
  csv.append({1.0, Where::span, 7, Change::closing, -1.0});
  csv.close();
  EXPECT_EQ(read_text(scratch / "events.csv"),
            "t,where,change,velocity\n0.5,left,closing,-2\n0.75,right,opening,0.25\n1,span:7,closing,-1\n");
}

TEST(LineFile, HoldsWholeLinesOnDiskWhileItGrows) {
  const Scratch scratch;
  LineFile file(scratch / "lines");
  std::size_t printed = 0;
  while (printed < 10'000) file.print("{}", ++printed);  // some 49 kB, less than a block
  EXPECT_TRUE(read_text(scratch / "lines").empty());
  while (printed < 20'000) file.print("{}", ++printed);
  const std::string text = read_text(scratch / "lines");
  EXPECT_FALSE(text.empty());
  EXPECT_EQ(text.back(), '\n');
}

TEST(LineFile, WritesASlowFileAtLeastEverySecondOrSo) {
  const Scratch scratch;
  LineFile file(scratch / "lines");
  std::this_thread::sleep_for(std::chrono::milliseconds(1010));
  file.print("a line");
  EXPECT_EQ(read_text(scratch / "lines"), "a line\n");
}

TEST(LineFile, AFullDiskIsAnErrorThatNamesTheFileAndTheReason) {
  LineFile file("/dev/full");
  file.print("a line");
  try {
    file.flush();
    FAIL() << "writing to a full device went unnoticed";
  } catch (const IoError& error) {
    EXPECT_EQ(error.file, "/dev/full");
    EXPECT_NE(std::string(error.what()).find("No space left"), std::string::npos) << error.what();
  }
}

TEST(LineFile, APlaceThatIsNotThereIsAnErrorAtOnce) {
  const Scratch scratch;
  EXPECT_THROW(LineFile(scratch / "nowhere/file"), IoError);
}

TEST(WriteAtomically, ReplacesTheContentAndLeavesNothingElse) {
  const Scratch scratch;
  write_atomically(scratch / "file", "old and long");
  write_atomically(scratch / "file", "new");
  EXPECT_EQ(read_text(scratch / "file"), "new");
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(scratch.path()), {}), 1);
}

TEST(WriteAtomically, AFailureKeepsTheOldContent) {
  const Scratch scratch;
  write_atomically(scratch / "file", "old");
  std::filesystem::create_directory(scratch / "file.part");
  EXPECT_THROW(write_atomically(scratch / "file", "new"), IoError);
  EXPECT_EQ(read_text(scratch / "file"), "old");
}

}  // namespace
}  // namespace viscobar

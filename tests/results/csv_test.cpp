#include "results/csv.hpp"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <chrono>
#include <cmath>
#include <thread>

#include "results/output_file.hpp"
#include "support/file_size_limit.hpp"
#include "support/scratch.hpp"
#include "viscobar/results/io_error.hpp"

namespace viscobar::testing_csv {
namespace {

TEST(EndsRow, WritesNumbersThatReadBackAsTheSameDoubles) {
  const std::vector<double> u = {0.1 + 0.2, 5.0, std::nextafter(1.0, 2.0)}, v = {-1e-300, 0.0, 1.0 / 3.0};
  EXPECT_EQ(ends_header, "t,u_left,v_left,reaction_left,u_right,v_right,reaction_right");
  std::istringstream row(ends_row({0.1, u, v, 2.0, 1e22}));
  for (const double expected : {0.1, u[0], v[0], 2.0, u[2], v[2], 1e22}) {
    std::string cell;
    ASSERT_TRUE(std::getline(row, cell, ','));
    EXPECT_EQ(std::stod(cell), expected);
  }
}

TEST(EventsRow, NamesTheEndsAndTheNodesOfTheSpan) {
  EXPECT_EQ(events_header, "t,where,change,velocity");
  EXPECT_EQ(events_row({0.5, Where::left, 0, Change::closing, -2.0}), "0.5,left,closing,-2");
  EXPECT_EQ(events_row({0.75, Where::right, 10, Change::opening, 0.25}), "0.75,right,opening,0.25");
  EXPECT_EQ(events_row({1.0, Where::span, 7, Change::closing, -1.0}), "1,span:7,closing,-1");
}

TEST(LineFile, HoldsWholeLinesOnDiskWhileItGrows) {
  const Scratch scratch;
  LineFile file(scratch / "lines");
  file.take_place();
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
  file.take_place();
  std::this_thread::sleep_for(std::chrono::milliseconds(1010));
  file.print("a line");
  EXPECT_EQ(read_text(scratch / "lines"), "a line\n");
}

TEST(LineFile, AFullDiskIsAnErrorThatNamesTheFileAndTheReason) {
  const Scratch scratch;
  LineFile file(scratch / "lines");
  file.print("a line");
  try {
    const FileSizeLimit full(0);
    file.flush();
    FAIL() << "a file that may not grow went unnoticed";
  } catch (const IoError& error) {
    EXPECT_EQ(error.file, scratch / "lines");
    EXPECT_NE(std::string(error.what()).find("File too large"), std::string::npos) << error.what();
  }
}

TEST(LineFile, ThatHasBeenRemovedOrReplacedIsAnErrorThatSaysSo) {
  for (const bool replaced : {false, true}) {
    const Scratch scratch;
    LineFile file(scratch / "lines");
    file.take_place();
    file.print("a line");
    std::filesystem::remove(scratch / "lines");
    if (replaced) std::ofstream(scratch / "lines") << "mine";
    try {
      file.close();
      FAIL() << "a missing file was taken for a written one";
    } catch (const IoError& error) {
      EXPECT_NE(std::string(error.what()).find("was removed or replaced"), std::string::npos) << error.what();
    }
    EXPECT_EQ(read_text(scratch / "lines"), replaced ? "mine" : "");
  }
}

TEST(OutputFile, TheOneThatIsThereStaysUntilTheNewOneIsWhole) {
  const Scratch scratch;
  std::ofstream(scratch / "file") << "old";
  {
    OutputFile file(scratch / "file");
    file.write_at(0, "half of the new");
    EXPECT_EQ(read_text(scratch / "file"), "old");
  }
  EXPECT_EQ(read_text(scratch / "file"), "old");
  EXPECT_FALSE(std::filesystem::exists(scratch / "file.part"));
}

TEST(OutputFile, FollowsNoLinks) {
  const Scratch scratch;
  for (const char* link : {"file", "file.part"}) {
    std::ofstream(scratch / "elsewhere") << "mine";
    std::filesystem::create_symlink(scratch / "elsewhere", scratch / link);
    write_atomically(scratch / "file", "ours");
    EXPECT_EQ(read_text(scratch / "elsewhere"), "mine") << link;
    EXPECT_EQ(read_text(scratch / "file"), "ours") << link;
    std::filesystem::remove(scratch / "file");
  }
  std::filesystem::create_symlink(scratch / "elsewhere", scratch / "file");
  EXPECT_THROW(OutputFile(scratch / "file", OutputFile::Content::keep), IoError);
}

TEST(OutputFile, ReplacesNoPipesAndDirectories) {
  const Scratch scratch;
  ASSERT_EQ(mkfifo((scratch / "file").c_str(), 0666), 0);
  EXPECT_THROW(write_atomically(scratch / "file", "ours"), IoError);
  EXPECT_THROW(OutputFile(scratch / "file", OutputFile::Content::keep), IoError);
  EXPECT_TRUE(std::filesystem::is_fifo(scratch / "file"));
  std::filesystem::create_directory(scratch / "folder");
  EXPECT_THROW(write_atomically(scratch / "folder", "ours"), IoError);
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
}  // namespace viscobar::testing_csv

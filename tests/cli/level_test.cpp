// Which program runs on which processor.
#include <cstdlib>
#include <fstream>

#include "cli/command.hpp"

namespace viscobar {
namespace {

#ifdef VISCOBAR_LEVEL_PROGRAM

/// level_program, and beside it programs for other levels that say which they are and what they were given.
class Level : public testing_cli::Command {
 protected:
  Level() {
    testing_cli::fs::copy_file(VISCOBAR_LEVEL_PROGRAM, directory_ / "program");
    for (const std::string name : {"x86-64-v2", "x86-64-v4"}) {
      const auto folder = directory_ / "levels" / name;
      testing_cli::fs::create_directories(folder);
      std::ofstream(folder / "program") << "#!/bin/sh\necho " << name << " \"$@\"\n";
      testing_cli::fs::permissions(folder / "program", testing_cli::fs::perms::owner_all);
    }
  }

  std::string printed_with(const std::string& environment) const {
    const std::string line =
        "cd '" + directory_.string() + "' && " + environment + " ./program \"a word\" >printed.txt";
    EXPECT_EQ(std::system(line.c_str()), 0);
    return read_text(directory_ / "printed.txt");
  }
};

// A processor has each of the levels below its own. What it runs here is the highest that is there and that it may use.
TEST_F(Level, TheHighestProgramThatTheProcessorHasRuns) {
  __builtin_cpu_init();
  if (!__builtin_cpu_supports("sse4.2")) GTEST_SKIP() << "a processor of the lowest level";
  EXPECT_EQ(printed_with("VISCOBAR_LEVEL=x86-64-v3"), "x86-64-v2 a word\n");
  EXPECT_EQ(printed_with("VISCOBAR_LEVEL=x86-64"), "x86-64\n");
  EXPECT_EQ(printed_with(""), __builtin_cpu_supports("avx512vl") ? "x86-64-v4 a word\n" : "x86-64-v2 a word\n");
}

TEST_F(Level, AProcessorBelowTheProgramsIsToldInWords) {
  const std::string built = VISCOBAR_LEVEL;
  if (built == "native" || built == "x86-64") GTEST_SKIP() << "built for " << built;
  const std::string line =
      "cd '" + directory_.string() + "' && VISCOBAR_LEVEL=x86-64 '" VISCOBAR_COMMAND "' list 2>said.txt";
  const int status = std::system(line.c_str());
  ASSERT_TRUE(WIFEXITED(status));
  EXPECT_EQ(WEXITSTATUS(status), 1);
  EXPECT_EQ(read_text(directory_ / "said.txt"),
            "viscobar was built for processors of the level " + built +
                ", and this one has x86-64; build it here, or with -DVISCOBAR_LEVEL=x86-64 for all\n");
}

#endif

}  // namespace
}  // namespace viscobar

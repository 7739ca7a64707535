// Standard streams that are closed, full or gone take nothing from a result.
#include <fcntl.h>

#include <csignal>
#include <thread>

#include "cli/command.hpp"
#include "cli/terminal.hpp"

namespace viscobar::testing_cli {
namespace {

class Streams : public Command {
 protected:
  /// Exit code of a line of the shell in the test's directory, where $V is the program; minus the signal that ended it.
  int shell(const std::string& line) const {
    const int status =
        std::system(("cd '" + directory_.string() + "' && V='" VISCOBAR_COMMAND "' && { " + line + "\n}").c_str());
    return WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
  }
  bool completed(const std::string& where) const {
    return nlohmann::json::parse(read_text(directory_ / where / "summary.json"))["completed"];
  }
  /// A run that warns on standard error before it is over.
  const std::string warned = "$V run " + scene("chatter");
};

TEST_F(Streams, AMessageThatCannotBeWrittenLeavesTheExitCode) {
  EXPECT_EQ(shell("$V run nowhere.toml 2>/dev/full"), 2);
  EXPECT_EQ(shell("$V run 2>/dev/full"), 2);
  EXPECT_EQ(shell("$V info nowhere 2>&-"), 2);
}

TEST_F(Streams, AWarningThatCannotBeWrittenEndsNoRun) {
  EXPECT_EQ(shell(warned + " -o full >out.txt 2>/dev/full"), 0);
  EXPECT_TRUE(completed("full"));
  EXPECT_EQ(shell(warned + " -o log --quiet --log /dev/full -v 2>/dev/full"), 0);
  EXPECT_TRUE(completed("log"));
}

TEST_F(Streams, AReaderOfMessagesThatHasGoneEndsNoRun) {
  if (!fs::exists("/bin/bash")) GTEST_SKIP() << "no bash";
  std::ofstream(directory_ / "gone.bash") << "trap '' HUP\nmkfifo pipe\nexec 7<>pipe\nexec 8>pipe\nexec 7<&-\n"
                                          << "V='" VISCOBAR_COMMAND "'\n"
                                          << warned << " -o gone >out.txt 2>&8\n";
  EXPECT_EQ(shell("/bin/bash gone.bash"), 0);
  EXPECT_TRUE(completed("gone"));
}

TEST_F(Streams, ASweepWhoseErrorsCannotBeWrittenWritesItsTables) {
  std::ofstream(directory_ / "sweep.toml") << "scene = " << '"' << VISCOBAR_SOURCE_DIR
                                           << "/examples/scenes/chatter.toml\"\n[set]\ntime.end = 0.1\n[vary]\n"
                                              "mesh.mass = [\"consistent\", \"redistributed\"]\n"
                                              "bar.viscosity = [0.0]\n";
  EXPECT_EQ(shell("$V sweep sweep.toml -o out >out.txt 2>/dev/full"), 1) << "a case failed";
  EXPECT_TRUE(fs::exists(directory_ / "out/sweep.json"));
  EXPECT_NE(read_text(directory_ / "out.txt").find("whole sweep"), std::string::npos);
}

TEST_F(Streams, NoFileTakesThePlaceOfAClosedStream) {
  const std::string run = warned + " --set output.every=1e-3 -o ";
  ASSERT_EQ(shell(run + "open >out.txt 2>err.txt"), 0);
  EXPECT_EQ(shell(run + "closed >out.txt 2>&-"), 0);
  EXPECT_EQ(shell(run + "both <&- >out.txt 2>&-"), 0);
  for (const std::string where : {"closed", "both"})
    for (const std::string file : {"/ends.csv", "/events.csv"})
      EXPECT_EQ(read_text(directory_ / ("open" + file)) == read_text(directory_ / (where + file)), true)
          << where << file;
}

TEST_F(Streams, AResultThatCannotBePrintedIsAnError) {
  for (const std::string command : {"list methods", "--help", "--version", "run --help"}) {
    EXPECT_EQ(shell("$V " + command + " >/dev/full 2>err.txt"), 1) << command;
    EXPECT_NE(read_text(directory_ / "err.txt").find("standard output: cannot be written: No space left"),
              std::string::npos);
    EXPECT_EQ(shell("$V " + command + " >&- 2>err.txt"), 1) << command;
  }
}

TEST_F(Streams, AReaderOfTheResultThatHasSeenEnoughEndsTheProgramWithoutAMessage) {
  if (!fs::exists("/bin/bash")) GTEST_SKIP() << "no bash";
  std::ofstream(directory_ / "head.bash") << "V='" VISCOBAR_COMMAND
                                             "'\nmkfifo pipe\nexec 7<>pipe\nexec 8>pipe\nexec 7<&-\n"
                                             "$V list keys >&8 2>err.txt\necho $?\n";
  EXPECT_EQ(shell("test $(/bin/bash head.bash) = " + std::to_string(128 + SIGPIPE)), 0);
  EXPECT_EQ(read_text(directory_ / "err.txt"), "");
}

// As after a login has ended, by a program that nohup(1) had told to ignore it.
TEST_F(Streams, ATerminalThatGoesAwayEndsNoRun) {
  int master = -1, slave = -1;
  char name[128] = {};
  ASSERT_EQ(openpty(&master, &slave, name, nullptr, nullptr), 0);
  ASSERT_NE(fcntl(master, F_SETFD, FD_CLOEXEC), -1) << "the program must not keep its own terminal";
  std::thread hangup([&] {
    std::this_thread::sleep_for(std::chrono::milliseconds(200));
    close(slave);
    close(master);
  });
  EXPECT_EQ(shell("trap '' HUP; { sleep 1; $V run " + scene("chatter") + " -o out; } >out.txt 2>" + name), 0);
  hangup.join();
  EXPECT_TRUE(completed("out"));
}

}  // namespace
}  // namespace viscobar::testing_cli

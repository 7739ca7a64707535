// Directories of results as they are used: by two commands at once, under mpirun, with files that are somebody else's.
#include <fcntl.h>
#include <signal.h>
#include <sys/stat.h>

#include <chrono>
#include <cstdlib>
#include <thread>

#include "checkpoint/process.hpp"
#include "cli/command.hpp"

namespace viscobar::testing_cli {
namespace {

using testing_checkpoint::Process;

class Directories : public Command {
 protected:
  Directories() { fs::copy_file(VISCOBAR_SOURCE_DIR "/examples/scenes/chatter.toml", directory_ / "chatter.toml"); }

  /// A run that takes a few seconds, when it has begun to write; in `directory`.
  Process long_run(const std::string& directory, std::vector<std::string> more = {},
                   const std::vector<std::string>& environment = {}) const {
    std::vector<std::string> arguments = {"run",     VISCOBAR_SOURCE_DIR "/examples/scenes/unit-both-ends.toml",
                                          "--set",   "time.end=4000",
                                          "--set",   "output.every=0.5",
                                          "--quiet", "-o",
                                          directory};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return Process(directory_, arguments, environment);
  }
  void wait_for(const std::string& file) const {
    for (int i = 0; i < 20'000 && !fs::exists(directory_ / file); ++i)
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  nlohmann::json summary(const std::string& directory) const {
    return nlohmann::json::parse(read_text(directory_ / directory / "summary.json"));
  }
};

TEST_F(Directories, OfARunThatGoesOnAreRefusedToEveryOtherCommandThatWrites) {
  for (const std::string locking : {"TRUE", "FALSE"}) {
    SCOPED_TRACE(locking);
    setenv("HDF5_USE_FILE_LOCKING", locking.c_str(), 1);
    Process first = long_run("out", {"--checkpoint", "50"});
    wait_for("out/checkpoint.bin");
    for (const char* command : {"run chatter.toml -o out", "resume out", "compare chatter.toml -o out",
                                "limit chatter.toml -o out", "precision chatter.toml -o out"}) {
      const Ended second = viscobar(command);
      EXPECT_EQ(second.code, 1) << command << second.error;
      EXPECT_NE(second.error.find("out: is in use by viscobar, process "), std::string::npos) << second.error;
    }
    EXPECT_FALSE(first.ended());
    EXPECT_EQ(first.wait(), 0);
    unsetenv("HDF5_USE_FILE_LOCKING");
    EXPECT_EQ(summary("out")["completed"], true);
    const std::string ends = read_text(directory_ / "out/ends.csv");
    EXPECT_EQ(std::count(ends.begin(), ends.end(), '\n'), 1 + 8001);
    EXPECT_EQ(ends.find('\0'), std::string::npos);
    fs::remove_all(directory_ / "out");
  }
}

TEST_F(Directories, UnderMpirunOneProcessRunsAndTheOthersSayWhyTheyDoNot) {
  const std::string line =
      "cd '" + directory_.string() +
      "' && for rank in 0 1 2; do PMIX_NAMESPACE=job '" VISCOBAR_COMMAND "' run '" VISCOBAR_SOURCE_DIR
      "/examples/scenes/unit-both-ends.toml' --set time.end=4000 --set output.every=0.5 --quiet -o "
      "out >>messages 2>&1 & all=\"$all $!\"; done; for one in $all; do wait $one || exit 1; done";
  EXPECT_EQ(std::system(line.c_str()), 0);
  const std::string messages = read_text(directory_ / "messages");
  EXPECT_NE(messages.find("only sweep makes use of several"), std::string::npos) << messages;
  EXPECT_EQ(summary("out")["completed"], true);
  const std::string ends = read_text(directory_ / "out/ends.csv");
  EXPECT_EQ(std::count(ends.begin(), ends.end(), '\n'), 1 + 8001);
}

TEST_F(Directories, AFileThatIsRemovedWhileItIsWrittenFailsTheRun) {
  for (const std::string file : {"ends.csv", "field.h5", "field.xdmf"}) {
    Process run = long_run("out");
    wait_for("out/" + file);
    fs::remove(directory_ / "out" / file);
    EXPECT_EQ(run.wait(), 1) << file;
    EXPECT_NE(read_text(directory_ / "err.txt").find(file), std::string::npos) << read_text(directory_ / "err.txt");
    EXPECT_EQ(summary("out")["completed"], false);
    fs::remove_all(directory_ / "out");
  }
}

TEST_F(Directories, AnInterruptedRunSaysWhereItIsAndThatTheWholeOneStayed) {
  ASSERT_EQ(viscobar("run chatter.toml --quiet -o out").code, 0);
  const std::string ends = read_text(directory_ / "out/ends.csv");
  Process run = long_run("out");
  wait_for("out/unfinished/ends.csv");
  run.signal(SIGINT);
  EXPECT_EQ(run.wait(), 130);
  const std::string said = read_text(directory_ / "err.txt");
  EXPECT_NE(said.find("The earlier result in out is as it was; what this run reached is in out/unfinished."),
            std::string::npos)
      << said;
  EXPECT_TRUE(read_text(directory_ / "out/ends.csv") == ends);
  const nlohmann::json info = viscobar("info out --json").json();
  ASSERT_EQ(info["results"].size(), 2u);
  EXPECT_EQ(info["results"][0]["completed"], true);
  EXPECT_EQ(info["results"][1]["completed"], false);
  EXPECT_EQ(info["results"][1]["file"], "unfinished/summary.json");
  ASSERT_EQ(viscobar("resume out --quiet").code, 0);
  EXPECT_EQ(summary("out")["reached_time"], 4000.0);
  EXPECT_FALSE(fs::exists(directory_ / "out/unfinished"));
}

TEST_F(Directories, AHangUpLeavesACheckpointUnlessItIsIgnored) {
  Process run = long_run("out");
  wait_for("out/ends.csv");
  run.signal(SIGHUP);
  EXPECT_EQ(run.wait(), 130);
  EXPECT_EQ(viscobar("resume out --quiet").code, 0);
  EXPECT_EQ(summary("out")["completed"], true);

  signal(SIGHUP, SIG_IGN);
  Process nohup = long_run("out2");
  signal(SIGHUP, SIG_DFL);
  wait_for("out2/ends.csv");
  nohup.signal(SIGHUP);
  EXPECT_EQ(nohup.wait(), 0);
}

TEST_F(Directories, APipeInTheWayIsRefusedAtOnce) {
  fs::create_directory(directory_ / "out");
  ASSERT_EQ(viscobar("run chatter.toml --quiet -o out").code, 0);
  fs::remove(directory_ / "out/ends.csv");
  ASSERT_EQ(mkfifo((directory_ / "out/ends.csv").c_str(), 0666), 0);
  const Ended ended = viscobar("run chatter.toml --quiet -o out");
  EXPECT_EQ(ended.code, 2);
  EXPECT_NE(ended.error.find("out/ends.csv is no regular file"), std::string::npos) << ended.error;
}

TEST_F(Directories, OfASceneThatIsNamedAsASummaryAreRefused) {
  fs::create_directory(directory_ / "out");
  fs::copy_file(directory_ / "chatter.toml", directory_ / "out/summary.json");
  EXPECT_EQ(viscobar("run out/summary.json -o out").code, 2);
  EXPECT_EQ(read_text(directory_ / "out/summary.json"), read_text(directory_ / "chatter.toml"));
}

TEST_F(Directories, ACheckpointThatIsADirectoryGivesWayToTheOneBefore) {
  Process run = long_run("out", {"--checkpoint", "20"});
  wait_for("out/checkpoint.previous.bin");
  run.signal(SIGINT);
  ASSERT_EQ(run.wait(), 130);
  fs::remove(directory_ / "out/checkpoint.bin");
  fs::create_directories(directory_ / "out/checkpoint.bin/mine");
  const Ended ended = viscobar("resume out --quiet");
  EXPECT_EQ(ended.code, 0);
  EXPECT_NE(ended.error.find("out/checkpoint.bin: is no regular file"), std::string::npos) << ended.error;
  EXPECT_EQ(summary("out")["completed"], true);
  EXPECT_TRUE(fs::exists(directory_ / "out/checkpoint.damaged/mine"));
}

TEST_F(Directories, ARunKilledWhenItWasWholeIsCompleteToResume) {
  Process run = long_run("out", {"--checkpoint", "20"});
  wait_for("out/checkpoint.previous.bin");
  run.signal(SIGINT);
  ASSERT_EQ(run.wait(), 130);
  fs::copy_file(directory_ / "out/checkpoint.bin", directory_ / "left");
  ASSERT_EQ(viscobar("resume out --quiet").code, 0);
  fs::copy_file(directory_ / "left", directory_ / "out/checkpoint.bin");
  const std::string summary = read_text(directory_ / "out/summary.json");
  const Ended ended = viscobar("resume out --json");
  EXPECT_EQ(ended.code, 0) << ended.error;
  EXPECT_EQ(ended.out, summary);
  EXPECT_EQ(read_text(directory_ / "out/summary.json"), summary);
  EXPECT_FALSE(fs::exists(directory_ / "out/checkpoint.bin"));
}

TEST_F(Directories, ALogIsAppendedToLogsOnly) {
  const std::string scene = read_text(directory_ / "chatter.toml");
  EXPECT_EQ(viscobar("check chatter.toml --log chatter.toml").code, 2);
  EXPECT_EQ(read_text(directory_ / "chatter.toml"), scene);
  std::ofstream(directory_ / "notes") << "mine";
  EXPECT_EQ(viscobar("check chatter.toml --log notes").code, 2);
  EXPECT_EQ(read_text(directory_ / "notes"), "mine");
  EXPECT_EQ(viscobar("check chatter.toml --log log").code, 0);
  const std::size_t once = read_text(directory_ / "log").size();
  EXPECT_EQ(viscobar("check chatter.toml --log log").code, 0);
  EXPECT_GT(read_text(directory_ / "log").size(), once);
  EXPECT_EQ(viscobar("check chatter.toml --log /dev/stderr").code, 0);
  ASSERT_EQ(mkfifo((directory_ / "pipe").c_str(), 0666), 0);
  EXPECT_EQ(viscobar("check chatter.toml --log pipe").code, 1) << "nobody reads it";
}

TEST_F(Directories, AnExportReplacesExportsOnlyAndFollowsNoLinks) {
  ASSERT_EQ(viscobar("run chatter.toml --quiet -o out").code, 0);
  std::ofstream(directory_ / "u.csv") << "mine\n";
  fs::copy_file(directory_ / "u.csv", directory_ / "v.csv", fs::copy_options::overwrite_existing);
  const Ended ended = viscobar("export out -o .");
  EXPECT_EQ(ended.code, 2);
  EXPECT_NE(ended.error.find("is not an earlier export"), std::string::npos) << ended.error;
  EXPECT_TRUE(read_text(directory_ / "v.csv") == "mine\n");
  EXPECT_FALSE(fs::exists(directory_ / "ends.csv"));
  ASSERT_EQ(viscobar("export out --quiet").code, 0);
  const std::string field = read_text(directory_ / "out/field.h5"), exported = read_text(directory_ / "out/csv/u.csv");
  ASSERT_EQ(viscobar("run chatter.toml --quiet -o other").code, 0);
  for (const char* format : {"csv", "xdmf"}) {
    const Ended onto = viscobar("export out -o other --format " + std::string(format));
    EXPECT_EQ(onto.code, 2);
    EXPECT_NE(onto.error.find("other holds another result; nothing was changed"), std::string::npos) << onto.error;
  }
  EXPECT_EQ(viscobar("info --verify other").code, 0);
  fs::remove(directory_ / "out/csv/u.csv");
  fs::create_symlink("../field.h5", directory_ / "out/csv/u.csv");
  EXPECT_EQ(viscobar("export out --quiet").code, 2) << "what the link points to is no export";
  EXPECT_TRUE(read_text(directory_ / "out/field.h5") == field);
  fs::remove(directory_ / "out/csv/u.csv");
  fs::create_symlink("nowhere", directory_ / "out/csv/u.csv");
  EXPECT_EQ(viscobar("export out --quiet").code, 0);
  EXPECT_TRUE(read_text(directory_ / "out/csv/u.csv") == exported);
}

TEST_F(Directories, ANewSceneLeavesTheFileBesideItAlone) {
  std::ofstream(directory_ / "mine.toml.part") << "mine";
  EXPECT_EQ(viscobar("new mine.toml").code, 0);
  EXPECT_EQ(read_text(directory_ / "mine.toml.part"), "mine");
}

// Ten million cases take minutes to plan.
TEST_F(Directories, ASweepHearsCtrlCWhileItPlans) {
  std::ofstream(directory_ / "sweep.toml") << "scene = \"chatter.toml\"\n[vary]\n"
                                              "bar.viscosity = { from = 0.1, to = 1.0, count = 3162 }\n"
                                              "time.end = { from = 3.1, to = 4.0, count = 3162 }\n";
  Process sweep(directory_, {"sweep", "sweep.toml", "--threads", "1", "-o", "out"});
  std::this_thread::sleep_for(std::chrono::seconds(1));
  ASSERT_FALSE(sweep.ended()) << read_text(directory_ / "err.txt");
  const auto asked = std::chrono::steady_clock::now();
  sweep.signal(SIGINT);
  EXPECT_EQ(sweep.wait(), 130);
  EXPECT_LT(std::chrono::steady_clock::now() - asked, std::chrono::seconds(1));
  EXPECT_FALSE(fs::exists(directory_ / "out"));
}

}  // namespace
}  // namespace viscobar::testing_cli

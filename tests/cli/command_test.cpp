// The built command as a user meets it, through a shell.
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <cstdlib>
#include <nlohmann/json.hpp>

#include "cli/terminal.hpp"
#include "support/scene_text.hpp"
#include "support/scratch.hpp"

namespace viscobar {
namespace {

using Json = nlohmann::json;

const std::string falling = falling_bar_with({{"title", "\"Falling bar\""},
                                              {"bar.viscosity", "0.5"},
                                              {"right.kind", "\"free\""},
                                              {"method.name", "\"cvode\""},
                                              {"method.step", "1e-3"},
                                              {"output.every", "0.01"}});

class Command : public testing::Test {
 protected:
  Command() { std::ofstream(scratch / "falling.toml") << falling; }

  /// Exit code; what the command printed is in out() and err().
  int run(const std::string& arguments, const std::string& before = "") {
    const std::string line = "cd '" + scratch.path().string() + "' && " + before + "'" VISCOBAR_COMMAND "' " +
                             arguments + " >out.txt 2>err.txt";
    const int status = std::system(line.c_str());
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  }
  std::string out() const { return read_text(scratch / "out.txt"); }
  std::string err() const { return read_text(scratch / "err.txt"); }
  bool has(const std::string& text, const std::string& part) const { return text.find(part) != std::string::npos; }

  Scratch scratch;
};

// Anyone who can write to that directory could run code by such a library.
TEST_F(Command, LoadsNoLibraryFromTheDirectoryThatItIsStartedIn) {
  std::ofstream(scratch / "libz.so.1") << "not a library";
  EXPECT_EQ(run("--version"), 0) << err();
}

TEST_F(Command, RunWritesEveryFileAndSaysWhereThePicturesAre) {
  ASSERT_EQ(run("run falling.toml -o results"), 0) << err();
  for (const char* file : {"summary.json", "ends.csv", "events.csv", "field.h5", "field.xdmf", "report.html"})
    EXPECT_TRUE(std::filesystem::exists(scratch / "results" / file)) << file;
  EXPECT_TRUE(has(out(), "Falling bar"));
  EXPECT_TRUE(has(out(), "results/report.html"));
  EXPECT_TRUE(err().empty()) << err();
}

TEST_F(Command, RunNamesItsDirectoryAfterTheSceneByDefault) {
  ASSERT_EQ(run("run falling.toml --quiet"), 0) << err();
  EXPECT_TRUE(std::filesystem::exists(scratch / "falling.out/summary.json"));
  EXPECT_TRUE(out().empty());
  EXPECT_TRUE(err().empty());
}

TEST_F(Command, JsonPrintsExactlyTheSummary) {
  ASSERT_EQ(run("run falling.toml --json -o results"), 0) << err();
  EXPECT_EQ(out(), read_text(scratch / "results/summary.json"));
  EXPECT_EQ(Json::parse(out())["completed"], true);
  EXPECT_TRUE(err().empty()) << err();
}

TEST_F(Command, EveryMethodThatFitsTheSceneRunsIt) {
  for (const std::string method :
       {"cvode", "ida", "arkode", "odeint", "exponential", "fully_discrete", "finite_difference", "rigid"}) {
    ASSERT_EQ(run("run falling.toml --json -o " + method + " --set method.name=" + method), 0) << method << err();
    const Json summary = Json::parse(out());
    EXPECT_EQ(summary["method"], method);
    EXPECT_GE(summary["events"], 1) << method;
    EXPECT_EQ(read_lines(scratch / method / "ends.csv").size(), 1u + 101u) << method;
  }
}

TEST_F(Command, SetOverridesTheSceneAsOftenAsItIsGiven) {
  ASSERT_EQ(run("run falling.toml --set time.end=0.5 --set 'output.every=0.25' -o results --json"), 0) << err();
  EXPECT_EQ(Json::parse(out())["reached_time"], 0.5);
  EXPECT_EQ(read_lines(scratch / "results/ends.csv").size(), 1u + 3u);
}

TEST_F(Command, AWrongSceneIsTheUsersErrorWithEveryFinding) {
  EXPECT_EQ(run("run falling.toml --set mesh.elements=0 --set bar.viscosity=-1 -o results"), 2);
  EXPECT_TRUE(has(err(), "mesh.elements")) << err();
  EXPECT_TRUE(has(err(), "bar.viscosity")) << err();
  EXPECT_TRUE(out().empty());
  EXPECT_FALSE(std::filesystem::exists(scratch / "results"));
  EXPECT_EQ(run("run nowhere.toml"), 2);
  EXPECT_TRUE(has(err(), "nowhere.toml")) << err();
}

TEST_F(Command, MisspeltWordsGetTheNearestKnownOne) {
  EXPECT_EQ(run("rnu falling.toml"), 2);
  EXPECT_TRUE(has(err(), "did you mean run?")) << err();
  EXPECT_EQ(run("run falling.toml --quite"), 2);
  EXPECT_TRUE(has(err(), "did you mean --quiet?")) << err();
  EXPECT_EQ(run("chekc --jsno falling.toml"), 2);
  EXPECT_TRUE(has(err(), "did you mean check?")) << err();
  EXPECT_EQ(run("run falling.toml second.toml"), 2);
  EXPECT_TRUE(has(err(), "second.toml")) << err();
  EXPECT_EQ(run("run"), 2);
  EXPECT_EQ(run(""), 2);
  EXPECT_TRUE(has(err(), "there are run, resume, check")) << err();
  EXPECT_TRUE(out().empty());
}

TEST_F(Command, HelpAndVersionAreNoErrors) {
  EXPECT_EQ(run("--help"), 0);
  EXPECT_TRUE(has(out(), "check")) << out();
  EXPECT_EQ(run("run --help"), 0);
  EXPECT_TRUE(has(out(), "--set")) << out();
  EXPECT_EQ(run("--version"), 0);
  EXPECT_TRUE(has(out(), "viscobar 0.")) << out();
}

TEST_F(Command, ADirectoryWithOtherFilesIsNotTouched) {
  std::filesystem::create_directory(scratch / "mine");
  std::ofstream(scratch / "mine/report.html") << "precious";
  EXPECT_EQ(run("run falling.toml -o mine"), 2);
  EXPECT_TRUE(has(err(), "nothing was overwritten")) << err();
  EXPECT_EQ(read_text(scratch / "mine/report.html"), "precious");
  EXPECT_EQ(run("run falling.toml -o results --quiet"), 0);
  EXPECT_EQ(run("run falling.toml -o results --quiet"), 0) << err();
}

TEST_F(Command, AFileSizeLimitIsAFailureThatKeepsWhatWasReached) {
  // In blocks of 512 or 1024 bytes: the field needs more, once it has rows, the summary does not.
  EXPECT_EQ(run("run falling.toml -o results --json --set mesh.elements=300", "ulimit -f 64; "), 1);
  EXPECT_TRUE(has(err(), "File too large")) << err();
  EXPECT_EQ(Json::parse(out())["completed"], false);
  EXPECT_EQ(Json::parse(read_text(scratch / "results/summary.json"))["completed"], false);
}

TEST_F(Command, OutputThatCannotBePrintedIsAFailure) {
  const std::string line =
      "cd '" + scratch.path().string() + "' && '" VISCOBAR_COMMAND "' check falling.toml >/dev/full 2>err.txt";
  EXPECT_EQ(WEXITSTATUS(std::system(line.c_str())), 1);
  EXPECT_TRUE(has(err(), "standard output")) << err();
}

TEST_F(Command, AnInterruptStopsCleanlyAndKeepsWhatWasReached) {
  for (const std::string signal : {"INT", "TERM"}) {
    // A run of minutes, signalled once it has rows on disk. What a shell starts in the background ignores SIGINT: env
    // undoes that.
    std::ofstream(scratch / "interrupt.sh")
        << "env --default-signal=INT '" VISCOBAR_COMMAND
           "' run falling.toml -o results --json "
           "--set method.name=fully_discrete --set time.end=1e5 >out.txt 2>err.txt &\n"
           "for i in $(seq 100); do sleep 0.1; test -s results/ends.csv && break; done\n"
           "kill -" +
               signal + " $!\nwait $!\n";
    std::filesystem::remove_all(scratch / "results");
    const int status = std::system(("cd '" + scratch.path().string() + "' && bash interrupt.sh").c_str());
    EXPECT_EQ(WEXITSTATUS(status), 130) << err();
    const Json summary = Json::parse(out());
    EXPECT_EQ(summary["completed"], false);
    EXPECT_EQ(summary["error"], "interrupted");
    EXPECT_GT(summary["reached_time"], 0.0);
    EXPECT_GT(read_lines(scratch / "results/ends.csv").size(), 1u);
    EXPECT_TRUE(std::filesystem::exists(scratch / "results/report.html"));
  }
}

TEST_F(Command, ProgressIsForTerminalsOnly) {
  // A run of minutes stopped after three seconds.
  const std::string line = "cd '" + scratch.path().string() +
                           "' && timeout -s INT 3 '" VISCOBAR_COMMAND
                           "' run falling.toml -o results --set method.name=fully_discrete --set time.end=1e6 "
                           "--set output.every=1e5";
  const int timed_out = 124;
  EXPECT_EQ(WEXITSTATUS(std::system((line + " >out.txt 2>err.txt").c_str())), timed_out);
  EXPECT_TRUE(err().starts_with("viscobar: stopped")) << err();
  EXPECT_FALSE(has(err(), "% ")) << err();
  for (const std::string option : {"", " --quiet", " --json"}) {
    const std::string terminal = shown_on_terminal(line + option + " >out.txt");
    EXPECT_TRUE(has(terminal, "stopped")) << option << ": " << terminal;
    EXPECT_EQ(has(terminal, "% "), option.empty()) << option << ": " << terminal;
  }
}

TEST_F(Command, CheckSaysWhatModelTheSceneNeeds) {
  ASSERT_EQ(run("check falling.toml --json"), 0) << err();
  const Json model = Json::parse(out());
  EXPECT_EQ(model["unknown_nodes"], 21);
  EXPECT_EQ(model["terms"]["damping"], true);
  EXPECT_EQ(model["terms"]["load"], "none");
  EXPECT_EQ(model["event_functions"], 1);
  ASSERT_EQ(model["contacts"].size(), 1u);
  EXPECT_EQ(model["contacts"][0]["impact"]["speed"], 1.0);
  EXPECT_EQ(model["contacts"][0]["chatter_expected"], false);
  EXPECT_TRUE(model["warnings"].empty());
  ASSERT_EQ(run("check falling.toml"), 0);
  EXPECT_TRUE(has(out(), "no bounce")) << out();
  EXPECT_FALSE(std::filesystem::exists(scratch / "falling.out"));
}

TEST_F(Command, CheckWarnsOfChatterAndSaysWhatHelps) {
  const std::string scene = "check falling.toml --set bar.viscosity=0.001 --set mesh.mass=consistent ";
  ASSERT_EQ(run(scene), 0);
  EXPECT_TRUE(has(err(), "it may chatter")) << err();
  for (const std::string cure :
       {"--set mesh.mass=redistributed", "--set contact.restitution=0", "--set contact.epsilon=0.06"}) {
    ASSERT_EQ(run(scene + cure), 0) << err();
    EXPECT_TRUE(err().empty()) << cure << err();
  }
}

TEST_F(Command, CheckWarnsOfAFixedEndThatWasGivenAVelocity) {
  ASSERT_EQ(run("check falling.toml --set right.kind=fixed"), 0) << err();
  EXPECT_TRUE(has(err(), "the right end is fixed, but its initial velocity is -1")) << err();
}

}  // namespace
}  // namespace viscobar

// --log, -v, colours: what is said where.
#include "cli/command.hpp"
#include "cli/terminal.hpp"

namespace viscobar {
namespace {

class Messages : public testing_cli::Command {
 protected:
  Messages() { viscobar("new scene.toml"); }
  static bool has(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

  std::string on_terminal(const std::string& arguments, const std::string& environment = "env -u NO_COLOR TERM=xterm") {
    return shown_on_terminal("cd '" + directory_.string() + "' && " + environment + " '" VISCOBAR_COMMAND "' " +
                             arguments + " >out.txt");
  }
};

TEST_F(Messages, TheLogHasTheCommandEachContactChangeAndTheExitCode) {
  const auto run = viscobar("run scene.toml --json --log run.log -o out");
  EXPECT_TRUE(run.error.empty()) << run.error;
  const std::string log = read_text(directory_ / "run.log");
  EXPECT_TRUE(has(log, "run scene.toml --json")) << log;
  EXPECT_TRUE(has(log, "A bar between two obstacles")) << log;
  EXPECT_TRUE(has(log, "exit code 0 after")) << log;
  std::size_t changes = 0;
  for (std::size_t at = 0; (at = log.find(", velocity ", at)) != log.npos; ++at) ++changes;
  EXPECT_EQ(changes, run.json()["events"]);
}

TEST_F(Messages, TheLogGrowsAndKeepsTheErrors) {
  viscobar("check scene.toml --log run.log");
  EXPECT_EQ(viscobar("check scene.toml --set bar.length=-1 --log run.log").code, 2);
  EXPECT_EQ(viscobar("check nowhere.toml --log run.log").code, 2);
  const std::string log = read_text(directory_ / "run.log");
  EXPECT_TRUE(has(log, "exit code 0")) << log;
  EXPECT_TRUE(has(log, "bar.length: must be positive")) << log;
  EXPECT_TRUE(has(log, "nowhere.toml: does not exist")) << log;
  EXPECT_TRUE(has(log, "exit code 2")) << log;
  EXPECT_FALSE(has(log, "\033"));
}

TEST_F(Messages, ALogThatCannotBeOpenedIsAFailureBeforeAnythingIsDone) {
  const auto ended = viscobar("run scene.toml --log nowhere/run.log");
  EXPECT_EQ(ended.code, 1);
  EXPECT_TRUE(has(ended.error, "nowhere/run.log")) << ended.error;
  EXPECT_FALSE(testing_cli::fs::exists(directory_ / "scene.out"));
}

TEST_F(Messages, ALogThatIsNotCompleteSaysSo) {
  for (const char* command : {"run scene.toml -q", "check scene.toml", "info scene.out"}) {
    const auto ended = viscobar(std::string(command) + " --log /dev/full");
    EXPECT_EQ(ended.code, 0);
    EXPECT_TRUE(has(ended.error, "--log: lines of the log could not be written; it is not complete")) << ended.error;
  }
}

TEST_F(Messages, VerboseSaysMoreOnStandardErrorOnly) {
  const auto quiet = viscobar("run scene.toml --json"), verbose = viscobar("run scene.toml --json -v");
  EXPECT_TRUE(quiet.error.empty());
  EXPECT_TRUE(has(verbose.error, "closes")) << verbose.error;
  EXPECT_EQ(verbose.json()["events"], quiet.json()["events"]);
}

TEST_F(Messages, ColoursAreForTerminalsThatWantThem) {
  const std::string colour = "\033[1;31mviscobar:";
  EXPECT_TRUE(has(on_terminal("info nowhere"), colour));
  EXPECT_FALSE(has(on_terminal("info nowhere", "env NO_COLOR=1 TERM=xterm"), colour));
  EXPECT_FALSE(has(on_terminal("info nowhere", "env -u NO_COLOR TERM=dumb"), colour));
  EXPECT_TRUE(has(on_terminal("info nowhere", "env NO_COLOR= TERM=xterm"), colour));
  EXPECT_FALSE(has(viscobar("info nowhere").error, "\033"));
}

TEST_F(Messages, ThreadsAreANumberFromOneUpInEveryCommandThatHasThem) {
  for (const std::string command : {"compare", "limit", "precision"})
    for (const std::string wrong : {"0", "-1", "two", "1.5"}) {
      const auto ended = viscobar(command + " scene.toml --threads " + wrong);
      EXPECT_EQ(ended.code, 2) << command << wrong;
      EXPECT_TRUE(has(ended.error, "--threads")) << ended.error;
    }
}

TEST_F(Messages, MisspeltNewCommandsAndOptionsGetTheNearestKnownOne) {
  for (const auto& [wrong, right] : {std::pair{"nwe", "new"},
                                     {"inof scene.out", "info"},
                                     {"exprot scene.out", "export"},
                                     {"lits", "list"},
                                     {"list --jsno", "--json"},
                                     {"export out --fromat csv", "--format"},
                                     {"run scene.toml --lgo x", "--log"},
                                     {"run scene.toml --verbsoe", "--verbose"}}) {
    const auto ended = viscobar(wrong);
    EXPECT_EQ(ended.code, 2) << wrong;
    EXPECT_TRUE(has(ended.error, "did you mean " + std::string(right) + "?")) << wrong << ": " << ended.error;
  }
}

}  // namespace
}  // namespace viscobar

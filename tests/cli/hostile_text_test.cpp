// Text quoted from a scene or a command line cannot steer a terminal, nor pass for a message of the program.
#include "cli/command.hpp"
#include "cli/terminal.hpp"
#include "text/printable_text.hpp"

namespace viscobar::testing_cli {
namespace {

TEST(Printable, ShowsControlCharactersAsTheirNumbers) {
  EXPECT_EQ(printable("\033]0;x\007\033[2J"), "\\u001b]0;x\\u0007\\u001b[2J");
  EXPECT_EQ(printable("\u009b2J\x7f"), "\\u009b2J\\u007f");
  EXPECT_EQ(printable("\u202egnp.exe\u2069"), "\\u202egnp.exe\\u2069");
  EXPECT_EQ(printable("a\x9b"
                      "b\xc2"),
            "a\\x9bb\\xc2");
  EXPECT_EQ(printable(std::string_view("\0", 1)), "\\u0000");
}

TEST(Printable, LeavesLettersOfEveryLanguage) {
  for (const std::string text : {"ü", "стержень", "棒", "🙂", "εpsilon = 10⁻⁴"}) EXPECT_EQ(printable(text), text);
}

TEST(Printable, LeavesLinesUnlessOneIsWanted) {
  EXPECT_EQ(printable("a\tb\nc"), "a\tb\nc");
  EXPECT_EQ(one_line("a\tb\nc"), "a\\u0009b\\u000ac");
}

class HostileText : public Command {
 protected:
  HostileText() {
    std::string text = read_text(VISCOBAR_SOURCE_DIR "/examples/scenes/unit-both-ends.toml");
    const std::size_t title = text.find("title"), end = text.find('\n', title);
    text.replace(title, end - title, R"(title = "\u001b]0;x\u0007\u001b[2J\nviscobar: fake\u009b2J")");
    std::ofstream(directory_ / "scene.toml") << text;
    std::ofstream(directory_ / "sweep.toml") << R"(title = "\u001b[2J\nviscobar: fake")"
                                             << "\nscene = \"scene.toml\"\n[set]\ntime.end = 0.1\n[vary]\n"
                                             << "mesh.elements = [4, 8]\n";
  }

  static void expect_harmless(const std::string& text, const std::string& what) {
    EXPECT_EQ(text.find('\033'), text.npos) << what;
    EXPECT_EQ(text.find('\007'), text.npos) << what;
    EXPECT_EQ(text.find("\u009b"), text.npos) << what;
    EXPECT_EQ(text.find("\nviscobar: fake"), text.npos) << what << text;
    EXPECT_EQ(text.find("Z viscobar: fake"), text.npos) << what << text;
    EXPECT_FALSE(text.starts_with("viscobar: fake")) << what;
  }
};

TEST_F(HostileText, OfATitleIsHarmlessInEveryCommand) {
  for (const std::string command :
       {"run scene.toml -v -o run", "run scene.toml --json -o run", "info run", "info run --json", "check scene.toml",
        "check scene.toml --json", "compare scene.toml --set time.end=0.1 --methods rigid,cvode -o compare",
        "limit scene.toml --set time.end=0.1 --epsilon 1e-3:1e-4 -o limit",
        "precision scene.toml --set time.end=0.1 --methods rigid --tolerance 1e-3:1e-4 --seconds 60 -o precision",
        "sweep sweep.toml -o sweep", "info sweep", "info compare", "info limit", "info precision"}) {
    const Ended ended = viscobar(command + " --log log.txt");
    EXPECT_EQ(ended.code, 0) << command << ended.error;
    expect_harmless(ended.out, command);
    expect_harmless(ended.error, command);
  }
  expect_harmless(read_text(directory_ / "log.txt"), "log");
  for (const std::string page :
       {"run/report.html", "compare/compare.html", "limit/limit.html", "precision/precision.html"})
    EXPECT_EQ(read_text(directory_ / page).find('\033'), std::string::npos) << page;
}

TEST_F(HostileText, OfPathsAndValuesIsHarmlessInMessagesAndLog) {
  const std::string bad = "$(printf '\\033[2J\\nviscobar: fake\\233')";
  for (const std::string& command :
       {"run \"" + bad + "\"", "check scene.toml --set \"title=" + bad + "\"",
        "check scene.toml --set \"bar.length=" + bad + "\"", "check scene.toml --set \"" + bad + "=1\"",
        "run scene.toml --quiet -o \"" + bad + "\"", "run scene.toml -o \"" + bad + "2\"", "info \"" + bad + "\"",
        "info \"" + bad + "\" --json", "new \"" + bad + ".toml\"", "new \"" + bad + ".toml\"", "\"" + bad + "\"",
        "run \"--" + bad + "\"", "limit scene.toml --epsilon \"" + bad + "\"", "export \"" + bad + "\"",
        "run scene.toml --checkpoint \"" + bad + "\"", "list \"" + bad + "\"",
        "check scene.toml --set \"load.density=" + bad + "\"", "sweep \"" + bad + "\""}) {
    const Ended ended = viscobar(command + " --log log.txt");
    EXPECT_TRUE(ended.code == 0 || ended.code == 2) << command << ended.code << ended.error;
    expect_harmless(ended.out, command);
    expect_harmless(ended.error, command);
  }
  expect_harmless(read_text(directory_ / "log.txt"), "log");
}

TEST_F(HostileText, IsHarmlessOnATerminal) {
  const std::string text = shown_on_terminal("cd '" + directory_.string() +
                                             "' && env NO_COLOR=1 TERM=xterm '" VISCOBAR_COMMAND
                                             "' check scene.toml -v --set bar.length=-1 2>&1 >out.txt");
  EXPECT_EQ(text.find("\033]0"), text.npos) << text;
}

}  // namespace
}  // namespace viscobar::testing_cli

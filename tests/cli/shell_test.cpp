// Completions and the man page, which ask the program for its commands, options and keys.
#include <sstream>

#include "cli/command.hpp"
#include "input/scene_keys.hpp"

namespace viscobar {
namespace {

using Words = std::vector<std::string>;

class Shell : public testing_cli::Command {
 protected:
  Shell() {
    viscobar("new scene.toml");
    std::ofstream(directory_ / "notes.txt") << "";
    testing_cli::fs::create_directory(directory_ / "folder");
  }

  /// Completions that bash offers for the last of the words.
  Words completed(const std::string& words) const {
    std::ofstream(directory_ / "ask.bash") << "viscobar() { '" VISCOBAR_COMMAND "' \"$@\"; }\nsource '" << shell
                                           << "/viscobar.bash'\nCOMP_WORDS=(viscobar " << words
                                           << ")\nCOMP_CWORD=$((${#COMP_WORDS[@]} - 1))\n_viscobar\n"
                                              "printf '%s\\n' \"${COMPREPLY[@]}\"\n";
    EXPECT_EQ(run("bash ask.bash >offered.txt"), 0);
    std::istringstream lines(read_text(directory_ / "offered.txt"));
    Words found;
    for (std::string line; std::getline(lines, line);)
      if (!line.empty()) found.push_back(line);
    return found;
  }

  std::string man_page() const {
    EXPECT_EQ(run("sh '" + shell + "/man.sh' '" VISCOBAR_COMMAND "' >viscobar.1"), 0);
    return read_text(directory_ / "viscobar.1");
  }

  int run(const std::string& line) const {
    return std::system(("cd '" + directory_.string() + "' && " + line).c_str());
  }

 private:
  const std::string shell = VISCOBAR_SOURCE_DIR "/cmake/shell";
};

TEST_F(Shell, BashCompletesCommandsAndOptions) {
  EXPECT_EQ(completed("pre"), Words{"precision"});
  EXPECT_EQ(completed("com"), Words{"compare"});
  EXPECT_EQ(completed("limit --ep"), Words{"--epsilon"});
  EXPECT_EQ(completed("run scene.toml --o"), Words{"--output"});
  EXPECT_EQ(completed("list --thr"), Words{});
}

TEST_F(Shell, BashCompletesKeysChoicesAndFiles) {
  EXPECT_EQ(completed("run scene.toml --set contact.ep"), Words{"contact.epsilon="});
  EXPECT_EQ(completed("run scene.toml --set joint.K.g"), Words{"joint.K.gap="});
  EXPECT_EQ(completed("run scene.toml --set method.name = ri"), Words{"rigid"});
  EXPECT_EQ(completed("run scene.toml --set left.kind ="), (Words{"obstacle", "free", "fixed"}));
  EXPECT_EQ(completed("limit scene.toml --mass red"), Words{"redistributed"});
  EXPECT_EQ(completed("compare scene.toml --methods rigid,fu"), Words{"rigid,fully_discrete"});
  EXPECT_EQ(completed("list me"), Words{"methods"});
  EXPECT_EQ(completed("export out --format x"), Words{"xdmf"});
  EXPECT_EQ(completed("check s"), Words{"scene.toml"});
  EXPECT_EQ(completed("check n"), Words{});  // notes.txt is no scene
  EXPECT_EQ(completed("info f"), Words{"folder"});
}

TEST_F(Shell, ManPageNamesEveryCommandOptionAndKey) {
  const std::string page = man_page();
  const auto has = [&](std::string text) {
    for (std::size_t at = 0; (at = text.find('-', at)) != text.npos; at += 2) text.replace(at, 1, "\\-");
    return page.find(text) != page.npos;
  };
  for (const std::string command :
       {"run", "resume", "check", "compare", "limit", "precision", "new", "info", "list", "export"})
    EXPECT_TRUE(has("\\fBviscobar " + command + "\\fR")) << command;
  for (const std::string option : {"--set", "--log", "--threads", "--per-decade", "--halvings", "--format"})
    EXPECT_TRUE(has("\\fB" + option + "\\fR")) << option;
  for (const SceneKey* key : listed_keys()) EXPECT_TRUE(has("\\fB" + listed_name(*key) + "\\fR")) << key->name;
}

TEST_F(Shell, ManPageIsSetWithoutWarnings) {
  if (run("groff --version >/dev/null 2>&1") != 0) GTEST_SKIP() << "groff is not installed";
  man_page();
  EXPECT_EQ(run("groff -man -ww -Tutf8 -z viscobar.1 2>warnings.txt"), 0);
  EXPECT_EQ(read_text(directory_ / "warnings.txt"), "");
}

}  // namespace
}  // namespace viscobar

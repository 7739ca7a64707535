// Every command of the pages is run as it stands there.
#include <regex>

#include "cli/command.hpp"

namespace viscobar {
namespace {

using testing_cli::content;

/// The lines of a page that are indented by four and begin with the program's name, without the remark at their end; a
/// synopsis (SCENE, [options], ALPHA for a number) is no command.
std::vector<std::string> commands_of(const std::string& page) {
  static const std::regex placeholder("\\[|\\b(SCENE|DIR|FILE|COMMAND|ALPHA|MASS|N|E)\\b"), remark("( +# | {3,}).*$");
  std::vector<std::string> found;
  std::istringstream lines(page);
  for (std::string line; std::getline(lines, line);)
    if (line.starts_with("    viscobar ") && !std::regex_search(line, placeholder))
      found.push_back(std::regex_replace(line.substr(4), remark, ""));
  return found;
}

/// The first block of TOML that is a whole scene.
std::string scene_of(const std::string& page) {
  const std::size_t begin = page.find("```toml\n");
  return begin == page.npos ? "" : page.substr(begin + 8, page.find("```", begin + 8) - begin - 8);
}

/// Commands that take seconds as built for release are left to that build.
#ifdef __SANITIZE_ADDRESS__
bool slow(const std::string& command) { return command.find("viscobar precision") != command.npos; }
#else
bool slow(const std::string&) { return false; }
#endif

struct Page {
  const char *file, *name;
  std::size_t least;  ///< so that a change of their looks does not make commands invisible
};

void PrintTo(const Page& page, std::ostream* out) { *out << page.file; }

class Docs : public testing_cli::Command, public testing::WithParamInterface<Page> {};

TEST_P(Docs, CommandsRunAsTheyStandThere) {
  const std::string page = content(testing_cli::fs::path(VISCOBAR_SOURCE_DIR) / GetParam().file);
  testing_cli::fs::create_directory_symlink(VISCOBAR_SOURCE_DIR "/examples", directory_ / "examples");
  std::ofstream(directory_ / "scene.toml") << scene_of(page);
  const std::vector<std::string> commands = commands_of(page);
  EXPECT_GE(commands.size(), GetParam().least);
  for (const std::string& command : commands) {
    if (slow(command)) continue;
    std::ofstream(directory_ / "command.bash") << "set -euo pipefail\nviscobar() { '" VISCOBAR_COMMAND "' \"$@\"; }\n"
                                               << command << "\n";
    const std::string line = "cd '" + directory_.string() + "' && bash command.bash >out.txt 2>error.txt";
    EXPECT_EQ(std::system(line.c_str()), 0) << command << "\n" << content(directory_ / "error.txt");
  }
}

INSTANTIATE_TEST_SUITE_P(OfEachPage, Docs,
                         testing::Values(Page{"README.md", "readme", 6}, Page{"docs/tutorial.md", "tutorial", 12},
                                         Page{"docs/commands.md", "commands", 20}, Page{"docs/report.md", "report", 2},
                                         Page{"docs/scene-file.md", "scene_file", 1}),
                         [](const auto& page) { return std::string(page.param.name); });

}  // namespace
}  // namespace viscobar

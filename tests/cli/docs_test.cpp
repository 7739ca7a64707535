// Every command of the pages is run as it stands there, and numbers that prose tells of them are compared with what
// they say: behind such a number, or a verdict, a page names where it stands, in a comment that readers do not see,
//
//     takes 60<!-- mine.out/summary.json at /steps --> steps
//     5.7e-06<!-- viscobar limit scene.toml --json at /rows/0/error -->
//
// a file of JSON or CSV (its columns by name) that the commands above have written, or a command that prints JSON, and
// a JSON pointer. A number holds to half a unit of its last digit, and to a tenth behind "about" or "some".
#include <algorithm>
#include <cctype>
#include <cmath>
#include <map>
#include <regex>

#include "cli/command.hpp"

namespace viscobar {
namespace {

const std::regex placeholder("\\[|\\b(SCENE|SWEEP|DIR|FILE|COMMAND|ALPHA|MASS|N|E)\\b");

/// The lines of a page that are indented by four and whose first word is that of a command, without the remark at their
/// end; a synopsis (SCENE, [options], ALPHA for a number) is no command.
std::vector<std::string> commands_of(const std::string& page, const std::regex& first_word) {
  static const std::regex remark("( +# | {3,}).*$");
  std::vector<std::string> found;
  std::istringstream lines(page);
  for (std::string line; std::getline(lines, line);)
    if (line.starts_with("    ") && std::regex_search(line.substr(4), first_word) &&
        !std::regex_search(line, placeholder))
      found.push_back(std::regex_replace(line.substr(4), remark, ""));
  return found;
}

/// A number, in digits or as a word, and where it comes from.
struct Quoted {
  std::string text, source, pointer;
};

std::vector<Quoted> numbers_of(const std::string& text) {
  static const std::regex quoted(
      "((?:about |some )?(?:[0-9][0-9.]*(?:e-?[0-9]+)?|[a-z]+))[*`]*<!-- ([^>]*) at (/[^ ]*) -->");
  std::vector<Quoted> found;
  for (std::sregex_iterator at(text.begin(), text.end(), quoted), end; at != end; ++at)
    found.push_back({(*at)[1], (*at)[2], (*at)[3]});
  return found;
}

/// True if the value is the one that the text gives.
bool says(const std::string& text, double value) {
  if (text.find(' ') != text.npos) {
    const double told = std::stod(text.substr(text.find(' ')));
    return std::abs(told - std::abs(value)) <= 0.1 * told;
  }
  static const char* const words[] = {"none", "one",   "two",   "three", "four", "five",
                                      "six",  "seven", "eight", "nine",  "ten"};
  const auto word = std::find(std::begin(words), std::end(words), text);
  if (word != std::end(words)) return value == static_cast<double>(word - std::begin(words));
  const std::size_t mark = std::min(text.find('e'), text.size()), point = text.find('.');
  const int exponent = mark < text.size() ? std::stoi(text.substr(mark + 1)) : 0;
  const int decimals = point < mark ? static_cast<int>(mark - point) - 1 : 0;
  const double unit = std::pow(10.0, exponent - decimals);
  return std::abs(std::stod(text) - std::abs(value)) <= 0.5 * unit * (1.0 + 1e-9);
}

/// The columns of a table.
nlohmann::json columns_of(const std::string& csv) {
  std::istringstream lines(csv);
  std::string line, cell;
  std::getline(lines, line);
  std::vector<std::string> names;
  for (std::istringstream head(line); std::getline(head, cell, ',');) names.push_back(cell);
  nlohmann::json table;
  while (std::getline(lines, line)) {
    std::size_t k = 0;
    for (std::istringstream row(line); std::getline(row, cell, ',') && k < names.size(); ++k) {
      char* rest = nullptr;
      const double value = std::strtod(cell.c_str(), &rest);
      table[names[k]].push_back(*rest ? nlohmann::json(cell) : nlohmann::json(value));
    }
  }
  return table;
}

/// The first block of TOML that is a whole scene.
std::string scene_of(const std::string& page) {
  const std::size_t begin = page.find("```toml\n");
  return begin == page.npos ? "" : page.substr(begin + 8, page.find("```", begin + 8) - begin - 8);
}

/// Commands that take seconds as built for release are left to that build.
#ifdef __SANITIZE_ADDRESS__
bool slow(const std::string& command) { return command.find("precision") != command.npos; }
#else
bool slow(const std::string&) { return false; }
#endif

struct Page {
  const char *file, *name;
  std::size_t least;        ///< commands at least: a change of their looks must not make them invisible
  std::size_t numbers = 0;  ///< numbers at least
};

void PrintTo(const Page& page, std::ostream* out) { *out << page.file; }

class Docs : public testing_cli::Command, public testing::WithParamInterface<Page> {
 protected:
  nlohmann::json told_by(const std::string& source) const {
    if (source.starts_with("viscobar ")) return viscobar(source.substr(9)).json();
    const std::string text = read_text(directory_ / source);
    return source.ends_with(".csv") ? columns_of(text) : nlohmann::json::parse(text);
  }
};

TEST_P(Docs, CommandsRunAsTheyStandThere) {
  const std::string page = read_text(testing_cli::fs::path(VISCOBAR_SOURCE_DIR) / GetParam().file);
  for (const std::string folder : {"examples", "tests"})
    testing_cli::fs::create_directory_symlink(testing_cli::fs::path(VISCOBAR_SOURCE_DIR) / folder, directory_ / folder);
  std::ofstream(directory_ / "scene.toml") << scene_of(page);
  const std::vector<std::string> commands = commands_of(page, std::regex("^viscobar "));
  EXPECT_GE(commands.size(), GetParam().least);
  std::size_t compared = 0;
  std::map<std::string, nlohmann::json> known;  // output of commands that ran, which stays the same below them
  const auto compare = [&](const std::string& prose) {
    for (const auto& [text, source, pointer] : numbers_of(prose)) {
      ++compared;
      if (slow(source)) continue;
      SCOPED_TRACE(text + " of " + source + " at " + pointer);
      try {
        const bool printed = source.starts_with("viscobar ");
        if (!printed || !known.contains(source)) known[source] = told_by(source);
        const nlohmann::json& value = known[source].at(nlohmann::json::json_pointer(pointer));
        EXPECT_TRUE(value.is_string() ? value == text : says(text, value.get<double>())) << value;
      } catch (const std::exception& error) {
        ADD_FAILURE() << error.what();
      }
    }
  };
  std::size_t read = 0;
  for (const std::string& command : commands) {
    const std::size_t at = page.find("    " + command, read);
    compare(page.substr(read, at - read));
    read = at + 1;
    if (slow(command)) continue;
    std::ofstream(directory_ / "command.bash") << "set -euo pipefail\nviscobar() { '" VISCOBAR_COMMAND "' \"$@\"; }\n"
                                               << command << "\n";
    const std::string line = "cd '" + directory_.string() + "' && /bin/bash command.bash >out.txt 2>error.txt";
    EXPECT_EQ(std::system(line.c_str()), 0) << command << "\n" << read_text(directory_ / "error.txt");
  }
  compare(page.substr(read));
  EXPECT_GE(compared, GetParam().numbers);
}

constexpr Page pages[] = {{"README.md", "readme", 6, 6},
                          {"docs/tutorial.md", "tutorial", 12, 15},
                          {"docs/usual-jobs.md", "usual_jobs", 5, 9},
                          {"docs/commands.md", "commands", 20},
                          {"docs/model.md", "model", 1, 3},
                          {"docs/report.md", "report", 2},
                          {"docs/scene-file.md", "scene_file", 1},
                          {"docs/penalty-limit.md", "limit", 1, 18},
                          {"docs/internals/stability.md", "stability", 1},
                          {"docs/internals/storms.md", "storms", 1},
                          {"docs/sweep.md", "sweep", 1},
                          {"docs/sensitivity.md", "sensitivity", 1},
                          {"docs/solutions-of-others.md", "solutions_of_others", 10},
                          {"docs/fit.md", "fit", 2},
                          {"docs/bars-in-line.md", "bars_in_line", 2}};

INSTANTIATE_TEST_SUITE_P(OfEachPage, Docs, testing::ValuesIn(pages),
                         [](const auto& page) { return std::string(page.param.name); });

/// Commands that no test of this file runs, and what does.
constexpr struct {
  const char *begins, *where;
} elsewhere[] = {
    {"scripts/demo", "tests/package/newcomer.bash"},
    {"scripts/test", "is what runs the tests"},
    {"scripts/benchmark", "takes minutes"},
    {"scripts/sundials", "loads a source package"},
    {"cmake --preset release -DSUNDIALS_ROOT", "scripts/benchmark --sundials"},
    {"scripts/coverage", "takes minutes"},
    {"scripts/gallery", "takes minutes"},
    {"scripts/fuzz", "takes minutes"},
    {"scripts/sensitivity-cost", "takes minutes"},
    {"scripts/fresh-machine", "takes an hour"},
    {"scripts/install-packages", "scripts/demo does"},
    {"scripts/compare-builds", "takes minutes; a slice of it is one of the tests"},
    {"scripts/campaign", "takes minutes; a slice of it is one of the tests"},
    {"build/release/tests/malformed_test", "is one of the tests"},
    {"build/release/tests/properties_test", "is one of the tests"},
    {"cmake --install", "tests/package/newcomer.bash"},
    {"cmake -G Ninja -S . -B build", "tests/package/newcomer.bash"},
    {"build/mine", "tests/package/newcomer.bash"},
    {"export PKG_CONFIG_PATH", "tests/package/newcomer.bash"},
    {"g++ -std=c++20 -O2 mine.cpp", "tests/package/newcomer.bash"},
    {"cmake --preset package", "tests/package/deb.cmake"},
    {"cmake --build --preset release --target docs", "the test of Doxygen's pages"},
    {"cmake --build --preset release --target measure_", "take minutes"},
    {"build/release/tests/measure_", "take minutes"},
    {"python3 tests/measurements/random_scenes.py", "takes minutes, and SciPy"},
    {"python3 tests/measurements/random_chains.py", "takes minutes, and SciPy"},
    {"time viscobar sweep", "takes minutes; with the same keys the chatter sweep of the page is run"},
    {"viscobar.run(", "Python.docs_test"},
    {"time={", "Python.docs_test"},
    {"mpirun ", "tests/cli/sweep_test.cpp, on fewer ranks"},
};

/// The pages of docs/ and its folders, the README and CONTRIBUTING, relative to the source directory.
std::vector<testing_cli::fs::path> all_pages() {
  namespace fs = testing_cli::fs;
  std::vector<fs::path> all = {"README.md", "CONTRIBUTING.md"};
  for (const auto& entry : fs::recursive_directory_iterator(VISCOBAR_SOURCE_DIR "/docs"))
    if (entry.path().extension() == ".md") all.push_back(fs::relative(entry.path(), VISCOBAR_SOURCE_DIR));
  return all;
}

TEST(Pages, HaveNoCommandThatNothingRuns) {
  namespace fs = testing_cli::fs;
  const std::regex command("^(viscobar|cmake|scripts/|build/|mpirun|export|g\\+\\+|time|make|ctest|python3|octave) ?");
  std::size_t seen = 0;
  for (const fs::path& file : all_pages())
    for (const std::string& line : commands_of(read_text(fs::path(VISCOBAR_SOURCE_DIR) / file), command)) {
      ++seen;
      const bool here =
          line.starts_with("viscobar ") &&
          std::any_of(std::begin(pages), std::end(pages), [&](const Page& page) { return file == page.file; });
      const bool there = std::any_of(std::begin(elsewhere), std::end(elsewhere),
                                     [&](const auto& known) { return line.starts_with(known.begins); });
      EXPECT_TRUE(here || there) << file << ": " << line;
    }
  EXPECT_GT(seen, 50u);
}

/// True if a name within [measured: names; range] is that of a test (Suite.Name, Suite.*), a command or a file that
/// exists.
bool exists(const std::string& name, const std::string& tests) {
  namespace fs = testing_cli::fs;
  const fs::path root = VISCOBAR_SOURCE_DIR;
  if (name.starts_with("viscobar ") || fs::exists(root / name)) return true;
  if (name.starts_with("measure_"))  // arguments may follow
    return fs::exists(root / "tests/measurements" / (name.substr(8, name.find(' ') - 8) + ".cpp"));
  const std::size_t last = name.rfind('/') + 1, dot = name.find('.');
  if (name.starts_with("build/release/tests/"))
    return fs::exists(root / "tests" / name.substr(last, name.size() - last - 5));
  if (dot == name.npos) return false;
  const std::string test = name.substr(dot + 1);
  return std::regex_search(
      tests, std::regex("TEST(_F|_P)?\\(" + name.substr(0, dot) + ",\\s+" + (test == "*" ? "" : test + "\\)")));
}

TEST(Pages, MeasuredSentencesNameTestsAndCommandsThatExist) {
  namespace fs = testing_cli::fs;
  const fs::path root = VISCOBAR_SOURCE_DIR;
  std::string tests;
  for (const auto& entry : fs::recursive_directory_iterator(root / "tests"))
    if (entry.path().extension() == ".cpp") tests += read_text(entry.path());
  const std::regex mark("\\[measured:\\s+([^\\]]*)\\]"), quoted("`([^`]*)`");
  std::size_t seen = 0;
  for (const fs::path& file : all_pages()) {
    if (file == "docs/README.md") continue;  // explains the marks
    const std::string page = read_text(root / file);
    for (std::sregex_iterator found(page.begin(), page.end(), mark), end; found != end; ++found) {
      const std::string inside = (*found)[1], what = inside.substr(0, inside.find(';'));
      EXPECT_TRUE(what.find('`') != what.npos) << file << " names no test: " << inside;
      for (std::sregex_iterator name(what.begin(), what.end(), quoted); name != end; ++name, ++seen)
        EXPECT_TRUE(exists((*name)[1], tests)) << file << ": " << (*name)[1];
    }
  }
  EXPECT_GT(seen, 30u);
}

/// The names by which the headings of a page are linked to: lower case, blanks as hyphens, no other punctuation.
std::vector<std::string> anchors_of(const std::string& page) {
  std::vector<std::string> anchors;
  std::istringstream lines(page);
  for (std::string line; std::getline(lines, line);) {
    const std::size_t text = line.find_first_not_of('#');
    if (text == 0 || text == line.npos || line[text] != ' ') continue;
    std::string anchor;
    for (const unsigned char c : line.substr(text + 1))
      if (std::isalnum(c) || c == '-' || c == '_' || c == ' ')
        anchor += c == ' ' ? '-' : static_cast<char>(std::tolower(c));
    anchors.push_back(anchor);
  }
  return anchors;
}

TEST(Pages, HaveNoLinkThatLeadsNowhere) {
  namespace fs = testing_cli::fs;
  const fs::path root = VISCOBAR_SOURCE_DIR;
  const std::regex link("\\]\\(([^)#]*)#?([^)]*)\\)"), code("```[^`]*```|`[^`]*`");
  std::size_t seen = 0;
  for (const fs::path& file : all_pages()) {
    const std::string page = std::regex_replace(read_text(root / file), code, "");
    for (std::sregex_iterator found(page.begin(), page.end(), link), end; found != end; ++found) {
      const std::string target = (*found)[1], anchor = (*found)[2];
      if (target.starts_with("http")) continue;
      ++seen;
      const fs::path leads_to = target.empty() ? root / file : (root / file).parent_path() / target;
      EXPECT_TRUE(fs::exists(leads_to)) << file << ": " << target;
      if (anchor.empty() || !fs::exists(leads_to)) continue;
      const std::vector<std::string> anchors = anchors_of(read_text(leads_to));
      EXPECT_NE(std::find(anchors.begin(), anchors.end(), anchor), anchors.end()) << file << ": " << found->str();
    }
  }
  EXPECT_GT(seen, 100u);
}

/// Words of the code, which the manual says in plain English; quotations of code and links are left out.
TEST(Pages, OfTheManualUseNoWordsThatOnlyTheCodeKnows) {
  const std::regex of_the_code("\\b(storm|lane|triad|referee)s?\\b", std::regex::icase);
  const std::regex quoted("`[^`]*`|\\[[^\\]]*\\]\\([^)]*\\)");
  for (const auto& file : all_pages()) {
    if (file.string().starts_with("docs/internals/") || file == "CONTRIBUTING.md") continue;
    std::istringstream lines(read_text(testing_cli::fs::path(VISCOBAR_SOURCE_DIR) / file));
    for (std::string line; std::getline(lines, line);)
      EXPECT_FALSE(std::regex_search(std::regex_replace(line, quoted, ""), of_the_code)) << file << ": " << line;
  }
}

}  // namespace
}  // namespace viscobar

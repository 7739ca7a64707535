// Comments say what a thing is: none begins with a word whose noun stands in the code, such as "What" or "Of".
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <regex>
#include <string>

namespace {

namespace fs = std::filesystem;

/// True if the line is or has such a comment. Behind code "of" and "that" belong to the name before them.
bool is_headless(const std::string& line) {
  static const std::regex alone(R"(^\s*//[/<]* (What|Of|Whether|That|Likewise)\b)"),
      behind_code(R"(\S\s+//[/<]* ([Ww]hat|[Ww]hether|[Ll]ikewise)\b)");
  return line.find("//") != line.npos && (std::regex_search(line, alone) || std::regex_search(line, behind_code));
}

TEST(Comments, SayWhatAThingIs) {
  std::size_t seen = 0;
  for (const std::string root : {"src", "include", "python", "tests", "examples"})
    for (const auto& entry : fs::recursive_directory_iterator(fs::path(VISCOBAR_SOURCE_DIR) / root)) {
      const std::string file = fs::relative(entry.path(), VISCOBAR_SOURCE_DIR).string();
      if (!file.ends_with(".cpp") && !file.ends_with(".hpp")) continue;
      std::ifstream source(entry.path());
      std::string line;
      for (std::size_t number = 1; std::getline(source, line); ++number, ++seen)
        EXPECT_FALSE(is_headless(line)) << file << ":" << number << ": begin with what the thing is, not with\n"
                                        << line;
    }
  EXPECT_GT(seen, 50'000u);
}

TEST(Comments, ThatDoNotSayItAreFound) {
  for (const char* line : {"/// What a step costs.", "\t// Of runs.", "///< Likewise.", "// Whether it holds.",
                           "// That one.", "bool b;\t///< whether it holds"})
    EXPECT_TRUE(is_headless(line)) << line;
  for (const char* line : {"// Whatever holds.", "// of runs, and that of steps", "double h;\t///< of the mesh",
                           "url = \"http://of what\";", "//"})
    EXPECT_FALSE(is_headless(line)) << line;
}

}  // namespace

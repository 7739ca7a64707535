#include "integration/sundials/return_flags.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <map>
#include <regex>
#include <set>

namespace viscobar::sundials {
namespace {

// Negative values defined as PREFIX_NAME in the headers of a library.
std::map<std::string, int> defined(const std::string& library, const std::string& prefix) {
  const std::regex line("^#define +(" + prefix + "_[A-Z_]+) +\\(?(-[0-9]+)\\)?.*");
  std::map<std::string, int> flags;
  for (const auto& header : std::filesystem::directory_iterator(VISCOBAR_SUNDIALS_HEADERS "/" + library)) {
    std::ifstream file(header.path());
    std::smatch match;
    for (std::string text; std::getline(file, text);)
      if (std::regex_match(text, match, line)) flags[match[1]] = std::stoi(match[2]);
  }
  flags.erase("ARK_ADAPT_CUSTOM");  // a choice, no failure
  return flags;
}

struct Library {
  const char *folder, *prefix;
  std::span<const ReturnFlag> known;
};

const Library libraries[] = {
    {"cvode", "CV", cvode_flags()}, {"ida", "IDA", ida_flags()}, {"arkode", "ARK", arkode_flags()}};

TEST(ReturnFlags, AreThoseOfTheHeadersEachWithWordsOfItsOwn) {
  for (const Library& library : libraries) {
    std::set<int> headers, values;
    for (const auto& [name, value] : defined(library.folder, library.prefix)) headers.insert(value);
    std::set<std::string_view> meanings;
    for (const ReturnFlag& flag : library.known) {
      EXPECT_LT(flag.value, 0);
      EXPECT_TRUE(headers.contains(flag.value)) << library.folder << " " << flag.value;
      EXPECT_TRUE(values.insert(flag.value).second) << library.folder << " " << flag.value;
      EXPECT_TRUE(meanings.insert(flag.meaning).second) << flag.meaning << ": says nothing of its own";
      EXPECT_EQ(&return_flag(library.known, flag.value), &flag);
    }
  }
}

// A later release may have new ones.
TEST(ReturnFlags, ThatNoSceneBringsAboutAreDefects) {
  for (const Library& library : libraries) {
    std::size_t defects = 0;
    for (const auto& [name, value] : defined(library.folder, library.prefix))
      defects += return_flag(library.known, value).why == Failure::defect;
    EXPECT_GE(defects, 10u) << library.folder;
    EXPECT_EQ(return_flag(library.known, 1).why, Failure::defect);
  }
}

// Whatever it is called there: the same failure has the same reason in each library.
TEST(ReturnFlags, OfTheSameNameHaveTheSameReasonInEachLibrary) {
  std::map<std::string, Failure> reasons;
  for (const Library& library : libraries)
    for (const auto& [name, value] : defined(library.folder, library.prefix)) {
      const std::string bare = name.substr(name.find('_') + 1);
      if (bare == "ILL_INPUT") continue;  // of IDA also an end that is too near
      const Failure why = return_flag(library.known, value).why;
      EXPECT_EQ(reasons.try_emplace(bare, why).first->second, why) << name;
    }
}

}  // namespace
}  // namespace viscobar::sundials

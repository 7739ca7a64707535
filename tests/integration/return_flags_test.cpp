#include "integration/sundials/return_flags.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <map>
#include <regex>
#include <set>

namespace viscobar::sundials::testing_return_flags {
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

struct Headers {
  const char *folder, *prefix;
  Library library;
};

const Headers libraries[] = {
    {"cvode", "CV", Library::cvode}, {"ida", "IDA", Library::ida}, {"arkode", "ARK", Library::arkode}};

TEST(ReturnFlags, AreThoseOfTheHeadersEachWithWordsOfItsOwn) {
  std::set<std::string_view> meanings;
  for (const ReturnFlag& flag : return_flags())
    EXPECT_TRUE(meanings.insert(flag.meaning).second) << flag.meaning << ": says nothing of its own";
  for (const auto& [folder, prefix, library] : libraries) {
    std::set<int> headers, values;
    for (const auto& [name, value] : defined(folder, prefix)) headers.insert(value);
    for (const ReturnFlag& flag : return_flags()) {
      const int value = flag.values[static_cast<std::size_t>(library)];
      if (value == 0) continue;
      EXPECT_LT(value, 0);
      EXPECT_TRUE(headers.contains(value)) << folder << " " << value;
      EXPECT_TRUE(values.insert(value).second) << folder << " " << value;
      EXPECT_EQ(&return_flag(library, value), &flag);
    }
    EXPECT_GE(values.size(), 13u) << folder;
  }
}

// A later release may have new ones.
TEST(ReturnFlags, ThatNoSceneBringsAboutAreDefects) {
  for (const auto& [folder, prefix, library] : libraries) {
    std::size_t defects = 0;
    for (const auto& [name, value] : defined(folder, prefix))
      defects += return_flag(library, value).why == Failure::defect;
    EXPECT_GE(defects, 10u) << folder;
    for (const int value : {0, 1}) EXPECT_EQ(return_flag(library, value).why, Failure::defect);
  }
}

// Whatever it is called there: the same failure has the same reason in each library.
TEST(ReturnFlags, OfTheSameNameHaveTheSameReasonInEachLibrary) {
  std::map<std::string, Failure> reasons;
  for (const auto& [folder, prefix, library] : libraries)
    for (const auto& [name, value] : defined(folder, prefix)) {
      const std::string bare = name.substr(name.find('_') + 1);
      if (bare == "ILL_INPUT") continue;  // of IDA also an end that is too near
      const Failure why = return_flag(library, value).why;
      EXPECT_EQ(reasons.try_emplace(bare, why).first->second, why) << name;
    }
}

}  // namespace
}  // namespace viscobar::sundials::testing_return_flags

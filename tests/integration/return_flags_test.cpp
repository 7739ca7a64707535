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
  std::size_t least;  // flags of 6.4.1
};

TEST(ReturnFlags, EveryFailureOfTheHeadersHasWordsAndARemedyOfItsOwn) {
  for (const Library& library : {Library{"cvode", "CV", cvode_flags(), 30}, Library{"ida", "IDA", ida_flags(), 28},
                                 Library{"arkode", "ARK", arkode_flags(), 43}}) {
    const auto flags = defined(library.folder, library.prefix);
    EXPECT_GE(flags.size(), library.least) << library.folder;
    const std::string unknown = explanation(library.known, 1);
    for (const auto& [name, value] : flags) {
      const std::string words = explanation(library.known, value);
      EXPECT_NE(words, unknown) << name;
      EXPECT_GT(words.find(';'), 10u) << name << ": " << words;
    }
    std::set<int> values;
    std::set<std::string_view> meanings;
    for (const ReturnFlag& flag : library.known) {
      EXPECT_LT(flag.value, 0);
      EXPECT_TRUE(values.insert(flag.value).second) << library.folder << " " << flag.value;
      EXPECT_TRUE(meanings.insert(flag.meaning).second) << flag.meaning << ": says nothing of its own";
      EXPECT_FALSE(flag.remedy.empty()) << flag.meaning;
    }
  }
}

TEST(ReturnFlags, RemediesOfTheUsersMakingNameAKeyOfTheScene) {
  const std::regex key(R"((method|contact|mesh|load|time|output|bar|initial)\.[a-z_]+)");
  for (const auto known : {cvode_flags(), ida_flags(), arkode_flags()})
    for (const ReturnFlag& flag : known)
      EXPECT_TRUE(std::regex_search(std::string(flag.remedy), key)) << flag.meaning << "; " << flag.remedy;
}

}  // namespace
}  // namespace viscobar::sundials

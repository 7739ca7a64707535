// `viscobar list` and what the pages say are the same table.
#include <fmt/format.h>

#include "cli/command.hpp"
#include "input/vocabulary.hpp"
#include "viscobar/case/case.hpp"

namespace viscobar {
namespace {

using List = testing_cli::Command;

/// Text of docs/scene-file.md between the comment that names a command and the next comment.
std::string between_comments(const std::string& page, const std::string& command) {
  const std::string opening = "<!-- " + command + " -->\n";
  const std::size_t begin = page.find(opening);
  if (begin == std::string::npos) return "not on the page";
  return page.substr(begin + opening.size(), page.find("<!-- -->", begin) - begin - opening.size());
}

TEST_F(List, IsWhatThePageOfTheSceneFileHolds) {
  const std::string page = read_text(VISCOBAR_SOURCE_DIR "/docs/scene-file.md");
  for (const std::string what : {"methods", "masses", "keys"}) {
    const auto listed = viscobar("list " + what + " --markdown");
    EXPECT_EQ(listed.code, 0);
    EXPECT_EQ(between_comments(page, "viscobar list " + what + " --markdown"), listed.out) << what;
  }
}

TEST_F(List, NamesEveryMethodAndMassInTheirOrder) {
  const auto json = viscobar("list --json").json();
  ASSERT_EQ(json["methods"].size(), 1 + std::size(all_methods));
  EXPECT_EQ(json["methods"][0]["method"], automatic);
  for (std::size_t i = 0; i < std::size(all_methods); ++i) {
    EXPECT_EQ(json["methods"][i + 1]["method"], name(all_methods[i]));
    EXPECT_EQ(json["methods"][i + 1]["needs_step"], is_scheme(all_methods[i]));
  }
  EXPECT_EQ(json["masses"].size(), std::size(all_masses));
  EXPECT_EQ(json["keys"].size(), scene_keys().size() + member_keys().size());
  const std::string page = markdown(vocabulary_table(Vocabulary::keys));
  for (const SceneKey* key : listed_keys())
    EXPECT_NE(page.find(fmt::format("`{}`", listed_name(*key))), page.npos) << key->name;
}

TEST_F(List, GivesTheLimitsAndDefaultsOfAKey) {
  const auto listed = viscobar("list keys --json").json()["keys"];
  const auto find = [&](const std::string& name) {
    for (const auto& key : listed)
      if (key["key"] == name) return key;
    return nlohmann::json();
  };
  EXPECT_EQ(find("contact.restitution")["limits"], nlohmann::json({{"low", 0.0}, {"high", 1.0}}));
  EXPECT_EQ(find("bar.density")["default"], 1.0);
  EXPECT_EQ(find("method.name")["default"], automatic);
  EXPECT_EQ(find("bar.length")["required"], "always");
  EXPECT_EQ(find("bar.length")["unit"], "length");
  EXPECT_EQ(find("bar.K.length")["required"], "never");
  EXPECT_EQ(find("joint.K.kind")["choices"], nlohmann::json({"bonded", "contact", "spring"}));
}

TEST_F(List, WithoutAWordPrintsAllThatItsWordsPrint) {
  const std::string all = viscobar("list").out;
  for (const std::string what : {"methods", "masses", "keys"}) {
    const auto one = viscobar("list " + what);
    EXPECT_EQ(one.code, 0);
    EXPECT_NE(all.find(one.out), std::string::npos) << what;
    EXPECT_EQ(one.out.find('`'), std::string::npos);
  }
}

TEST_F(List, OfAMisspeltWordNamesTheNearest) {
  const auto ended = viscobar("list mehtods");
  EXPECT_EQ(ended.code, 2);
  EXPECT_NE(ended.error.find("did you mean methods?"), std::string::npos) << ended.error;
}

}  // namespace
}  // namespace viscobar

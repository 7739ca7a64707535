#include "cli/command.hpp"
#include "input/vocabulary.hpp"
#include "viscobar/input/scene_file.hpp"

namespace viscobar {
namespace {

using New = testing_cli::Command;

TEST_F(New, WritesASceneThatIsSoundAndRunsAsItIs) {
  ASSERT_EQ(viscobar("new mine.toml").code, 0);
  EXPECT_EQ(viscobar("check mine.toml").code, 0);
  const auto run = viscobar("run mine.toml --json");
  EXPECT_EQ(run.code, 0) << run.error;
  EXPECT_EQ(run.json()["completed"], true);
  EXPECT_GT(run.json()["events"], 0);
}

TEST_F(New, NeverOverwrites) {
  std::ofstream(directory_ / "mine.toml") << "precious";
  const auto ended = viscobar("new mine.toml");
  EXPECT_EQ(ended.code, 2);
  EXPECT_NE(ended.error.find("nothing was overwritten"), std::string::npos) << ended.error;
  EXPECT_EQ(read_text(directory_ / "mine.toml"), "precious");
  EXPECT_EQ(viscobar("new nowhere/mine.toml").code, 1);
}

TEST_F(New, WithoutAFilePrintsWhatItWouldWrite) {
  const auto printed = viscobar("new");
  EXPECT_EQ(printed.code, 0);
  EXPECT_EQ(printed.out, scene_template());
  viscobar("new mine.toml");
  EXPECT_EQ(read_text(directory_ / "mine.toml"), printed.out);
}

TEST(SceneTemplate, HasEveryKeyOnceWithItsMeaning) {
  // Comments are broken into lines: compared without the breaks.
  std::string text = scene_template();
  std::string unbroken = text;
  for (std::size_t at = 0; (at = unbroken.find("\n# ", at)) != unbroken.npos;) unbroken.erase(at, 2);
  std::string table;
  std::size_t found = 0;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    if (line.starts_with("# ")) continue;
    const std::string bare = line.starts_with('#') ? line.substr(1) : line;
    if (bare.starts_with('[')) table = bare.substr(1, bare.find(']') - 1);
    if (const std::size_t equals = bare.find(" = "); equals != bare.npos) {
      const SceneKey* key = find_scene_key(table, bare.substr(0, equals));
      ASSERT_NE(key, nullptr) << line;
      EXPECT_NE(unbroken.find(std::string(key->meaning)), unbroken.npos) << key->name;
      ++found;
    }
    EXPECT_LE(line.size(), 100u);
  }
  EXPECT_EQ(found, scene_keys().size());
}

TEST(SceneTemplate, ShowsOnlyValuesThatTheirKeysMayHave) {
  // Each that is commented out, set by itself; a gap, a profile or a history alone would lack its partner.
  std::string table;
  std::istringstream lines(scene_template());
  for (std::string line; std::getline(lines, line);) {
    if (line.find('[') < 2) table = line.substr(line.find('[') + 1, line.find(']') - line.find('[') - 1);
    if (!line.starts_with('#') || line.starts_with("# ") || line.starts_with("#[")) continue;
    const std::string key = table + "." + line.substr(1, line.find(' ') - 1);
    const std::string value = line.substr(line.find('=') + 1);
    if (value == " ") continue;
    std::vector<std::string> overrides{key + "=" + value};
    if (key == "load.profile") overrides.push_back("load.history=1");
    if (key == "load.history") overrides.push_back("load.profile=1");
    if (key == "span.side") overrides = {"span.gap=0.2", "span.side=" + value};
    if (key.ends_with(".motion"))  // of a fixed end, which has no gap
      for (const char* beside : {".kind=fixed", ".gap="}) overrides.push_back(table + beside);
    if (key == "accuracy.of") overrides.push_back("accuracy.error=1e-4");
    if (key == "span.gap") overrides.push_back("contact.epsilon=1e-3");
    if (const auto at = key.find("contact."); at != key.npos && key != "contact.epsilon") {  // the rest of the law
      const std::string law = key.substr(0, at + 8), leaf = key.substr(at + 8);
      const bool at_speed = leaf == "speed" || (leaf == "restitution" && at > 0);
      if (at_speed) overrides.push_back(law + (leaf == "speed" ? "restitution=0.5" : "speed=2"));
      if (leaf != "law" && (at_speed || leaf != "restitution"))
        overrides.push_back(law + (at_speed ? "law=hunt_crossley" : "law=spring_damper"));
      if (leaf != "stiffness" && (at_speed || leaf != "restitution")) overrides.push_back(law + "stiffness=1");
    }
    EXPECT_NO_THROW(parse_scene(scene_template(), "template", overrides)) << overrides.front();
  }
}

}  // namespace
}  // namespace viscobar

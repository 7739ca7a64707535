#include "cli/command.hpp"

namespace viscobar {
namespace {

class Info : public testing_cli::Command {
 protected:
  Info() { viscobar("new scene.toml"); }
  static bool has(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }
};

TEST_F(Info, TellsOfARunWhatItsSummarySays) {
  const auto summary = viscobar("run scene.toml --json -o out").json();
  const auto info = viscobar("info out --json").json();
  ASSERT_EQ(info["results"].size(), 1u);
  const auto& run = info["results"][0];
  EXPECT_EQ(run["kind"], "run");
  EXPECT_EQ(run["title"], summary["title"]);
  EXPECT_EQ(run["completed"], true);
  EXPECT_EQ(run["reached_time"], summary["reached_time"]);
  EXPECT_EQ(run["contact_changes"], summary["events"]);
  EXPECT_EQ(run["wall_seconds"], summary["wall_seconds"]);
  EXPECT_FALSE(run.contains("error"));
  std::size_t files = 0;
  for (const auto& file : info["files"]) {
    EXPECT_EQ(file["bytes"], testing_cli::fs::file_size(directory_ / "out" / file["name"].get<std::string>()));
    ++files;
  }
  EXPECT_EQ(files, 6u);
  const auto text = viscobar("info out");
  EXPECT_TRUE(has(text.out, "A bar between two obstacles")) << text.out;
  EXPECT_TRUE(has(text.out, "field.h5")) << text.out;
}

TEST_F(Info, TellsOfEveryStudyInTheDirectory) {
  viscobar("compare scene.toml --methods rigid,cvode --quiet -o out");
  viscobar("limit scene.toml --epsilon 1e-3:1e-4 --quiet -o out");
  viscobar("precision scene.toml --methods rigid --tolerance 1e-3:1e-4 --quiet -o out");
  const auto results = viscobar("info out --json").json()["results"];
  ASSERT_EQ(results.size(), 3u);
  EXPECT_EQ(results[0]["kind"], "compare");
  EXPECT_EQ(results[0]["methods"], nlohmann::json({"rigid", "cvode"}));
  EXPECT_EQ(results[0]["nearest_to_reference"], "cvode");
  EXPECT_EQ(results[1]["kind"], "limit");
  EXPECT_EQ(results[1]["rows"], 2);
  EXPECT_EQ(results[2]["kind"], "precision");
  EXPECT_EQ(results[2]["methods"], nlohmann::json({"rigid"}));
  for (const auto& result : results) {
    EXPECT_EQ(result["completed"], true) << result;
    EXPECT_EQ(result["title"], "A bar between two obstacles");
  }
  EXPECT_EQ(viscobar("info out").code, 0);
}

TEST_F(Info, TellsWhyARunIsNotComplete) {
  EXPECT_NE(viscobar("run scene.toml --quiet -o out --set 'load.density=sqrt(3-t)'").code, 0);
  const auto run = viscobar("info out --json").json()["results"][0];
  EXPECT_EQ(run["completed"], false);
  EXPECT_LT(run["reached_time"], 3.01);
  EXPECT_FALSE(run["error"].get<std::string>().empty());
}

TEST_F(Info, OfADirectoryWithoutResultIsTheUsersError) {
  EXPECT_EQ(viscobar("info .").code, 2);
  EXPECT_EQ(viscobar("info nowhere").code, 2);
  EXPECT_EQ(viscobar("info scene.toml").code, 2);
  testing_cli::fs::create_directory(directory_ / "out");
  std::ofstream(directory_ / "out/summary.json") << "{\"title\": ";
  const auto ended = viscobar("info out");
  EXPECT_EQ(ended.code, 1);
  EXPECT_TRUE(has(ended.error, "summary.json")) << ended.error;
}

}  // namespace
}  // namespace viscobar

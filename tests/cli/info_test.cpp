#include "cli/command.hpp"
#include "sweep/sweep_table.hpp"
#include "viscobar/sweep/sweep.hpp"

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
  EXPECT_EQ(files, 7u);
  const auto text = viscobar("info out");
  EXPECT_TRUE(has(text.out, "A bar between two obstacles")) << text.out;
  EXPECT_TRUE(has(text.out, "field.h5")) << text.out;
}

TEST_F(Info, CountsADirectoryOfPicturesAsOne) {
  viscobar("run scene.toml --quiet --figures -o out");
  std::uintmax_t pictures = 0;
  for (const auto& picture : testing_cli::fs::directory_iterator(directory_ / "out/figures"))
    pictures += picture.file_size();
  const auto info = viscobar("info out --json").json();
  const auto found = std::ranges::find(info["files"], "figures/", [](const auto& file) { return file["name"]; });
  ASSERT_NE(found, info["files"].end()) << info;
  EXPECT_GT(pictures, 0u);
  EXPECT_EQ((*found)["bytes"], pictures);
}

// Each picture has a name of its own: what a command says of its files stays true beside another.
TEST_F(Info, PicturesOfAllCommandsAreSoundInOneDirectory) {
  for (const char* command : {"run scene.toml", "compare scene.toml --methods rigid,cvode --set contact.epsilon=1e-6",
                              "compare scene.toml --with out/ends.csv", "limit scene.toml --epsilon 1e-3:1e-4",
                              "precision scene.toml --methods rigid --tolerance 1e-3:1e-4 --seconds 60",
                              "fit scene.toml --data out/ends.csv --parameters bar.viscosity"})
    ASSERT_LE(viscobar(std::string(command) + " --quiet --figures -o out").code, 1) << command;
  const auto verified = viscobar("info out --verify --json").json();
  EXPECT_EQ(verified["verdict"], "sound");
  std::size_t pictures = 0;
  for (const auto& file : verified["files"]) {
    EXPECT_EQ(file["state"], "sound") << file;
    pictures += file["name"].get<std::string>().starts_with("figures/");
  }
  EXPECT_GT(pictures, 20u);
}

TEST_F(Info, TellsOfEveryStudyInTheDirectory) {
  viscobar("compare scene.toml --methods rigid,cvode --set contact.epsilon=1e-6 --quiet -o out");
  viscobar("limit scene.toml --epsilon 1e-3:1e-4 --quiet -o out");
  viscobar("precision scene.toml --methods rigid --tolerance 1e-3:1e-4 --seconds 60 --quiet -o out");
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

TEST_F(Info, TellsOfASweepHowManyRowsItHasAndHowManyFailed) {
  std::ofstream(directory_ / "sweep.toml")
      << "scene = \"scene.toml\"\n[set]\nmethod.name = \"cvode\"\ncontact.epsilon = 1e-6\ntime.end = "
         "1.0\n[vary]\nmesh.mass = [\"consistent\", \"redistributed\"]\n"
         "mesh.elements = [8, 16]\nbar.viscosity = [0.0, 0.1]\n";
  EXPECT_EQ(viscobar("sweep sweep.toml --quiet -o out").code, 1);  // cvode refuses massless nodes without viscosity
  const auto sweep = viscobar("info out --json").json()["results"][0];
  EXPECT_EQ(sweep["kind"], "sweep");
  EXPECT_EQ(sweep["cases"], 8);
  EXPECT_EQ(sweep["done"], 8);
  EXPECT_EQ(sweep["failed"], 2);
  EXPECT_EQ(sweep["remaining"], 0);
  EXPECT_EQ(sweep["completed"], false);
  EXPECT_EQ(sweep["keys"], nlohmann::json({"mesh.mass", "mesh.elements", "bar.viscosity"}));
  EXPECT_EQ(viscobar("info out/sweep.h5 --json").json()["results"][0], sweep);
}

TEST_F(Info, TellsOfASweepThatIsNotAtItsEndWhatRemains) {
  std::ofstream(directory_ / "sweep.toml") << "scene = \"scene.toml\"\n[vary]\nmesh.elements = [8, 16, 32]\n";
  const SweepFile sweep = read_sweep(directory_ / "sweep.toml");
  testing_cli::fs::create_directory(directory_ / "out");
  SweepTable table(directory_ / "out/sweep.h5", sweep.plan, sweep.identity());
  SweepRow row;
  row.index = 1;
  row.completed = true;
  table.write(row);
  table.commit();
  const auto info = viscobar("info out --json").json()["results"][0];  // the table is open, and locked, here
  EXPECT_EQ(info["done"], 1);
  EXPECT_EQ(info["remaining"], 2);
  EXPECT_EQ(info["completed"], false);
  EXPECT_EQ(viscobar("info out --verify").code, 0) << "so does the table of a sweep that was killed look";
}

TEST_F(Info, VerifiesAResultAgainstItsChecksums) {
  viscobar("run scene.toml --quiet -o out");
  const auto sound = viscobar("info out --verify --json");
  EXPECT_EQ(sound.code, 0) << sound.out;
  EXPECT_EQ(sound.json()["verdict"], "sound");
  EXPECT_EQ(sound.json()["files"].size(), 7u);
  const auto sound_files = sound.json()["files"];
  for (const auto& file : sound_files) EXPECT_EQ(file["state"], "sound") << file;

  std::ofstream(directory_ / "out/notes.txt") << "my own";
  EXPECT_EQ(viscobar("info out --verify").code, 0);
  std::fstream(directory_ / "out/ends.csv", std::ios::in | std::ios::out).seekp(100).put('!');
  testing_cli::fs::remove(directory_ / "out/events.csv");
  const auto damaged = viscobar("info --verify out --json");
  EXPECT_EQ(damaged.code, 1) << damaged.out;
  EXPECT_EQ(damaged.json()["verdict"], "damaged");
  const auto damaged_files = damaged.json()["files"];
  for (const auto& file : damaged_files)
    EXPECT_EQ(file["state"], file["name"] == "ends.csv"     ? "damaged"
                             : file["name"] == "events.csv" ? "missing"
                             : file["name"] == "notes.txt"  ? "not of the result"
                                                            : "sound");
  const auto text = viscobar("info --verify out");
  EXPECT_TRUE(has(text.out, "out: damaged")) << text.out;
  EXPECT_TRUE(has(text.out, "ends.csv: its checksum is not the one that was written")) << text.out;
}

TEST_F(Info, VerifiesAFitToo) {
  viscobar("run scene.toml --quiet -o out");
  ASSERT_EQ(viscobar("fit scene.toml --data out/ends.csv --parameters bar.viscosity --quiet -o fitted").code, 0);
  const auto sound = viscobar("info fitted --verify --json");
  EXPECT_EQ(sound.code, 0) << sound.out;
  EXPECT_EQ(sound.json()["files"].size(), 2u);
  std::ofstream(directory_ / "fitted/fit.html", std::ios::app) << "!";
  EXPECT_EQ(viscobar("info fitted --verify").code, 1);
}

TEST_F(Info, CannotVerifyAResultWithoutChecksums) {
  viscobar("run scene.toml --quiet -o out");
  auto summary = nlohmann::ordered_json::parse(read_text(directory_ / "out/summary.json"));
  for (const char* key : {"files", "crc64"}) summary.erase(key);
  std::ofstream(directory_ / "out/summary.json") << summary.dump(2) << "\n";
  const auto old = viscobar("info out --verify --json");
  EXPECT_EQ(old.code, 2) << old.out;
  EXPECT_EQ(old.json()["verdict"], "not checkable");
  const auto old_files = old.json()["files"];
  for (const auto& file : old_files) EXPECT_EQ(file["state"], "not checkable") << file;
  EXPECT_EQ(viscobar("info nowhere --verify").code, 2);
  EXPECT_EQ(viscobar("info . --verify").code, 2);
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

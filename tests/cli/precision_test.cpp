#include <cmath>
#include <set>
#include <string>
#include <vector>

#include "cli/command.hpp"

namespace viscobar::testing_cli {
namespace {

using Json = nlohmann::json;

class Precision : public Command {
 protected:
  Json study(const std::string& arguments) const {
    const Ended ended = viscobar("precision " + arguments + " --json --repeat 3 --seconds 60");
    EXPECT_EQ(ended.code, 0) << ended.error;
    return ended.code == 0 ? ended.json() : Json::object();
  }
  const std::string few_ = " --tolerance 1e-4:1e-6 --halvings 2";
};

TEST_F(Precision, RowsHaveWhatScriptsRelyOn) {
  const Json result = study(scene("unit-both-ends") + few_);
  ASSERT_EQ(result["rows"].size(), 5u * 3u + 2u * 3u)
      << "cvode, ida, arkode, odeint, rigid; fully_discrete, finite_difference";
  for (const Json& row : result["rows"]) {
    for (const char* key :
         {"method", "label", "error", "seconds", "steps", "runs", "elements", "mass", "space", "time", "largest_part"})
      EXPECT_TRUE(row.contains(key) && !row[key].is_null()) << key << " in " << row;
    EXPECT_EQ(row["runs"], 3);
    EXPECT_GT(row["seconds"].get<double>(), 0.0);
    EXPECT_TRUE(row.contains("tolerance") != row.contains("step")) << row;
    EXPECT_TRUE(row["failure"].is_null());
    const bool exact = row["method"] == "rigid" || row.contains("step");
    EXPECT_EQ(row["penalty"].is_null(), exact) << row;
  }
  EXPECT_EQ(result["reference"]["kind"], "finer run");
  EXPECT_GT(result["reference"]["error"].get<double>(), 0.0);
  EXPECT_NE(result["reference"]["description"].get<std::string>().find("rigid on"), std::string::npos);
  EXPECT_EQ(result["parts"].size(), 7u);
  for (const Json& parts : result["parts"])
    EXPECT_NE(parts["advice"].get<std::string>().find("dominates"), std::string::npos);
  EXPECT_NE(result["norm"].get<std::string>().find("in the unit of u"), std::string::npos);
}

// The scene names no epsilon: the study tells which one each mesh ran with, and advises from there.
TEST_F(Precision, AChosenPenaltyIsToldAndJudged) {
  const Json result = study(scene("unit-both-ends") + few_ + " --methods cvode --set contact.epsilon= --elements 9,27");
  ASSERT_EQ(result["parts"].size(), 2u);
  EXPECT_GT(result["parts"][0]["epsilon"].get<double>(), result["parts"][1]["epsilon"].get<double>());
  EXPECT_GT(result["parts"][1]["epsilon"].get<double>(), 0.0);
  for (const Json& parts : result["parts"])
    EXPECT_EQ(parts["advice"].get<std::string>().find("nan"), std::string::npos) << parts["advice"];
}

TEST_F(Precision, AnUndampedSceneIsMeasuredAgainstItsExactSolution) {
  const Json result = study(scene("period-3") + few_ + " --methods rigid,fully_discrete --set mesh.elements=20");
  EXPECT_EQ(result["reference"]["kind"], "closed form");
  EXPECT_LT(result["reference"]["error"], 1e-13) << "a few thousand roundings of displacements of 0.2";
  EXPECT_NE(result["reference"]["what"].get<std::string>().find("characteristics"), std::string::npos);
}

TEST_F(Precision, SeveralMeshesAreNamedInTheLabels) {
  const Json result = study(scene("unit-both-ends") + " --tolerance 1e-5 --methods rigid --elements 9,18");
  ASSERT_EQ(result["rows"].size(), 2u);
  EXPECT_EQ(result["rows"][1]["elements"], 18);
  EXPECT_EQ(result["rows"][0]["label"], "9 elements, tolerance 1e-05");
}

TEST_F(Precision, TheTableNamesThePartsTheNormAndTheReference) {
  const Ended ended = viscobar("precision " + scene("unit-both-ends") + few_ + " --seconds 60 -o out");
  EXPECT_EQ(ended.code, 0) << ended.error;
  for (const char* word :
       {"space", "penalty", "time", "largest part", "dominates", "buys nothing", "Errors are against",
        "in the unit of u", "out/precision.html", "error, measured", "measured, where `run` and `check` estimate it"})
    EXPECT_NE(ended.out.find(word), std::string::npos) << word;
  const std::string page = read_text(directory_ / "out" / "precision.html");
  EXPECT_NE(page.find("<svg"), std::string::npos);
  EXPECT_EQ(page.find(" src="), std::string::npos) << "the page must need no other file";
  const Json document = Json::parse(read_text(directory_ / "out" / "precision.json"));
  std::set<std::string> methods;
  for (const Json& row : document["rows"]) methods.insert(row["method"]);
  EXPECT_EQ(methods.size(), 7u);
}

TEST_F(Precision, AnOrderThatIsNotSettledIsNullAndToldSo) {
  // Chatter: from mesh to mesh bounces come and go, and the undamped penalty has bounces that the limit has not.
  const std::string study = "precision " + scene("chatter") + " --methods cvode --tolerance 1e-4:1e-5";
  const Json result = viscobar(study + " --json").json();
  EXPECT_TRUE(result["reference"]["order"].is_null()) << result["reference"];
  EXPECT_TRUE(result["parts"][0]["penalty_order"].is_null()) << result["parts"];
  EXPECT_GT(result["parts"][0]["penalty"].get<double>(), 0.0);
  const std::string text = viscobar(study).out;
  EXPECT_NE(text.find("its order in h is not settled"), std::string::npos) << text;
}

TEST_F(Precision, QuietPrintsNothing) {
  const Ended ended = viscobar("precision " + scene("unit-both-ends") + few_ + " --methods rigid --seconds 60 --quiet");
  EXPECT_EQ(ended.code, 0) << ended.error;
  EXPECT_EQ(ended.out + ended.error, "");
  EXPECT_TRUE(fs::exists(directory_ / "unit-both-ends.out" / "precision.json"));
}

TEST_F(Precision, EndsWithOneWhenEveryRunFails) {
  const Ended ended = viscobar("precision " + scene("unit-both-ends") + few_ +
                               " --methods rigid --seconds 60 --set 'load.density=\"t > 0.5 ? 1/0 : 0\"' --json");
  EXPECT_EQ(ended.code, 1);
  EXPECT_NE(ended.error.find("every run failed"), std::string::npos) << ended.error;
  const Json result = ended.json();
  EXPECT_EQ(result["rows"].size(), 3u);
  EXPECT_FALSE(result["rows"][0]["failure"].is_null());
  EXPECT_TRUE(result["rows"][0]["error"].is_null());
  EXPECT_TRUE(result["reference"]["error"].is_null());
}

TEST_F(Precision, RefusesWhatItCannotStudy) {
  const auto refused = [&](const std::string& arguments, const std::string& why) {
    const Ended ended = viscobar("precision " + arguments);
    EXPECT_EQ(ended.code, 2) << arguments;
    EXPECT_NE(ended.error.find(why), std::string::npos) << arguments << ": " << ended.error;
    EXPECT_EQ(ended.out, "") << arguments;
  };
  const std::string unit = scene("unit-both-ends");
  refused(unit + " --tolerance 1e-3:tight", "\"tight\" is not a number");
  refused(unit + " --tolerance 1e-3:1e-20", "1e-14");
  refused(unit + " --methods cvod", "did you mean cvode");
  refused(unit + " --methods cvode,cvode", "twice");
  refused(unit + " --elements 9,9", "twice");
  refused(unit + " --elements 9,-3", "--elements");
  refused(unit + " --repeat 4", "odd");
  refused(unit + " --repeat 1", "--repeat");
  refused(unit + " --seconds 0", "--seconds");
  refused(unit + " --tolerances 1e-3", "did you mean --tolerance");
  refused(scene("unit-span") + " --methods rigid", "rigid does not fit the scene");
  refused("missing.toml", "missing.toml");
}

TEST_F(Precision, HelpNamesEveryOption) {
  const Ended ended = viscobar("precision --help");
  EXPECT_EQ(ended.code, 0);
  for (const char* option : {"--methods", "--tolerance", "--halvings", "--elements", "--repeat", "--seconds",
                             "--threads", "--output", "--json", "--set", "--quiet"})
    EXPECT_NE(ended.out.find(option), std::string::npos) << option;
}

}  // namespace
}  // namespace viscobar::testing_cli

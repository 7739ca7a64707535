#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <string>
#include <vector>

#include "cli/command.hpp"

namespace viscobar::testing_cli {
namespace {

using Json = nlohmann::json;

class Compare : public Command {};

TEST_F(Compare, RunsEveryMethodThatFitsAndMatchesTheirContacts) {
  const Ended ended = viscobar("compare " + scene("chatter") + " --json");
  ASSERT_EQ(ended.code, 0) << ended.error;
  const Json result = ended.json();
  EXPECT_EQ(result["reference"], "exponential");
  EXPECT_EQ(result["methods"].size(), 8u);
  EXPECT_EQ(result["pairs"].size(), 28u);
  EXPECT_TRUE(result["completed"]);
  EXPECT_EQ(result["methods"][5]["method"], "rigid");
  EXPECT_EQ(result["methods"][5]["mass"], "consistent") << "a mass that is named is obeyed";
  for (const Json& pair : result["pairs"]) {
    const std::string methods = pair["first"].get<std::string>() + " " + pair["other"].get<std::string>();
    EXPECT_LE(pair["events_matched"], pair["events_first"]) << methods;
    ASSERT_EQ(pair["contacts"].size(), 2u) << methods;
    // The bar is the same whatever the contact law: impulses agree though the reactions of chatter are not resolved. To
    // m V = (h/2) V, by which the impact of a node that rebounds may count or not.
    const double V = 0.6, h = 1.0 / 27.0;
    for (const Json& contact : pair["contacts"])
      EXPECT_NEAR(contact["first"]["impulse"].get<double>(), contact["other"]["impulse"].get<double>(), h / 2 * V)
          << methods;
    if (methods == "exponential cvode") {
      // Errors at relative tolerance 1e-6 grow by the rebounds; a hundred of them leave four digits.
      EXPECT_LT(pair["displacement_l2"].get<double>(), 1e-4);
      EXPECT_EQ(pair["events_matched"], pair["events_first"]);
    }
  }
  std::string remarks;
  for (const Json& remark : result["remarks"]) remarks += remark.get<std::string>();
  EXPECT_NE(remarks.find("The masses differ"), std::string::npos);
  EXPECT_NE(remarks.find("lumped by finite_difference"), std::string::npos);
  EXPECT_NE(remarks.find("do not from an exact constraint"), std::string::npos);
}

// The mass that compare told makes it the same run: rigid and the schemes have another one of their own choice.
TEST_F(Compare, TellsTheMassThatAllMethodsRanOnAsTheChosenOne) {
  const Ended ended = viscobar("compare " + scene("chatter") + " --methods rigid,cvode --set mesh.mass= --json");
  ASSERT_EQ(ended.code, 0) << ended.error;
  const Json result = ended.json();
  for (const Json& method : result["methods"]) EXPECT_EQ(method["mass"], "redistributed");
  EXPECT_EQ(result["chosen"]["mesh"]["mass"], "redistributed");
  EXPECT_EQ(result["scene"]["mesh"]["mass"], "redistributed");
}

TEST_F(Compare, CountsTheContactsThatRunAndSweepCount) {
  for (const char* name : {"chatter", "rebound"}) {
    const Ended compared = viscobar("compare " + scene(name) + " --json");
    ASSERT_EQ(compared.code, 0) << compared.error;
    for (const Json& method : compared.json()["methods"]) {
      const std::string label = method["method"],
                        keys = "method.name=" + label + " --set mesh.mass=" + method["mass"].get<std::string>();
      const Ended alone = viscobar("run " + scene(name) + " -o run --json --set " + keys);
      ASSERT_EQ(alone.code, 0) << label << alone.error;
      const Json summary = alone.json();
      const std::string rows = read_text(directory_ / "run" / "events.csv");
      EXPECT_EQ(method["events"], summary["events"]) << label;
      EXPECT_EQ(std::count(rows.begin(), rows.end(), '\n') - 1, summary["events"].get<long>()) << label;
      std::ofstream(directory_ / "sweep.toml")
          << "scene = \"" VISCOBAR_SOURCE_DIR "/examples/scenes/" << name << ".toml\"\n[set]\nmethod.name = \"" << label
          << "\"\nmesh.mass = " << method["mass"].dump() << "\n[vary]\ntime.end = [" << summary["reached_time"].dump()
          << "]\n";
      ASSERT_EQ(viscobar("sweep sweep.toml -o table").code, 0) << label;
      const auto row = last_row(read_text(directory_ / "table" / "sweep.csv"));
      EXPECT_EQ(row.at("events"), method["events"].dump()) << label;
      std::size_t closings = 0;
      for (std::size_t at = 0; (at = rows.find(",closing", at)) != std::string::npos; ++at) ++closings;
      EXPECT_EQ(std::stoul(row.at("closings_left")) +
                    (row.at("closings_right").empty() ? 0 : std::stoul(row.at("closings_right"))),
                closings)
          << label;
    }
  }
}

TEST_F(Compare, AMotionThatOverflowsIsNoResult) {
  const Ended ended = viscobar("compare " + scene("chatter") + " --methods rigid,cvode --set initial.velocity=1e300");
  EXPECT_EQ(ended.code, 1) << ended.out;
  EXPECT_NE((ended.out + ended.error).find("no longer a number"), std::string::npos) << ended.out << ended.error;
}

TEST_F(Compare, TheFirstMethodAskedForIsTheReference) {
  const Ended ended = viscobar("compare " + scene("chatter") + " --methods ida,cvode --json -o out");
  ASSERT_EQ(ended.code, 0) << ended.error;
  const Json result = ended.json();
  EXPECT_EQ(result["reference"], "ida");
  ASSERT_EQ(result["pairs"].size(), 1u);
  EXPECT_EQ(result["pairs"][0]["first"], "ida");
  EXPECT_EQ(Json::parse(read_text(directory_ / "out" / "compare.json")), result);
  const std::string page = read_text(directory_ / "out" / "compare.html");
  EXPECT_NE(page.find("<svg"), std::string::npos);
  EXPECT_EQ(page.find(" src="), std::string::npos) << "the page must need no other file";
}

TEST_F(Compare, MethodsThatDoNotFitAreLeftOutWithAReasonButRefusedByName) {
  // No viscosity: cvode cannot take massless contact nodes.
  const Ended all = viscobar("compare " + scene("period-3") + " --set mesh.elements=20 --json");
  ASSERT_EQ(all.code, 0) << all.error;
  const Json result = all.json();
  std::string skipped;
  for (const Json& entry : result["skipped"]) skipped += entry["method"].get<std::string>() + " ";
  EXPECT_NE(skipped.find("cvode"), std::string::npos);
  EXPECT_NE(skipped.find("odeint"), std::string::npos);
  EXPECT_EQ(skipped.find("arkode"), std::string::npos);
  const Ended named = viscobar("compare " + scene("period-3") + " --methods ida,cvode");
  EXPECT_EQ(named.code, 2);
  EXPECT_NE(named.error.find("cvode does not fit the scene"), std::string::npos) << named.error;
}

TEST_F(Compare, ASchemeWithoutAStepTakesOneAndSaysSo) {
  std::string text = read_text(VISCOBAR_SOURCE_DIR "/examples/scenes/chatter.toml");
  text.replace(text.find("step = 1e-4"), 11, "");
  std::ofstream(directory_ / "stepless.toml") << text;
  const Ended ended = viscobar("compare stepless.toml --methods cvode,fully_discrete --json");
  ASSERT_EQ(ended.code, 0) << ended.error;
  const Json result = ended.json();
  EXPECT_DOUBLE_EQ(result["methods"][1]["step"].get<double>(), 1.0 / 27.0 / 100.0);
  EXPECT_NE(result["remarks"].dump().find("fully_discrete took the step"), std::string::npos);
}

TEST_F(Compare, LeavesTheExponentialMethodToSmallMeshes) {
  const Ended ended = viscobar("compare " + scene("chatter") + " --set mesh.elements=101 --set time.end=0.5 --json");
  ASSERT_EQ(ended.code, 0) << ended.error;
  const Json result = ended.json();
  EXPECT_EQ(result["reference"], "cvode");
  EXPECT_EQ(result["skipped"][0]["method"], "exponential");
}

TEST_F(Compare, LeavesOutAnExplicitMethodThatWouldTakeLong) {
  // 12 eta T / (3.3 rho h^2) = 3.6e6 steps on 1000 elements.
  const Ended ended =
      viscobar("compare " + scene("chatter") +
               " --set mesh.elements=1000 --set bar.viscosity=1 --set time.end=1 --set output.every=0.5 "
               "--set method.step=0.01 --set method.stepper=dopri5 --json");
  ASSERT_EQ(ended.code, 0) << ended.error;
  EXPECT_NE(ended.json()["skipped"].dump().find("for it is explicit"), std::string::npos);
}

TEST_F(Compare, TakesASpanObstacle) {
  const Ended ended =
      viscobar("compare " + scene("unit-span") + " --methods cvode,fully_discrete --set contact.epsilon=1e-4 --json");
  ASSERT_EQ(ended.code, 0) << ended.error;
  EXPECT_NE(read_text(directory_ / "unit-span.out" / "compare.html").find("span"), std::string::npos);
}

TEST_F(Compare, RefusesWhatItCannotCompare) {
  const auto refused = [&](const std::string& arguments, const std::string& why) {
    const Ended ended = viscobar("compare " + arguments);
    EXPECT_EQ(ended.code, 2) << arguments;
    EXPECT_NE(ended.error.find(why), std::string::npos) << arguments << ": " << ended.error;
    EXPECT_EQ(ended.out, "") << arguments;
  };
  refused(scene("chatter") + " --methods cvode,idaa", "did you mean ida?");
  refused(scene("chatter") + " --methods cvode,cvode", "twice");
  refused(scene("chatter") + " --methods cvode", "nothing to compare");
  refused(scene("chatter") + " --method cvode,ida", "did you mean --methods?");
  refused(scene("chatter") + " --set output.every=1e-7", "output.every");
}

// The same motion at other output times differs by what cubics in time leave; a coarser mesh by what ends.csv has.
TEST_F(Compare, TakesResultsThatAreThere) {
  const std::string base = "run " + scene("rebound") + " --quiet --no-estimate --set mesh.elements=";
  ASSERT_EQ(viscobar(base + "80 -o fine").code, 0);
  ASSERT_EQ(viscobar(base + "20 -o coarse").code, 0);
  ASSERT_EQ(viscobar(base + "80 --set output.every=0.025 -o rare").code, 0);
  ASSERT_EQ(viscobar(base + "80 --set time.end=1.5 --set 'output.write=[\"ends\"]' -o short").code, 0);

  const Ended meshes = viscobar("compare fine coarse -o meshes --json");
  ASSERT_EQ(meshes.code, 0) << meshes.error;
  const Json pair = meshes.json()["pairs"][0];
  const auto ends = [&](const std::string& result) {
    std::vector<std::array<double, 2>> rows;
    std::ifstream stream(directory_ / result / "ends.csv");
    std::string line;
    std::getline(stream, line);
    while (std::getline(stream, line)) {
      double t, left, v, r, right;
      EXPECT_EQ(std::sscanf(line.c_str(), "%lf,%lf,%lf,%lf,%lf", &t, &left, &v, &r, &right), 5);
      rows.push_back({left, right});
    }
    return rows;
  };
  const auto fine = ends("fine"), coarse = ends("coarse");
  double most = 0.0;
  for (std::size_t k = 0; k < fine.size(); ++k)
    for (const std::size_t side : {0u, 1u}) most = std::max(most, std::abs(fine[k][side] - coarse[k][side]));
  EXPECT_NEAR(pair["end_trace"].get<double>(), most, 1e-15);
  EXPECT_EQ(pair["events_matched"], 2);
  EXPECT_NEAR(pair["contacts"][0]["first"]["impulse"].get<double>(), 1.65079363, 1e-7) << "known to ten digits";
  EXPECT_NE(meshes.json()["remarks"].dump().find("it is taken at the nodes of the latter"), std::string::npos);
  EXPECT_TRUE(fs::exists(directory_ / "meshes" / "compare.csv"));
  EXPECT_NE(read_text(directory_ / "meshes" / "compare.html").find("Difference over space and time"),
            std::string::npos);

  // Where u is smooth a cubic over h = 0.025 leaves h^4 / 384 of its fourth derivative; more after the impact at t = 0.
  const Json rare = viscobar("compare fine rare -o times --json").json();
  EXPECT_GT(rare["pairs"][0]["end_trace"].get<double>(), 0.0);
  EXPECT_LT(rare["pairs"][0]["end_trace"].get<double>(), 2e-4);
  EXPECT_EQ(rare["pairs"][0]["largest_event_shift"], 0.0);

  // A run that ends before, with its ends alone.
  const Json part = viscobar("compare fine short -o part --json").json();
  EXPECT_EQ(part["pairs"][0]["displacement_l2"], nullptr);
  EXPECT_LT(part["pairs"][0]["end_trace"].get<double>(), 1e-10);
  EXPECT_EQ(part["pairs"][0]["energy_final"], nullptr) << "one energy is of another time";
}

// Bars in line are taken bar by bar: at a joint that is open there are two nodes in one place. The same motion on
// meshes whose nodes are others differs by what the meshes leave.
TEST_F(Compare, TakesResultsOfBarsInLine) {
  std::ofstream(directory_ / "pair.toml")
      << "[[bar]]\nlength = 1.0\nviscosity = 0.1\nvelocity = 1.0\n[[bar]]\nmass = 0.5\nvelocity = 0.0\n[[bar]]\nlength = "
         "0.7\nviscosity = 0.2\nmodulus = 3.0\nvelocity = -0.5\n[[joint]]\nkind = \"contact\"\ngap = 0.05\n[[joint]]\n"
         "kind = \"spring\"\nstiffness = 4.0\n[time]\nend = 2.0\n[method]\nname = \"rigid\"\n";
  for (const char* elements : {"60", "41"})
    ASSERT_EQ(viscobar(std::string("run pair.toml --quiet --no-estimate --set mesh.elements=") + elements + " -o of" +
                       elements)
                  .code,
              0);
  for (const char* both : {"of60 of41", "of41 of60"}) {
    const Json pair = viscobar(std::string("compare ") + both + " -o both --json").json()["pairs"][0];
    for (const char* norm : {"displacement_l2", "displacement_h1", "velocity_l2"}) {
      EXPECT_GT(pair[norm].get<double>(), 1e-8) << norm;
      EXPECT_LT(pair[norm].get<double>(), 1e-2) << norm;
    }
  }
}

// Bars that fly apart: one at rest, the other at a speed that is not that of the first run. Each member is taken at its
// own nodes: a polynomial through those of both would have two values at the joint.
TEST_F(Compare, TakesChainsThatAreThereMemberByMember) {
  std::ofstream(directory_ / "chain.toml")
      << "[[bar]]\nlength = 1.0\nviscosity = 0.1\n[[bar]]\nlength = 2.0\nvelocity = 1.0\nviscosity = 0.1\n"
         "[[joint]]\nkind = \"contact\"\ngap = 0.1\n[time]\nend = 3.0\n[output]\nevery = 0.5\n";
  const auto run = [&](const std::string& settings) {
    ASSERT_EQ(viscobar("run chain.toml --quiet --no-estimate " + settings).code, 0);
  };
  run("--set mesh.elements=30 -o coarse");
  run("--set mesh.elements=60 --set bar.2.velocity=2 -o fine");
  const Json apart = viscobar("compare coarse fine -o flight --json").json();
  EXPECT_NEAR(apart["pairs"][0]["displacement_l2"].get<double>(), 3.0 * std::sqrt(2.0), 1e-9);
  EXPECT_NEAR(apart["pairs"][0]["velocity_l2"].get<double>(), std::sqrt(2.0), 1e-9);
  EXPECT_NEAR(apart["pairs"][0]["displacement_h1"].get<double>(), 0.0, 1e-9);
  EXPECT_NE(apart["remarks"].dump().find("fine has 60 elements and coarse has 30"), std::string::npos);

  run("--set mesh.elements=30 --set bar.2.velocity=-1 -o struck");
  run("--set mesh.elements=60 --set bar.2.velocity=-1 -o fine-struck");
  const Json pair = viscobar("compare fine-struck struck -o blow --json").json()["pairs"][0];
  ASSERT_EQ(pair["contacts"].size(), 1u);
  for (const auto& [side, result] : {std::pair{"first", "fine-struck"}, {"other", "struck"}}) {
    const Json told = Json::parse(read_text(directory_ / result / "summary.json"));
    EXPECT_EQ(pair["contacts"][0][side]["impulse"], told["contact"]["joint:1"]["impulse"]) << side;
  }
  EXPECT_GT(pair["displacement_l2"].get<double>(), 1e-6);
  EXPECT_LT(pair["displacement_l2"].get<double>(), 1e-3);
}

TEST_F(Compare, RefusesResultsThatItCannotCompare) {
  ASSERT_EQ(viscobar("run " + scene("rebound") + " --quiet --no-estimate -o whole").code, 0);
  const auto refused = [&](const std::string& arguments, const std::string& why) {
    const Ended ended = viscobar("compare " + arguments);
    EXPECT_EQ(ended.code, 2) << arguments;
    EXPECT_NE(ended.error.find(why), std::string::npos) << arguments << ": " << ended.error;
  };
  refused("whole", "name another one");
  refused("whole whole", "asked for twice");
  refused("whole . ", "no result of `viscobar run`");
  refused("whole other --methods cvode", "belong to a scene");
  refused(scene("rebound") + " whole", "is a scene");
  fs::copy(directory_ / "whole", directory_ / "spoiled");
  std::ofstream(directory_ / "spoiled" / "ends.csv", std::ios::app) << "3,0,0,0,0,0,0\n";
  refused("whole spoiled", "is damaged");
}

TEST_F(Compare, HelpNamesEveryOption) {
  const Ended ended = viscobar("compare --help");
  EXPECT_EQ(ended.code, 0);
  for (const char* option : {"--methods", "--threads", "--output", "--json", "--set", "--quiet"})
    EXPECT_NE(ended.out.find(option), std::string::npos) << option;
}

}  // namespace
}  // namespace viscobar::testing_cli

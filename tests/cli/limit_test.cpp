#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "cli/command.hpp"
#include "cli/terminal.hpp"
#include "support/scene_text.hpp"

namespace viscobar::testing_cli {
namespace {

using Json = nlohmann::json;

class Limit : public Command {
 protected:
  Json limit(const std::string& arguments) const {
    const Ended ended = viscobar("limit " + arguments + " --json");
    EXPECT_EQ(ended.code, 0) << ended.error;
    return ended.code == 0 ? ended.json() : Json::object();
  }
  Json study(const std::string& options) const { return limit(scene("chatter") + " " + options); }
};

TEST_F(Limit, TheUndampedPenaltyOnMassiveNodesHasAPlateauAgainstTheScheme) {
  const Json result = study("--epsilon 1e-2:1e-6");
  EXPECT_EQ(result["verdict"], "plateau");
  const Json& rows = result["rows"];
  ASSERT_EQ(rows.size(), 5u);
  EXPECT_DOUBLE_EQ(rows.front()["epsilon"].get<double>(), 1e-2);
  // The measured plateau is 3.0e-3; half of it or twice is another one.
  EXPECT_GT(rows.back()["difference_to_scheme"].get<double>(), 1.5e-3);
  EXPECT_LT(rows.back()["difference_to_scheme"].get<double>(), 6e-3);
  EXPECT_EQ(rows.front()["events"], 4);
  EXPECT_GT(rows.back()["events"].get<int>(), 200);
  // rigid stops its nodes as the scheme does.
  EXPECT_GT(rows.back()["difference_to_rigid"].get<double>(), 1.5e-3);
  EXPECT_LT(rows.back()["difference_to_rigid"].get<double>(), 6e-3);
  // m d'' + d / epsilon = 0: penetration V sqrt(m epsilon).
  EXPECT_NEAR(result["order_penetration"].get<double>(), 0.5, 0.05);
  EXPECT_NE(result["reason"].get<std::string>().find("restitution"), std::string::npos);
}

TEST_F(Limit, OnNodesWithMassAndOneRestitutionTheThreeRoadsMeetAndThePenaltyDoesLikeTheRootOfEpsilon) {
  for (const std::string mass : {"consistent", "fourth_order"}) {
    const Json result = study("--epsilon 1e-5:1e-8 --mass " + mass + " --set contact.restitution=0.5");
    EXPECT_EQ(result["verdict"], "converges") << mass;
    EXPECT_NEAR(result["order_to_rigid"].get<double>(), 0.5, 0.1) << mass;
    for (const Json& row : result["rows"]) EXPECT_EQ(row["mass"], mass);
  }
}

TEST_F(Limit, ACoarseStepIsRefinedUntilThePlateauShows) {
  // At this step the scheme is 1.6e-2 off, and the plateau is 3.1e-3.
  const Json result = study("--set method.step=1e-2");
  EXPECT_EQ(result["verdict"], "plateau") << result["reason"];
  const Json& mesh = result["meshes"][0];
  EXPECT_LT(mesh["scheme_step"].get<double>(), 1e-2);
  // 3.1e-3 by other runs (docs/limit-verdicts.md), to two digits.
  EXPECT_GT(mesh["evidence"]["apart_at_least"].get<double>(), 3.05e-3);
  EXPECT_LT(mesh["evidence"]["apart_at_most"].get<double>(), 3.15e-3);
  EXPECT_EQ(result["scene"]["method"]["step"], mesh["scheme_step"]);
}

TEST_F(Limit, ScenesOfThePaperHaveTheirPlateauAsTheyAreShipped) {
  // |P(0) - S(0)| by the scheme of restitution 1 against that of 0 at steps of its own: 1.3e-5 +- 1e-6 and 5.1e-2 at
  // the output times; between them it is what `rigid` of either restitution has. Found at all times of the run.
  const struct {
    const char* name;
    double apart;
  } scenes[] = {{"unit-both-ends", 9.9e-6}, {"paper-both-ends", 5.24e-2}, {"paper-left-end", 2.4e-4}};
  for (const auto& shipped : scenes) {
    const Json result = limit(scene(shipped.name));
    EXPECT_EQ(result["verdict"], "plateau") << result["reason"];
    EXPECT_TRUE(result["order_to_scheme"].is_null()) << "a plateau has no order";
    // Chatter has its largest difference at one bounce, which a tolerance moves by a tenth.
    EXPECT_NEAR(result["meshes"][0]["evidence"]["apart"].get<double>(), shipped.apart, 0.1 * shipped.apart);
  }
}

TEST_F(Limit, APowerIsThatOfTheTheoryOrNone) {
  std::ofstream(directory_ / "throw.toml") << falling_bar_with({{"bar.viscosity", "0.01"},
                                                                {"right.kind", "'obstacle'"},
                                                                {"right.gap", "0.1"},
                                                                {"initial.displacement", "'x*(1-x)'"},
                                                                {"initial.velocity", "'-x*(1-x)'"},
                                                                {"time.end", "6"},
                                                                {"mesh.elements", "27"}});
  std::ofstream(directory_ / "held.toml") << falling_bar_with({{"bar.viscosity", "0.01"},
                                                               {"left.gap", "0.05"},
                                                               {"right.kind", "'fixed'"},
                                                               {"initial.velocity", "'-0.5+0.4*x'"},
                                                               {"time.end", "2"},
                                                               {"mesh.mass", "'redistributed'"},
                                                               {"method.step", "1e-3"}});
  // Where the scheme's step is in the differences, their powers pass from the theory's to none: 0.785 +- 0.025,
  // 0.891 +- 0.030 and 0.695 were told by the first three. Halving dt changes the scheme of the last one by 3.8e-6, for
  // both steps have the contact at the same time; its error is 3.8e-5, which the rigid limit tells.
  const struct {
    std::string study;
    double theory;
    std::optional<double> of_scheme;
  } cases[] = {{"throw.toml --per-decade 2", 1.0, {}},
               {scene("unit-both-ends") + " --mass redistributed", 1.0, {}},
               {scene("chatter") + " --set contact.restitution=0", 0.5, {}},
               {"held.toml --epsilon 1e-3:1e-7", 1.0, 3.8e-5}};
  for (const auto& [arguments, theory, of_scheme] : cases) {
    const Json result = limit(arguments);
    EXPECT_EQ(result["verdict"], "converges") << result["reason"];
    ASSERT_TRUE(result["order_to_rigid"].is_number()) << arguments;
    EXPECT_NEAR(result["order_to_rigid"].get<double>(), theory, 0.03) << arguments;
    if (const Json& order = result["order_to_scheme"]; !order.is_null()) {
      EXPECT_NEAR(order.get<double>(), theory, 0.03) << arguments;
    }
    if (of_scheme) {
      EXPECT_NEAR(result["meshes"][0]["scheme_runs"][2]["distance"].get<double>(), *of_scheme, 0.1e-5);
    }
  }
}

TEST_F(Limit, HoldsItsBudgetKeepsItsRowsAndHasAVerdict) {
  // The rows asked for would take minutes, and nothing would be left to decide with.
  const Json result = limit(scene("paper-both-ends") + " --epsilon 1e-5:1e-11 --budget 5 -o budget");
  EXPECT_EQ(result["verdict"], "plateau") << result["reason"];
  EXPECT_GT(result["rows"].size(), 0u);
  EXPECT_GT(result["left_out"].size(), 0u);
  EXPECT_EQ(result["rows"].size() + result["left_out"].size(), 7u);
  const std::string csv = read_text(directory_ / "budget" / "limit.csv");
  EXPECT_EQ(static_cast<std::size_t>(std::ranges::count(csv, '\n')), result["rows"].size() + 1);
}

TEST_F(Limit, WhereABarMagnifiesWhatIsLeftItsBeginningTellsTheVerdict) {
  // An elastic bar that bounces ten times: of the step of the scheme nothing can be said at the end. Its nodes have no
  // mass at the contact, so that theory has one limit.
  const Json result = limit(scene("bouncing") + " --set mesh.elements=10 --epsilon 1e-4:1e-7 --steps 1e-4 --budget 0");
  EXPECT_EQ(result["verdict"], "converges") << result["reason"];
  const Json& until = result["meshes"][0]["evidence"]["until"];
  ASSERT_TRUE(until.is_number());
  // Beyond the first impact, at sqrt(2 gap / load) = 1, and not the whole.
  EXPECT_GT(until.get<double>(), 1.0);
  EXPECT_LT(until.get<double>(), 53.0);
  EXPECT_TRUE(result["order_to_scheme"].is_null()) << "distances over the whole run have no order";
  EXPECT_TRUE(result["order_to_rigid"].is_null());
}

TEST_F(Limit, ADifferenceBelowTheErrorOfTheStepAloneConvincesNobody) {
  // Flat at 0.046 over six decades of epsilon, with a scheme that is 0.05 off.
  const std::string flat = "--mass redistributed --set method.step=0.05 ";
  const Json rough = study(flat + "--budget 0");
  EXPECT_EQ(rough["verdict"], "undecided") << rough["reason"];
  EXPECT_EQ(rough["budget"], 0.0);
  EXPECT_EQ(rough["meshes"][0]["scheme_runs"].size(), 3u);
  EXPECT_NE(rough["reason"].get<std::string>().find("A smaller step would decide it"), std::string::npos)
      << rough["reason"];
  const Json refined = study(flat);
  EXPECT_EQ(refined["verdict"], "converges") << refined["reason"];
  const Json& evidence = refined["meshes"][0]["evidence"];
  EXPECT_LE(evidence["apart_at_most"].get<double>(), 0.02 * evidence["stake"].get<double>());
}

TEST_F(Limit, WhereNothingTouchesThereIsNoVerdict) {
  const Json result = study("--set left.gap=10 --set right.gap=10");
  EXPECT_EQ(result["verdict"], "undecided");
  EXPECT_NE(result["reason"].get<std::string>().find("nothing touches"), std::string::npos) << result["reason"];
}

// The ends tell nothing then. On the lumped mass impacts of a span are a single node's each, and a common restitution
// makes penalty and scheme one law, to which the penalty tends like the root of epsilon.
TEST_F(Limit, UnderASpanObstacleTheMotionBetweenFixedEndsIsCompared) {
  std::ofstream(directory_ / "span.toml")
      << "bar = {length = 1, viscosity = 0.01}\nleft.kind = 'fixed'\nright.kind = 'fixed'\nspan.gap = 0.1\n"
         "initial = {displacement = 0, velocity = '-sin(pi*x)'}\ntime.end = 3\n"
         "mesh = {elements = 50, mass = 'lumped'}\n";
  const std::string span = "span.toml --epsilon 1e-3:1e-8";
  const Json common = limit(span + " --set contact.restitution=0");
  EXPECT_EQ(common["verdict"], "converges") << common["reason"];
  EXPECT_NEAR(common["order_to_scheme"].get<double>(), 0.5, 0.05);
  const Json own = limit(span);
  EXPECT_EQ(own["verdict"], "plateau") << own["reason"];
  EXPECT_GT(own["rows"].back()["difference_to_scheme"], 0.05);
}

class LimitByViscosity : public Limit, public testing::WithParamInterface<double> {};

TEST_P(LimitByViscosity, MasslessContactNodesConverge) {
  const Json result = study("--mass redistributed --set bar.viscosity=" + std::to_string(GetParam()));
  EXPECT_EQ(result["verdict"], "converges") << result["reason"];
  for (const Json& row : result["rows"]) {
    EXPECT_EQ(row["mass"], "redistributed");
    EXPECT_TRUE(row.contains("difference_to_rigid"));
  }
  const Json& mesh = result["meshes"][0];
  const double h = 1.0 / 27.0;
  EXPECT_NEAR(mesh["boundary"].get<double>(), h * h * h / (GetParam() * GetParam()),
              1e-9 * mesh["boundary"].get<double>());
  EXPECT_NEAR(result["order_penetration"].get<double>(), 1.0, 0.03);
}

INSTANTIATE_TEST_SUITE_P(Viscosities, LimitByViscosity, testing::Values(1.0, 0.1, 0.01, 0.001));

TEST_F(Limit, SeveralMeshesGiveAVerdictOfTheFinestAndACouplingOrAReason) {
  const Json result = study(
      "--mass redistributed --set bar.viscosity=1 --epsilon 1e-1:1e-6 --elements 9,18,36 "
      "--steps 1e-3,5e-4,2.5e-4 --set time.end=3");
  EXPECT_EQ(result["rows"].size(), 18u);
  ASSERT_EQ(result["meshes"].size(), 3u);
  EXPECT_EQ(result["verdict"], result["meshes"][2]["verdict"]);
  const Json& small = result["meshes"][2]["small_epsilon"];
  const Json penetration = small.is_object() ? small.value("penetration", Json()) : Json();
  EXPECT_EQ(result["order_penetration"], penetration.is_object() ? penetration["order"] : Json());
  EXPECT_DOUBLE_EQ(result["meshes"][1]["scheme_runs"][2]["step"].get<double>(), 5e-4);
  EXPECT_LE(result["meshes"][1]["scheme_step"].get<double>(), 5e-4);
  EXPECT_NE(result["coupling"].is_null(), result["coupling_reason"].is_null());
}

/// H^2 max|f''| / 8, by the second differences of the rows of a mesh: how far a line between two of them may be off,
/// f the logarithm of the difference to the rigid limit and H the rows' distance in log(epsilon).
double interpolation_error(const Json& rows, const Json& elements) {
  std::vector<double> logarithms;
  for (const Json& row : rows)
    if (row["elements"] == elements) logarithms.push_back(std::log(row["difference_to_rigid"].get<double>()));
  double bend = 0.0;
  for (std::size_t k = 2; k < logarithms.size(); ++k)
    bend = std::max(bend, std::abs(logarithms[k] - 2.0 * logarithms[k - 1] + logarithms[k - 2]));
  return bend / 8.0;
}

TEST_F(Limit, AtTheCoupledEpsilonThePenaltyCostsAsMuchAsTheMesh) {
  const std::string bar = "--mass redistributed --set bar.viscosity=0.1 --set time.end=3 ";
  const Json result = study(bar + "--epsilon 1:1e-4 --per-decade 4 --elements 9,18,36 --steps 1e-3,5e-4,2.5e-4");
  const Json& coupling = result["coupling"];
  ASSERT_FALSE(coupling.is_null());
  EXPECT_EQ(coupling["limit"], "rigid");
  // P1 has order 1 in the norm of the energy and 2 where the motion is smooth, which contact can but lower.
  const double order = coupling["mesh_order"];
  EXPECT_GT(order, 1.0);
  EXPECT_LE(order, 2.0);
  ASSERT_EQ(coupling["meshes"].size(), 3u);
  for (const Json& mesh : coupling["meshes"]) {
    const double mesh_error = mesh["mesh_error"], epsilon = mesh["epsilon"];
    EXPECT_NEAR(mesh_error / coupling["meshes"][0]["mesh_error"].get<double>(),
                std::pow(9.0 / mesh["elements"].get<double>(), order), 1e-12);
    const Json there = study(bar + "--steps 1e-3 --elements " + mesh["elements"].dump() + " --epsilon " +
                             mesh["epsilon"].dump() + ":" + Json(epsilon / 10.0).dump())["rows"][0];
    EXPECT_NEAR(std::log(there["difference_to_rigid"].get<double>() / mesh_error), 0.0,
                interpolation_error(result["rows"], mesh["elements"]));
  }
}

TEST_F(Limit, TellsTheErrorOfTheMeshThatWasAskedFor) {
  const std::string study = "limit " + scene("chatter") + " --epsilon 1e-3 --budget 0 --error ";
  const Ended missed = viscobar(study + "1e-3");  // the scene has 27 elements, and keeps them
  EXPECT_EQ(missed.code, 1);
  EXPECT_NE(missed.out.find("27 elements, at epsilon = 0: error of the mesh"), std::string::npos) << missed.out;
  EXPECT_NE(missed.out.find("asked for is not kept"), std::string::npos) << missed.out;
  const Ended kept = viscobar(study + "0.5");
  EXPECT_EQ(kept.code, 0);
  EXPECT_NE(kept.out.find("asked for is kept"), std::string::npos) << kept.out;
}

TEST_F(Limit, TwoMeshesGiveNoCouplingAndSayWhyAndTheRemedyOnce) {
  const std::string two = " --epsilon 1e-2:1e-5 --elements 9,18 --set time.end=2";
  const Json result = study(two);
  EXPECT_TRUE(result["coupling"].is_null());
  EXPECT_NE(result["coupling_reason"].get<std::string>().find("three meshes"), std::string::npos);
  EXPECT_EQ(result["verdict"], "plateau");
  const std::string text = viscobar("limit " + scene("chatter") + two).out, remedy = "gives both the same law";
  const auto first = text.find(remedy);
  ASSERT_NE(first, std::string::npos) << text;
  EXPECT_EQ(text.find(remedy, first + 1), std::string::npos) << text;
}

// Nothing in a study but the clock depends on the machine, so each digit is the same.
TEST_F(Limit, ItsJsonIsASceneThatRunsAgainAndAStudyThatHasTheSameRows) {
  const Json first = study(
      "--mass redistributed --epsilon 1e-2:1e-5 --per-decade 2 --set method.step=1e-2 "
      "--set method.absolute_tolerance=3e-9 -o first");
  // Keeps its ratio to the relative one, of the scene's 1e-6.
  const Json& ran = first["scene"]["method"];
  EXPECT_DOUBLE_EQ(ran["absolute_tolerance"].get<double>(), 3e-3 * ran["relative_tolerance"].get<double>());
  const Json again = limit("first/limit.json -o again");
  ASSERT_EQ(first["rows"].size(), again["rows"].size());
  for (std::size_t i = 0; i < first["rows"].size(); ++i) {
    Json row = first["rows"][i], other = again["rows"][i];
    row.erase("seconds");
    other.erase("seconds");
    EXPECT_EQ(row, other);
  }
  EXPECT_EQ(first["verdict"], again["verdict"]);
  EXPECT_LT(limit("first/limit.json --epsilon 1e-3:1e-4 --budget 0 -o other")["rows"].size(), first["rows"].size());
  EXPECT_EQ(viscobar("run first/limit.json -q -o run").code, 0);
  std::ofstream(directory_ / "spoiled.json") << "{\"asked\": {\"epsilon\": \"x\"}}";
  EXPECT_EQ(viscobar("limit spoiled.json").code, 2);
  std::ofstream(directory_ / "other.json") << "{\"rows\": []}";
  const Ended refused = viscobar("run other.json");
  EXPECT_EQ(refused.code, 2);
  EXPECT_NE(refused.error.find("other.json:1:1: "), std::string::npos) << refused.error;
}

TEST_F(Limit, DoesNotNeedTheScenesOwnEpsilonNorAPenalisedMethod) {
  const Ended ended = viscobar("limit " + scene("unit-both-ends") + " --epsilon 1e-3 --quiet");
  EXPECT_EQ(ended.code, 0) << ended.error;
  EXPECT_EQ(ended.out, "");
  const fs::path results = directory_ / "unit-both-ends.out";
  // The study goes on with smaller ones where that decides the verdict.
  EXPECT_EQ(Json::parse(read_text(results / "limit.json"))["rows"][0]["epsilon"], 1e-3);
  const std::string page = read_text(results / "limit.html");
  EXPECT_NE(page.find("<svg"), std::string::npos);
  EXPECT_EQ(page.find(" src="), std::string::npos) << "the page must need no other file";
}

TEST_F(Limit, AFailedRunIsNamedAndTheOthersAreKept) {
  // Matrix exponentials have no step short enough for the last.
  const Ended ended =
      viscobar("limit " + scene("chatter") +
               " --set method.name=exponential --mass redistributed --epsilon 1e-14:1e-16 --json -o out");
  EXPECT_EQ(ended.code, 1);
  EXPECT_NE(ended.error.find("epsilon = 1e-16 on 27 elements: exponential stopped at t = "), std::string::npos)
      << ended.error;
  const Json result = ended.json();
  // Rounding, which processors differ in, decides of the last but one.
  ASSERT_GE(result["rows"].size(), 1u);
  ASSERT_GE(result["failed"].size(), 1u);
  EXPECT_EQ(result["rows"].size() + result["failed"].size(), 3u);
  EXPECT_EQ(result["rows"].front()["epsilon"], 1e-14);
  EXPECT_EQ(result["failed"].back()["epsilon"], 1e-16);
  EXPECT_NE(result["failed"].back()["error"].get<std::string>().find("larger contact.epsilon"), std::string::npos);
  EXPECT_EQ(Json::parse(read_text(directory_ / "out" / "limit.json")), result);
}

TEST_F(Limit, ATerminalSeesHowManyRunsAreDone) {
  const auto shown = [&](const std::string& option) {
    return shown_on_terminal("cd '" + directory_.string() + "' && '" VISCOBAR_COMMAND "' limit " + scene("chatter") +
                             " --epsilon 1e-2:1e-3 --set time.end=1 -o out" + option + " >out.txt");
  };
  const std::string text = shown("");
  // Two of rigid, restitution 0 and 1, twice before they tell the limits, for the cost and the times of contacts; three
  // of the scheme and two penalised.
  EXPECT_NE(text.find("11 of 11 runs"), std::string::npos) << text;
  EXPECT_TRUE(text.ends_with("\r\033[K")) << text;  // nothing stays
  EXPECT_EQ(shown(" --quiet"), "");
}

TEST_F(Limit, RefusesWhatItCannotStudy) {
  const auto refused = [&](const std::string& arguments, const std::string& why) {
    const Ended ended = viscobar("limit " + arguments);
    EXPECT_EQ(ended.code, 2) << arguments;
    EXPECT_NE(ended.error.find(why), std::string::npos) << arguments << ": " << ended.error;
    EXPECT_EQ(ended.out, "") << arguments;
  };
  std::ofstream(directory_ / "free.toml") << "[bar]\nlength = 1\n[initial]\ndisplacement = 0\nvelocity = 1\n"
                                             "[time]\nend = 1\n[mesh]\nelements = 4\n";
  refused("free.toml", "free.toml: the scene has no obstacle");
  std::ofstream(directory_ / "law.toml")
      << "[[bar]]\nlength = 1\nvelocity = 1\n[[bar]]\nlength = 1\n[[joint]]\nkind = \"contact\"\n"
         "gap = 0.1\nlaw = \"hertz\"\nstiffness = 9.0\n[time]\nend = 1\n[mesh]\nelements = 8\n";
  refused("law.toml", "joint.1.law: limit studies the penalty");
  refused(scene("chatter") + " --mas lumped", "--mass");
  refused(scene("chatter") + " --mass lumpd", "lumped");
  refused(scene("chatter") + " --epsilon 1e-2:zero", "\"zero\" is not a positive number");
  refused(scene("chatter") + " --epsilon 1e-2:-1e-4", "not a positive number");
  refused(scene("chatter") + " --steps 1e-3,1e-4", "2 given for 1 mesh");
  refused(scene("chatter") + " --elements 9,-3", "--elements");
  refused(scene("chatter") + " --budget -1", "--budget");
  refused("missing.toml", "missing.toml");
}

TEST_F(Limit, NeverWritesIntoADirectoryOfOthers) {
  fs::create_directories(directory_ / "precious");
  std::ofstream(directory_ / "precious" / "thesis.tex") << "years";
  EXPECT_EQ(viscobar("limit " + scene("chatter") + " --epsilon 1e-3 -o precious").code, 2);
  EXPECT_FALSE(fs::exists(directory_ / "precious" / "limit.json"));
}

TEST_F(Limit, HelpNamesEveryOption) {
  const Ended ended = viscobar("limit --help");
  EXPECT_EQ(ended.code, 0);
  for (const char* option : {"--epsilon", "--per-decade", "--mass", "--elements", "--steps", "--budget", "--threads",
                             "--output", "--json", "--set", "--quiet"})
    EXPECT_NE(ended.out.find(option), std::string::npos) << option;
}

TEST_F(Limit, InterruptedItReplacesNoCompleteStudyAndIsNotCompleteItself) {
  ASSERT_EQ(viscobar("limit " + scene("chatter") + " --epsilon 1e-2:1e-4 --budget 0 -q -o study").code, 0);
  const std::string before = read_text(directory_ / "study/limit.json");
  for (const std::string place : {"study", "other"}) {
    // A study of minutes, signalled once it is under way.
    std::ofstream(directory_ / "interrupt.sh") << "env --default-signal=INT '" VISCOBAR_COMMAND "' limit " +
                                                      scene("chatter") +
                                                      " --epsilon 1e-2:1e-10 --set mesh.elements=2000 -q -o " + place +
                                                      " 2>err.txt &\nsleep 4\nkill -INT $!\nwait $!\n";
    const int status = std::system(("cd '" + directory_.string() + "' && bash interrupt.sh").c_str());
    EXPECT_EQ(WEXITSTATUS(status), 130) << read_text(directory_ / "err.txt");
  }
  EXPECT_EQ(read_text(directory_ / "study/limit.json"), before);
  EXPECT_EQ(Json::parse(read_text(directory_ / "other/limit.json"))["completed"], false);
}

}  // namespace
}  // namespace viscobar::testing_cli

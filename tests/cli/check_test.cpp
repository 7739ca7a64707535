#include <cmath>
#include <fstream>
#include <string>

#include "cli/command.hpp"

namespace viscobar::testing_cli {
namespace {

using Json = nlohmann::json;

class Check : public Command {
 protected:
  Json of(const std::string& arguments) const {
    const Ended ended = viscobar("check " + arguments + " --json");
    EXPECT_EQ(ended.code, 0) << ended.error;
    return ended.code == 0 ? ended.json() : Json::object();
  }
};

TEST_F(Check, ForeseesThePenetrationThatARunThenHas) {
  const Json foreseen = of(scene("chatter"));
  ASSERT_EQ(foreseen["contacts"].size(), 2u);
  const double predicted = foreseen["contacts"][0]["impact"]["predicted_penetration"];
  const Ended run = viscobar("run " + scene("chatter") + " --json");
  ASSERT_EQ(run.code, 0) << run.error;
  const double measured = run.json()["max_penetration"];
  // The prediction is one of the first impact, to a factor of about two.
  EXPECT_LT(std::abs(std::log2(measured / predicted)), 1.0) << predicted << " " << measured;
  EXPECT_TRUE(foreseen["contacts"][0]["chatter_expected"]);
}

TEST_F(Check, KnowsFirstImpactsOfAFlightExactly) {
  const Json flight = of(scene("rigid-flight"));
  ASSERT_EQ(flight["first_impacts"].size(), 1u);
  const Json& impact = flight["first_impacts"][0];
  // Free flight over the gap 0.5 at speed 1: to the tolerance of the run, whose method foresees it.
  EXPECT_NEAR(impact["time"].get<double>(), 0.5, 1e-6);
  EXPECT_EQ(impact["where"], "left");
}

// A bar that is too slow to come to its obstacle within the run has no impact.
TEST_F(Check, PredictsNoPenetrationWhereNothingTouches) {
  const std::string slow = scene("rigid-flight") + " --set time.end=0.4";
  EXPECT_EQ(of(slow)["contacts"].at(0)["impact"], nullptr);
  EXPECT_NE(of(slow + " --set time.end=0.6")["contacts"].at(0)["impact"], nullptr);
}

// The bar at the obstacle tells how its node bounces, not what stands behind it: zeta = eta / h / (2 sqrt(m /
// epsilon)).
TEST_F(Check, JudgesAContactOfAChainByTheBarThatIsThere) {
  std::ofstream(directory_ / "chain.toml")
      << "[[bar]]\nlength = 1.0\nviscosity = 0.01\nelements = 20\nvelocity = -1.0\n[[bar]]\nlength = 1.0\ndensity = "
         "9.0\nmodulus = 4.0\nviscosity = 4.0\nelements = 20\nvelocity = -1.0\n[left]\nkind = \"obstacle\"\ngap = "
         "0.1\n[time]\nend = 0.3\n[mesh]\nmass = \"lumped\"\n[contact]\nepsilon = 1e-5\n[method]\nname = \"arkode\"\n";
  const Json contact = of("chain.toml")["contacts"].at(0);
  EXPECT_NEAR(contact["damping_ratio"].get<double>(), 0.2 / (2.0 * std::sqrt(0.025 / 1e-5)), 1e-9);
  EXPECT_NEAR(contact["quiet_epsilon"].get<double>(), 0.05, 1e-9);
  EXPECT_NEAR(contact["impact"]["predicted_penetration"].get<double>(), std::sqrt(0.025 * 1e-5), 1e-6);
}

// A dashpot between elastic bars makes none of them viscous: the penalty that is chosen does not depend on the unit of
// their area.
TEST_F(Check, ChoosesOnePenaltyForElasticBarsWithADashpotBetweenThemInAnyUnitOfArea) {
  const auto epsilon = [&](double area) {
    std::ofstream(directory_ / "chain.toml")
        << "[[bar]]\nlength = 1.0\nsection = " << area << "\nvelocity = -1.0\n[[bar]]\nlength = 1.0\nsection = " << area
        << "\n[[joint]]\nkind = \"spring\"\nstiffness = " << area << "\ndamping = " << area
        << "\n[left]\nkind = \"obstacle\"\ngap = 0.1\n[time]\nend = 0.3\n[method]\nname = \"cvode\"\n";
    return of("chain.toml")["scene"]["contact"]["epsilon"].get<double>() * area;
  };
  for (const double area : {1e-4, 1e4}) EXPECT_NEAR(epsilon(area) / epsilon(1.0), 1.0, 1e-9) << area;
}

// u >= -gap at the right end stops a bar that moves left; on its right it flies through.
TEST_F(Check, SaysThatAnObstacleOnTheInnerSideDoesNotStopTheBar) {
  const auto warnings = [&](const std::string& settings) {
    return of(scene("rigid-flight") + " --set left.kind=free --set left.gap= " + settings)["warnings"].dump();
  };
  const std::string right = " --set right.kind=obstacle --set right.gap=0.1 ";
  const std::string told = warnings(right + "--set initial.velocity=1");
  EXPECT_NE(told.find("a bar that moves to the right goes on"), std::string::npos) << told;
  EXPECT_NE(told.find("side = \\\"above\\\""), std::string::npos) << told;
  EXPECT_EQ(warnings(right + "--set initial.velocity=-1"), "[]") << "which comes to it";
  EXPECT_EQ(warnings(right + "--set right.side=above --set initial.velocity=1"), "[]");
  const std::string left = " --set left.kind=obstacle --set left.gap=0.1 --set left.side=above ";
  const std::string mirrored = of(scene("rigid-flight") + left + "--set initial.velocity=-1")["warnings"].dump();
  EXPECT_NE(mirrored.find("a bar that moves to the left goes on"), std::string::npos) << mirrored;
  const std::string span = " --set span.gap=0.1 --set mesh.mass=lumped --set initial.velocity=";
  EXPECT_NE(warnings(span + "1").find("side = \\\"above\\\" in [span]"), std::string::npos) << warnings(span + "1");
  for (const char* met : {"-1", "1 --set span.side=above"})
    EXPECT_EQ(warnings(span + met).find("does not come to it"), std::string::npos) << met;
}

TEST_F(Check, CallsAConstraintExactWhereNothingGetsTooDeep) {
  for (const auto& [settings, exact] : {std::pair{"contact.restitution=0", true},
                                        {"contact.restitution=0.5", false},
                                        {"method.impact=moreau", false}}) {
    const std::string arguments =
        scene("rebound") + " --set left.gap=0.1003 --set method.name=fully_discrete --set " + settings;
    const std::string kind = of(arguments)["terms"]["contact"];
    EXPECT_EQ(kind.find("exact constraint") != kind.npos, exact) << kind;
    EXPECT_EQ(viscobar("run --no-estimate " + arguments + " --json").json()["max_penetration"] < 1e-12, exact)
        << settings;
  }
}

TEST_F(Check, ComparesWhatIsAtAnEndWithTheWholeSection) {
  const std::string arguments =
      scene("rebound") +
      " --set bar.section=1e-4 --set left.stiffness=5e-5 --set left.dashpot=3e-5 --set left.mass=2e-5";
  const std::string words = of(arguments)["terms"]["left"].dump();
  for (const char* part : {"0.5 A E/L", "0.3 A sqrt(E rho)", "0.2 of the bar's"})
    EXPECT_NE(words.find(part), std::string::npos) << words;
}

TEST_F(Check, SaysWhatAvoidsThePlateau) {
  const std::string plain = of(scene("chatter"))["warnings"].dump();
  EXPECT_NE(plain.find("plateau"), std::string::npos);
  EXPECT_NE(plain.find("redistributed"), std::string::npos);
  EXPECT_NE(plain.find("contact.restitution = 0"), std::string::npos);
  EXPECT_TRUE(of(scene("chatter") + " --set contact.restitution=0")["warnings"].empty());
  EXPECT_TRUE(of(scene("chatter") + " --set mesh.mass=redistributed")["warnings"].empty());
  const std::string half = of(scene("chatter") + " --set contact.restitution=0.5")["warnings"].dump();
  EXPECT_EQ(half.find("plateau"), std::string::npos) << "a common restitution has none";
  EXPECT_NE(half.find("share one limit"), std::string::npos);
  const std::string away = of(scene("chatter") + " --set initial.velocity=0")["warnings"].dump();
  EXPECT_EQ(away.find("chatter"), std::string::npos) << "an end that no contact closes at: " << away;
}

}  // namespace
}  // namespace viscobar::testing_cli

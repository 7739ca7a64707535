#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "case/regime.hpp"
#include "viscobar/case/recording.hpp"
#include "viscobar/input/scene_file.hpp"

namespace viscobar {
namespace {

std::string scene_text(const std::string& bar, const std::string& mesh, const std::string& more = "") {
  return fmt::format(
      "[bar]\nlength = 2.0\n{}\n[right]\nkind = \"obstacle\"\ngap = 0.1\n[initial]\nvelocity = "
      "-1.0\n[time]\nend = 1.0\n[mesh]\n{}\n{}",
      bar, mesh, more);
}

std::string complaint(const std::string& text) {
  try {
    (void)parse_scene(text, "");
  } catch (const SceneError& error) {
    return error.what();
  }
  return "";
}

TEST(SectionInput, SaysWhatIsWrongWithASection) {
  const auto says = [](const std::string& text, const std::string& words) {
    EXPECT_NE(complaint(text).find(words), std::string::npos) << complaint(text);
  };
  says(scene_text("section = \"1-x\"", "elements = 20"), "bar.section: must be finite and positive, is 0 at x = 1");
  says(scene_text("section = 0.0", "elements = 20"), "bar.section");
  says(scene_text("section = \"1+x\"", "mass = \"paper\""), "bar.section: does not fit the mass \"paper\"");
  for (const char* method : {"characteristics", "finite_difference"})
    says(scene_text("section = \"1+x\"", "elements = 20", fmt::format("[method]\nname = \"{}\"\n", method)),
         "bar.section: ");
}

TEST(SectionInput, SaysWhatIsWrongWithNodes) {
  const auto says = [](const std::string& mesh, const std::string& words) {
    EXPECT_NE(complaint(scene_text("viscosity = 0.1", mesh)).find(words), std::string::npos)
        << complaint(scene_text("viscosity = 0.1", mesh));
  };
  says("nodes = [0.0]", "mesh.nodes: needs both ends of the bar");
  says("nodes = [0.0, 0.5, 0.5, 2.0]", "mesh.nodes: must rise by 1e-6 of bar.length at least, and 0.5 follows 0.5");
  says("nodes = [0.0, 0.5, 1.0]", "mesh.nodes: must go from 0 to bar.length = 2, and go from 0 to 1");
  says("nodes = [0.0, 0.5, 2.0]\ngrading = 2.0", "mesh.grading: does not go with mesh.nodes");
  says("nodes = [0.0, 0.1, 0.9, 2.0]\nmass = \"fourth_order\"", "takes elements of at most 3 times their neighbours");
}

TEST(SectionInput, ChoosesTheMassByTheElements) {
  const auto resolved = [](const std::string& mesh) {
    return resolve(parse_scene(scene_text("viscosity = 0.1", mesh), "").run);
  };
  EXPECT_EQ(resolved("nodes = [0.0, 0.3, 1.0, 2.0]").mass, Mass::fourth_order);
  EXPECT_EQ(resolved("nodes = [0.0, 0.1, 0.9, 2.0]").mass, Mass::redistributed);
  const auto fine = resolved("nodes = [0.0, 0.3, 1.0, 2.0]\nelements = 6");
  for (const auto& [j, x] : {std::pair<std::size_t, double>{0, 0.0}, {1, 0.15}, {2, 0.3}, {4, 1.0}, {5, 1.5}, {6, 2.0}})
    EXPECT_NEAR(fine.mesh.node(j), x, 1e-15) << j;
}

// Derivatives of this motion, which central differences of whole runs have as well.
TEST(SectionSensitivity, IsThatOfTheRun) {
  for (const char* method : {"rigid", "cvode"})
    for (const auto& [key, value] :
         {std::pair{"bar.modulus", 1.0}, {"bar.viscosity", 0.1}, {"bar.density", 1.0}, {"right.gap", 0.1}}) {
      const auto run = [&](double at) {
        const std::string text = scene_text(
            "viscosity = 0.1\nsection = \"exp(-x)\"", "elements = 30",
            fmt::format("[method]\nname = \"{}\"\nrelative_tolerance = 1e-9\n[contact]\nepsilon = 0.01\n", method));
        Case found = parse_scene(text, "").run;
        if (std::string(key) == "bar.modulus") found.scene.bar.modulus = at;
        if (std::string(key) == "bar.viscosity") found.scene.bar.viscosity = at;
        if (std::string(key) == "bar.density") found.scene.bar.density = at;
        if (std::string(key) == "right.gap") std::get<Obstacle>(found.scene.right).gap = at;
        return found;
      };
      Case sensitive = run(value);
      sensitive.directions.push_back(direction(sensitive, key));
      const Recording here = record(sensitive), low = record(run(value * 0.9999)), high = record(run(value * 1.0001));
      const double quotient = (high.u.back() - low.u.back()) / (2e-4 * value);
      EXPECT_NEAR(here.sensitivities.at(0).u.back(), quotient, 1e-4 * (1.0 + std::abs(quotient))) << method << key;
    }
}

// Derivatives by p = 0.4 of a section 1 + p x are those of runs: central differences are wrong by the errors of both,
// 100 tolerances, over the difference of p.
void expect_slopes(const std::string& mesh, const std::string& more) {
  constexpr double tolerance = 1e-10, step = 1e-4;
  const std::string text = scene_text("viscosity = 0.05\nsection = \"1 + p*x\"", mesh,
                                      more + "[parameters]\np = 0.4\n[output]\nevery = 0.02\n");
  const auto run = [&](double p, const char* of) {
    const std::vector<std::string> settings = {
        fmt::format("parameters.p={}", p), fmt::format("sensitivity.of=[{}]", of),
        fmt::format("method.relative_tolerance={}", tolerance), "contact.epsilon=0.01"};
    return record(parse_scene(text, "", settings).run);
  };
  const Recording with = run(0.4, "\"parameters.p\""), high = run(0.4 + step, ""), low = run(0.4 - step, "");
  const RecordedSensitivity& told = with.sensitivities.at(0);
  for (const auto& [of_run, of_told] :
       {std::pair{&Recording::u, &RecordedSensitivity::u}, {&Recording::v, &RecordedSensitivity::v}}) {
    double largest = 0.0, worst = 0.0;
    for (std::size_t i = 0; i < (told.*of_told).size(); ++i) {
      const double slope = ((high.*of_run)[i] - (low.*of_run)[i]) / (2.0 * step);
      largest = std::max(largest, std::abs((with.*of_run)[i]));
      worst = std::max(worst, std::abs((told.*of_told)[i] - slope));
    }
    EXPECT_GT(largest, 0.0);
    EXPECT_LT(worst, 100.0 * tolerance * largest / step) << text;
  }
}

// A node without mass follows its row between the steps, too.
TEST(SectionSensitivity, IsThatOfTheRunAtNodesWithoutMass) {
  for (const char* method : {"arkode", "cvode", "ida", "rigid"})
    expect_slopes("elements = 20\nmass = \"redistributed\"", fmt::format("[method]\nname = \"{}\"\n", method));
}

// The dashpot of a node under a span obstacle goes with the mass of its row.
TEST(SectionSensitivity, IsThatOfTheRunOnASpanObstacleWithRestitution) {
  expect_slopes("elements = 10\nmass = \"consistent\"",
                "[span]\ngap = 0.2\n[contact]\nrestitution = 0.5\n[method]\nname = \"cvode\"\n");
}

// Forces go with the area, the motion does not: nor do the tolerances that the scene has of itself, and so the steps.
TEST(SectionInput, OfAnyUnitOfAreaHasTheSameToleranceOfItself) {
  for (const char* what : {"[left]\nkind = \"free\"\nforce = \"a*sin(3*t)\"\n", "[load]\ndensity = 0.3\n",
                           "[load]\ndensity = \"x*cos(t)\"\n[left]\nkind = \"free\"\nforce = \"0.1*a\"\n"})
    for (const char* bar : {"[bar]\nlength = 1.0\nviscosity = 0.1\nsection = {0}\n",
                            "[[bar]]\nlength = 1.0\nviscosity = 0.1\nsection = \"{0}*(1+x)\"\n[[bar]]\nmass = {1}\n"}) {
      const auto steps_of = [&](double area) {
        const std::string text =
            fmt::format(fmt::runtime(bar), area, 2.0 * area) + what +
            fmt::format("[parameters]\na = {}\n[time]\nend = 2.0\n[mesh]\nelements = 10\n[method]\nname = \"arkode\"\n",
                        area);
        return record(parse_scene(text, "").run).statistics.steps;
      };
      const auto steps = steps_of(1.0);
      EXPECT_EQ(steps_of(std::ldexp(1.0, 20)), steps) << bar << what;
      EXPECT_EQ(steps_of(std::ldexp(1.0, -14)), steps) << bar << what;
    }
}

// Its steps are those of the rates of the bar, which no unit of area changes.
TEST(SectionInput, OfAnyUnitOfAreaHasTheSameMotionByExponentials) {
  const auto motion = [](double area) {
    return record(
        parse_scene(scene_text(fmt::format("viscosity = 0.1\nsection = \"{}*(1+x)\"", area), "elements = 8",
                               fmt::format("[contact]\nepsilon = {}\n[method]\nname = \"exponential\"\n", 0.01 / area)),
                    "")
            .run);
  };
  const Recording of_one = motion(1.0);
  for (const double area : {std::ldexp(1.0, 10), std::ldexp(1.0, 40), std::ldexp(1.0, -20)}) {
    const Recording run = motion(area);
    EXPECT_EQ(run.statistics.steps, of_one.statistics.steps);
    for (std::size_t i = 0; i < run.u.size(); ++i) EXPECT_NEAR(run.u[i], of_one.u[i], 1e-13);
  }
}

// An obstacle is as hard for the bar, and met as deep, whatever the unit of its area.
TEST(SectionInput, OfAnyUnitOfAreaMeetsAsHardAnObstacle) {
  const auto met = [](double area, const std::string& contact) {
    const Case run = parse_scene(fmt::format("[bar]\nlength = 1.0\nviscosity = 0.02\nsection = {}\n[left]\nkind = "
                                             "\"obstacle\"\ngap = 0.05\n{}[initial]\nvelocity = -1.0\n[time]\nend = "
                                             "1.0\n[mesh]\nelements = 30\nmass = \"fourth_order\"\n[method]\nname = "
                                             "\"arkode\"\n",
                                             area, fmt::format(fmt::runtime(contact), 20.0 * area, 0.5 * area)),
                                 "")
                         .run;
    const viscobar::Setup setup = resolve(run);
    return std::pair(setup.epsilon * area, contact_regimes(setup, setup.system()).at(0));
  };
  for (const double area : {std::ldexp(1.0, 20), std::ldexp(1.0, -14)}) {
    const auto [epsilon, regime] = met(area, "");
    const auto [one, of_one] = met(1.0, "");
    EXPECT_DOUBLE_EQ(epsilon, one);
    EXPECT_DOUBLE_EQ(regime.impact->penetration, of_one.impact->penetration);
    EXPECT_DOUBLE_EQ(regime.damping_ratio.value(), of_one.damping_ratio.value());
    const std::string stop = "contact = {{ law = \"spring_damper\", stiffness = {}, damping = {} }}\n";
    const StopForecast forecast = *met(area, stop).second.forecast, of_one_too = *met(1.0, stop).second.forecast;
    EXPECT_NEAR(forecast.penetration / of_one_too.penetration, 1.0, 1e-9);
    EXPECT_NEAR(forecast.restitution / of_one_too.restitution, 1.0, 1e-9);
  }
}

// Springs of a tenth and of ten times the element beside them, a wave's peak behind the one and the node's behind the
// other, whatever the unit of the area: only the softer one has a peak with a limit.
TEST(SectionInput, OfAnyUnitOfAreaHasAPeakWithALimitOnASoftStopAlone) {
  for (const double area : {1.0, 1e-4, 1e6})
    for (const bool soft : {true, false})
      for (const char* mass : {"lumped", "redistributed"}) {
        const Case run =
            parse_scene(
                fmt::format("[bar]\nlength = 1.0\nmodulus = 2e11\ndensity = 7800\nsection = {}\n[left]\nkind "
                            "= \"obstacle\"\ngap = 0.05\n[initial]\nvelocity = -1.0\n[time]\nend = 1.0\n[mesh]"
                            "\nelements = 20\nmass = \"{}\"\n[contact]\nepsilon = {}\n[method]\nname = \"ida\"\n",
                            area, mass, (soft ? 10.0 : 0.1) / (20.0 * 2e11 * area)),
                "")
                .run;
        const viscobar::Setup setup = resolve(run);
        EXPECT_EQ(peak_remark(setup, setup.system()).has_value(), !soft) << area << " " << mass;
      }
}

// Flat on an obstacle along the bar, where each node stops on its own.
TEST(SectionInput, UnderASpanObstacleIsMetAsDeepAsCheckPredicts) {
  for (const char* section : {"1.0", "\"1e-4*(1+x)\"", "3e5"}) {
    const Case run =
        parse_scene(fmt::format("[bar]\nlength = 1.0\nsection = {}\n[span]\ngap = 0.05\n[initial]\nvelocity "
                                "= -1.0\n[time]\nend = 0.5\n[mesh]\nelements = 20\nmass = \"lumped\"\n"
                                "[method]\nname = \"cvode\"\n",
                                section),
                    "")
            .run;
    const viscobar::Setup setup = resolve(run);
    const double predicted = contact_regimes(setup, setup.system()).at(0).impact->penetration;
    EXPECT_NEAR(simulate(setup, {}).max_penetration / predicted, 1.0, 0.05) << section;
  }
}

}  // namespace
}  // namespace viscobar

// Laws of stops in scene files: what they become, and what is refused.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "case/regime.hpp"
#include "input/described_scene.hpp"
#include "input/unit_of_key.hpp"
#include "laws/scene.hpp"
#include "report/scene_check.hpp"
#include "viscobar/case/recording.hpp"

namespace viscobar::laws {
namespace {

std::string scene(const std::string& more, const std::string& left = "") {
  return "[bar]\nlength = 1\n[left]\nkind = \"obstacle\"\ngap = 0.1\n" + left +
         "[right]\nkind = \"obstacle\"\ngap = 0.2\nside = \"above\"\n[initial]\nvelocity = -1\n[time]\nend = "
         "2\n[mesh]\nelements = 8\n" +
         more;
}

std::string findings(const std::string& text) {
  try {
    parse_scene(text, "");
  } catch (const SceneError& error) {
    return error.what();
  }
  return "";
}

TEST(Law, OfTheContactTableIsThatOfBothEndsAndAnEndsOwnComesFirst) {
  const Case both = parse_scene(scene("[contact]\nlaw = \"hertz\"\nstiffness = 30\n"), "").run;
  for (const EndInput* input : {&both.scene.left_input, &both.scene.right_input}) {
    ASSERT_TRUE(input->stop);
    EXPECT_EQ(input->stop->law, Law::hertz);
    EXPECT_EQ(input->stop->stiffness, 30.0);
    EXPECT_TRUE(input->stop->shared);
  }
  const Case own =
      parse_scene(scene("[contact]\nlaw = \"hertz\"\nstiffness = 30\n", contact("spring_damper", 7, 2)), "").run;
  EXPECT_EQ(own.scene.left_input.stop->law, Law::spring_damper);
  EXPECT_EQ(own.scene.left_input.stop->damping, 2.0);
  EXPECT_FALSE(own.scene.left_input.stop->shared);
  EXPECT_EQ(own.scene.right_input.stop->law, Law::hertz);
  const Case one = parse_scene(scene("[contact]\nlaw = \"hertz\"\nstiffness = 30\nepsilon = 1e-3\n",
                                     "contact = { law = \"penalty\" }\n"),
                               "")
                       .run;
  EXPECT_FALSE(one.scene.left_input.stop);
  EXPECT_TRUE(one.scene.right_input.stop);
  EXPECT_TRUE(has_penalty(one.scene));
}

TEST(Law, IsOverriddenByItsKeys) {
  const std::array<std::string, 2> set = {"left.contact.stiffness=9", "left.contact.law=hunt_crossley"};
  const Case run = parse_scene(scene("", contact("spring_damper", 7, 2)), "", set).run;
  EXPECT_EQ(run.scene.left_input.stop->law, Law::hunt_crossley);
  EXPECT_EQ(run.scene.left_input.stop->stiffness, 9.0);
  const std::array<std::string, 1> table = {"left.contact={ law = \"hertz\", stiffness = 5 }"};
  const Case other = parse_scene(scene(""), "", table).run;
  EXPECT_EQ(other.scene.left_input.stop->law, Law::hertz);
  EXPECT_EQ(other.scene.left_input.stop->stiffness, 5.0);
}

TEST(Law, ChoosesTheMethodAndTheMass) {
  const std::string law = "[contact]\nlaw = \"hertz\"\nstiffness = 30\n";
  const Case elastic = parse_scene(scene(law), "").run;
  EXPECT_EQ(elastic.method, MethodName::cvode);
  EXPECT_EQ(resolve(elastic).mass, Mass::fourth_order);
  const std::array<std::string, 1> set = {"bar.viscosity=0.1"};
  EXPECT_EQ(parse_scene(scene(law), "", set).run.method, MethodName::arkode);
}

// Whose waves know no mesh.
TEST(Law, IsForCharacteristicsWhereItIsLinearAndTheBarElastic) {
  const Case run = parse_scene(scene("[contact]\nlaw = \"spring_damper\"\nstiffness = 30\ndamping = 0.5\n"), "").run;
  EXPECT_EQ(run.method, MethodName::characteristics);
  EXPECT_EQ(run.warning, "");
  // The waves are exact; the kinks of a mesh are wrong by h^(2/3) or less.
  const Recording exact = record(run);
  const auto off = [&](int elements) {
    Case meshed = run;
    meshed.method = MethodName::cvode;
    meshed.elements = elements;
    const Recording other = record(meshed);
    double most = 0.0;
    for (std::size_t k = 0; k < exact.times.size(); ++k)
      most = std::max(most, std::abs(exact.displacement(k).front() - other.displacement(k).front()));
    return most;
  };
  const double coarse = off(50), fine = off(800);
  EXPECT_LT(fine, coarse / std::pow(16.0, 2.0 / 3.0)) << coarse;
  const std::array<std::string, 1> set = {"contact.epsilon=1e-5"};
  EXPECT_EQ(parse_scene(scene("[contact]\nlaw = \"spring_damper\"\nstiffness = 30\n"), "", set).run.method,
            MethodName::cvode);
}

TEST(Law, IsRefusedByMethodsThatHaveNoSuchStop) {
  for (const char* method : {"rigid", "exponential", "characteristics", "fully_discrete", "finite_difference"}) {
    const std::string found =
        findings(scene(fmt::format("[contact]\nlaw = \"hertz\"\nstiffness = 30\n[method]\nname = \"{}\"\n", method)));
    EXPECT_NE(found.find("contact.law: \"hertz\" is no law for " + std::string(method)), std::string::npos) << found;
    EXPECT_NE(found.find("arkode"), std::string::npos) << found;
  }
  const auto exponential = [](const std::string& stops) {
    return findings(scene("[method]\nname = \"exponential\"\n[contact]\n" + stops, contact("spring_damper", 7, 2)));
  };
  EXPECT_EQ(exponential("law = \"spring_damper\"\nstiffness = 3\n"), "");
  const std::string bent = exponential("law = \"hertz\"\nstiffness = 3\n");
  EXPECT_NE(bent.find("contact.law: \"hertz\" is no law for exponential"), std::string::npos) << bent;
  const std::string massless = findings(
      scene("mass = \"redistributed\"\n[contact]\nlaw = \"hertz\"\nstiffness = 30\n[method]\nname = \"arkode\"\n"));
  EXPECT_NE(massless.find("mesh.mass"), std::string::npos) << massless;
  EXPECT_NE(massless.find("hertz"), std::string::npos) << massless;
  const std::string dense = findings(
      scene("[contact]\nlaw = \"hertz\"\nstiffness = 30\n[method]\nname = \"odeint\"\nstepper = \"rosenbrock4\"\n"));
  EXPECT_NE(dense.find("method.stepper"), std::string::npos) << dense;
}

// The penalty of the span has a natural epsilon where no end has one.
TEST(Law, BesideASpanObstacleWantsAPenalisedMethod) {
  const std::string law = "[span]\ngap = 0.5\n[contact]\nlaw = \"hertz\"\nstiffness = 30\n";
  const Case run = parse_scene(scene(law), "").run;
  EXPECT_EQ(run.method, MethodName::cvode);
  EXPECT_EQ(natural_epsilon(run.scene), 1.0);
  EXPECT_EQ(unit_of_key("contact.epsilon", run.scene),
            (UnitPowers{2, 0, -1, -1}));  // a penetration per force on a volume
  const std::string found = findings(scene("[span]\ngap = 0.5\n", contact("hertz", 30)));
  EXPECT_NE(found.find("contact.epsilon: is missing: cvode, chosen for left.contact.law, penalises"), std::string::npos)
      << found;
}

TEST(Law, WantsItsOwnNumbersAndNoOthers) {
  const auto expect = [](const std::string& text, const std::string& key, const std::string& word) {
    const std::string found = findings(text);
    EXPECT_NE(found.find(key), std::string::npos) << found;
    EXPECT_NE(found.find(word), std::string::npos) << found;
  };
  expect(scene("[contact]\nlaw = \"hertz\"\n"), "contact.stiffness", "is missing");
  expect(scene("[contact]\nlaw = \"hertz\"\nstiffness = 3\ndamping = 1\n"), "contact.damping", "hertz has no damper");
  expect(scene("[contact]\nstiffness = 3\n"), "contact.stiffness", "contact.law is missing");
  expect(scene("[contact]\nlaw = \"hertzian\"\nstiffness = 3\n"), "contact.law", "nearest is \"hertz\"");
  expect(scene("[contact]\nlaw = \"hertz\"\nstiffness = -3\n"), "contact.stiffness", "must be positive");
  expect(scene("[contact]\nlaw = \"hertz\"\nstiffness = 3\nrestitution = 0.5\n"), "contact.restitution",
         "every obstacle here has a law of its own");
  EXPECT_EQ(findings(scene("[contact]\nlaw = \"hertz\"\nstiffness = 3\nrestitution = 0.5\n",
                           "contact = { law = \"penalty\" }\n")),
            "");
  expect(scene("", "contact = 3\n"), "left.contact: must be a table",
         "such as { law = \"hertz\", stiffness = 100.0 }; is a whole number");
  expect(scene("", "contact = { law = \"hertz\" }\n"), "left.contact.stiffness", "is missing");
  expect(scene("", "contact = { law = \"hertz\", stifness = 3 }\n"), "left.contact.stifness",
         "nearest is \"contact.stiffness\"");
  expect(
      "[bar]\nlength = 1\n[left]\nkind = \"free\"\ncontact = { law = \"hertz\", stiffness = 3 }\n[initial]\nvelocity "
      "= 1\n[time]\nend = 1\n",
      "left.contact.law", "belongs to an obstacle");
}

// The exact a = lambda V of e, which 3 (1 - e) / 2 is only for e near 1.
TEST(Law, OfHuntAndCrossleyMayBeGivenByARestitution) {
  for (const auto& [e, a] : {std::array{0.9, 0.16648195069},
                             {0.7, 0.63482828127},
                             {0.5, 1.4327505333},
                             {0.3, 3.0870819811},
                             {0.1, 9.9981593975},
                             {1.0, 0.0}}) {
    const auto told = fmt::format("law = \"hunt_crossley\", stiffness = 3, restitution = {}, speed = 2", e);
    EXPECT_NEAR(2.0 * parse_scene(scene("", "contact = { " + told + " }\n"), "").run.scene.left_input.stop->damping, a,
                2e-10 + 1e-9 * a);
  }
  const std::string shared = "[contact]\nlaw = \"hunt_crossley\"\nstiffness = 3\nrestitution = 0.5\nspeed = 2\n";
  EXPECT_NEAR(parse_scene(scene(shared), "").run.scene.right_input.stop->damping, 0.5 * 1.4327505333, 1e-9);
  EXPECT_NE(findings(scene(shared + "damping = 1\n")).find("contact.speed: excludes contact.damping"),
            std::string::npos);
  const Outcome run = outcome(
      lone_mass("mass = 1\ncontact = { law = \"hunt_crossley\", stiffness = 7, restitution = 0.5, speed = 2 }\n", 2.0,
                3.0, "cvode"));
  EXPECT_NEAR(run.events.at(1).velocity, 1.0, 1e-8);
}

// m = 1 at speed 1: lambda = a of the table above; e = 1 / a where hardly anything is left.
TEST(Law, OfHuntAndCrossleyIsForetoldAlsoWhereItDampsStrongly) {
  const Bar light{1.0, 1e-9, 1.0, 0.0};
  for (const auto& [e, a] :
       {std::array{0.9, 0.16648195069}, {0.5, 1.4327505333}, {0.1, 9.9981593975}, {1e-9, 1e9}, {1e-12, 1e12}})
    EXPECT_NEAR(forecast({light, 0.1}, 1.0, 1.0, {Law::hunt_crossley, 7.0, a}, 1.0).restitution, e, 1e-3 * e) << a;
  // The two ways meet.
  EXPECT_NEAR(forecast({light, 0.1}, 1.0, 1.0, {Law::hunt_crossley, 7.0, 0.00101}, 1.0).restitution,
              forecast({light, 0.1}, 1.0, 1.0, {Law::hunt_crossley, 7.0, 0.00099}, 1.0).restitution, 2e-4);
}

TEST(Law, IsInTheDescriptionThatMakesTheSameScene) {
  const SceneFile first =
      parse_scene(scene("[contact]\nlaw = \"hertz\"\nstiffness = 30\n", contact("spring_damper", 7, 2)), "");
  const SceneFile again = parse_scene("{\"scene\": " + first.description() + "}", "");
  EXPECT_EQ(again.values, first.values);
  EXPECT_EQ(again.run.scene.left_input.stop->damping, 2.0);
  EXPECT_EQ(parse_scene(scene_text(first.values), "").values, first.values);
}

// A fine mesh shows more of a viscous bar, which answers a stiff stop with its layer; a coarse one stops its end node.
TEST(Law, IsForetoldWithinAFactorOfTwoOnABarOfAnyViscosity) {
  for (const double viscosity : {0.01, 0.1, 0.5, 1.0})
    for (const double stiffness : {1.0, 1e2, 1e3, 1e5})
      for (const char* law : {"spring_damper", "hertz", "hunt_crossley"}) {
        const std::string damping = std::string_view(law) == "hertz" ? "" : ", damping = 0.3";
        const SceneFile file = parse_scene(
            fmt::format("[bar]\nlength = 1\nviscosity = {}\n[left]\nkind = \"obstacle\"\ngap = 0.1\ncontact = {{ law = "
                        "\"{}\", stiffness = {}{} }}\n[initial]\nvelocity = -0.7\n[time]\nend = 3\n[mesh]\nelements = "
                        "20\n[output]\nevery = 0.0005\n",
                        viscosity, law, stiffness, damping),
            "");
        const StopForecast told = *check_scene(file).regimes[0].forecast;
        const Recording run = record(file.run);
        for (const double ratio : {told.penetration / run.statistics.max_penetration,
                                   told.force / *std::ranges::max_element(run.reaction_left)})
          EXPECT_NEAR(std::log2(ratio), 0.0, 1.0) << law << " " << stiffness << " eta = " << viscosity;
      }
}

// The forecast of a lone mass is exact but for its steps of 1e-3: zeta 0.2 leaves 0.5717 of the speed.
TEST(Law, IsForecastByCheck) {
  const SceneFile light =
      parse_scene(lone_mass("mass = 1\n" + contact("spring_damper", 1.0, 0.4), 2.0, 1.0, "cvode"), "");
  const SceneCheck check = check_scene(light);
  ASSERT_EQ(check.regimes.size(), 1u);
  ASSERT_TRUE(check.regimes[0].forecast);
  const StopForecast& found = *check.regimes[0].forecast;
  EXPECT_NEAR(found.damping_ratio, 0.2, 1e-9);
  EXPECT_NEAR(found.restitution, 0.57174002758, 2e-3);
  EXPECT_NEAR(found.penetration, 2.0 * 0.75613492684, 1e-5);
  EXPECT_NEAR(found.force, 2.0 * 0.82091852176, 1e-5);
  EXPECT_NE(check_json(check).find("\"predicted_peak\""), std::string::npos);
}

// A wall beside a stop: the wall's node gives its mass away, the stop's keeps it, and no advice names what is there.
TEST(Law, OfOneEndLeavesTheOtherAWallThatDoesNotChatter) {
  for (const double viscosity : {1e-6, 0.01}) {
    SCOPED_TRACE(viscosity);
    const std::string text = fmt::format(
        "[bar]\nlength = 1\nviscosity = {}\n[left]\nkind = \"obstacle\"\ngap = 0.1\n{}[right]\nkind = \"obstacle\"\ngap = "
        "0.1\nside = \"above\"\n[initial]\nvelocity = -1\n[time]\nend = 6\n[mesh]\nelements = 40\n",
        viscosity, contact("spring_damper", 50.0, 1.0));
    const Case run = parse_scene(text, "").run;
    EXPECT_EQ(run.method, MethodName::arkode);
    EXPECT_EQ(resolve(run).mass, Mass::redistributed);
    const BarSystem system = resolve(run).system();
    EXPECT_FALSE(system.inertia().massless(0));
    EXPECT_TRUE(system.inertia().massless(system.size() - 1));
    EXPECT_LT(outcome(run).events.size(), 16u);
    const std::array<std::string, 1> set = {"mesh.mass=consistent"};
    for (const SceneFile& scene : {parse_scene(text, ""), parse_scene(text, "", set)})
      for (const std::string& warning : check_scene(scene).warnings)
        EXPECT_EQ(warning.find("arkode"), std::string::npos) << warning;
  }
}

TEST(Law, KeepsTheBitsOfARunThatIsResumed) {
  for (const char* method : linear_methods)
    for (const std::string_view law : {"spring_damper", "hunt_crossley"}) {
      if (method == std::string_view("exponential") && law != "spring_damper") continue;
      SCOPED_TRACE(fmt::format("{} {}", method, law));
      const viscobar::Setup setup =
          resolve(parse_scene(thrown_bar(contact(std::string(law), 20.0, 1.0), 0.1, 8, 3.0, method), "").run);
      std::vector<double> whole, resumed;
      std::vector<Checkpoint> taken;
      const auto observers = [](std::vector<double>& told) {
        Observers all;
        all.energy = all.account = true;
        all.snapshot = [&told](const Snapshot& now) { told.insert(told.end(), now.u.begin(), now.u.end()); };
        return all;
      };
      Observers first = observers(whole);
      first.checkpoints = Checkpoints{.every = 0.7, .asked = {}, .take = [&](const Checkpoint& one) {
                                        taken.push_back(one);
                                        return RunControl::go_on;
                                      }};
      const Statistics done = simulate(setup, first);
      for (const Checkpoint& checkpoint : taken) {
        resumed.clear();
        Observers second = observers(resumed);
        second.checkpoints =
            Checkpoints{.every = 0.7, .asked = {}, .take = [](const Checkpoint&) { return RunControl::go_on; }};
        const Statistics again = simulate(setup, setup.system(), checkpoint, second);
        ASSERT_LT(resumed.size(), whole.size());
        EXPECT_TRUE(std::equal(resumed.rbegin(), resumed.rend(), whole.rbegin()));
        EXPECT_EQ(again.energy->dissipated, done.energy->dissipated);
        EXPECT_EQ(again.account->left.impulse, done.account->left.impulse);
      }
    }
}

}  // namespace
}  // namespace viscobar::laws

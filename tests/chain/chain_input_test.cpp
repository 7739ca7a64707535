#include <fmt/format.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <random>
#include <string>

#include "input/described_scene.hpp"
#include "report/scene_check.hpp"
#include "viscobar/case/recording.hpp"
#include "viscobar/input/scene_file.hpp"

namespace viscobar {
namespace {

std::string complaint(const std::string& text, std::vector<std::string> settings = {}) {
  try {
    (void)parse_scene(text, "s", settings);
  } catch (const SceneError& error) {
    return error.what();
  }
  return "";
}

std::vector<std::size_t> elements_of(const Case& run) {
  std::vector<std::size_t> elements;
  for (const Mesh& own : run.bar_meshes) elements.push_back(own.elements);
  return elements;
}

const std::string pair =
    "[[bar]]\nlength = 1.0\nviscosity = 0.1\nvelocity = 1.0\n[[bar]]\nlength = 1.5\ndensity = 2.0\nmodulus = "
    "3.0\nviscosity = 0.2\nvelocity = 0.0\n[[joint]]\nkind = \"contact\"\ngap = 0.05\n[time]\nend = 2.0\n";

// Nor does it stand for one of the other table's.
TEST(ChainInput, AKeyOfTheOtherTableIsUnknown) {
  const auto expect_unknown = [](const std::string& key) {
    EXPECT_NE(complaint(pair, {key + "=1"}).find(key + ": unknown key"), std::string::npos) << key;
  };
  for (const char* leaf :
       {"length", "mass", "density", "modulus", "viscosity", "section", "elements", "displacement", "velocity"})
    expect_unknown(fmt::format("joint.1.{}", leaf));
  for (const char* leaf : {"kind", "gap", "law", "stiffness", "damping", "restitution", "speed"})
    expect_unknown(fmt::format("bar.1.{}", leaf));
}

TEST(ChainInput, RigidBodiesAloneAreNoBars) {
  for (const char* kind : {"bonded", "contact"})
    for (const char* mesh : {"", "elements = 20\n"})
      EXPECT_EQ(complaint(fmt::format("[[bar]]\nmass = 2\nvelocity = 1\n[[bar]]\nmass = 2\n[[joint]]\nkind = \"{}\"\n"
                                      "[load]\ndensity = \"x*t\"\n[time]\nend = 1\n[mesh]\n{}mass = \"lumped\"\n",
                                      kind, mesh)),
                "s:1:1: bar.1.length: is missing: rigid bodies alone are no bars");
}

TEST(ChainInput, NamesEachMistakeByItsBar) {
  const auto says = [](const std::string& text, const std::string& words, std::vector<std::string> settings = {}) {
    EXPECT_NE(complaint(text, settings).find(words), std::string::npos) << complaint(text, settings);
  };
  const std::string wrong = complaint(
      "[[bar]]\nlength = 1.0\nviscocity = 0.1\ndensity = -1.0\n[[bar]]\nmass = 2.0\nmodulus = 3.0\nvelocity = "
      "\"x\"\n[[bar]]\ndensity = 2.0\n[[joint]]\nkind = \"contct\"\n[[joint]]\nkind = \"spring\"\ngap = "
      "0.1\n[[joint]]\nkind = \"bonded\"\n[time]\nend = 1.0\n");
  for (const char* words :
       {"s:3:1: bar.1.viscocity: unknown key; nearest is \"viscosity\"", "s:4:11: bar.1.density: must be positive",
        "s:7:11: bar.2.modulus: belongs to a bar", "s:8:12: bar.2.velocity: varies along a bar",
        "s:9:1: bar.3.length: is missing", "s:12:8: joint.1.kind: cannot be \"contct\"",
        "s:13:1: joint.2.stiffness: is missing", "s:15:7: joint.2.gap: belongs to a contact",
        "s:17:8: joint.3.kind: is the joint behind bar 3"})
    EXPECT_NE(wrong.find(words), std::string::npos) << words << "\n" << wrong;
  says(pair, "bar.length: says not which of 2 bars", {"bar.length=2"});
  says(pair, "bar.5: there are 2 tables [[bar]]", {"bar.5.modulus=4"});
  says(pair, "bar.3: there are 2 tables [[bar]]", {"bar.3.modulus=4"});
  const auto by_waves = [](std::vector<std::string> settings) {
    settings.insert(settings.end(), {"method.name=characteristics", "bar.2.viscosity=0"});
    return settings;
  };
  says(pair, "method.name: characteristics carries waves unchanged, and bar.1.viscosity = 0.1", by_waves({}));
  says(pair, "bar.2.section: is not for characteristics", by_waves({"bar.1.viscosity=0", "bar.2.section=1+x"}));
  says(pair, "method.name: finite_difference takes one bar", {"method.name=finite_difference"});
  says(pair, "mesh.mass: \"redistributed\" does not fit", {"mesh.mass=redistributed"});
  says(pair, "bar.1.nodes: must go from 0 to bar.1.length = 1", {"bar.1.nodes=[0,0.5,2]"});
  says(pair, "bar.1.nodes: must rise by 1e-6 of bar.1.length", {"bar.1.nodes=[0,0.5,0.5,1]"});
  says(pair, "bar.1.grading: does not go with bar.1.nodes", {"bar.1.nodes=[0,0.5,1]", "bar.1.grading=2"});
  says(pair, "mesh.nodes: says not which of 2 bars: write bar.1.nodes", {"mesh.nodes=[0,1,2.5]"});
  says(pair, "bar.2.grading: has no end with an obstacle or a contact",
       {"joint.1.kind=bonded", "joint.1.gap=", "bar.2.velocity=1", "bar.2.grading=3"});
  says(pair, "span.gap", {"span.gap=2"});
  says(pair, "\"hertz\" is no law for exponential",
       {"joint.1.law=hertz", "joint.1.stiffness=3", "method.name=exponential"});
  says(pair, "joint.1.gap", {"bar.2.displacement=-0.1"});
  says(pair, "leaves a gap of 0.1 to the next bar", {"joint.1.kind=bonded", "joint.1.gap=", "bar.2.displacement=0.1"});
  says("[bar]\nlength = 1.0\n[[joint]]\nkind = \"bonded\"\n[initial]\nvelocity = 1.0\n[time]\nend = 1.0\n",
       "joint.1.kind: is between two tables [[bar]]");
  says(pair + "[[joints]]\nkind = \"bonded\"\n",
       "joints: unknown table; those of which there may be several are [[bar]]");
}

TEST(ChainInput, ASeriesReachesOverTheBarThatItIsOf) {
  const std::string series = "={ x = [0, 1.2], values = [1, 2] }";
  for (const std::string key : {"section", "displacement", "velocity"}) {
    EXPECT_EQ(complaint(pair, {"bar.1." + key + series, "joint.1.gap=9"}), "") << key;
    EXPECT_NE(complaint(pair, {"bar.2." + key + series, "joint.1.gap=9"})
                  .find("bar.2." + key + ": has values from x = 0 to 1.2, and the bar is from 0 to 1.5"),
              std::string::npos)
        << key;
  }
}

// Its node shares its place with that of the bar beside it.
TEST(ChainInput, ARigidBodyAtAnEndMeetsTheObstacleThereByItsOwnDisplacement) {
  for (const bool right : {false, true}) {
    const std::string body = "[[bar]]\nmass = 1\n", bar = "[[bar]]\nlength = 1\n";
    const std::string text = (right ? bar + body : body + bar) +
                             "[[joint]]\nkind = \"contact\"\ngap = 0.2\n[time]\nend = 1\n[initial]\nvelocity = 1\n" +
                             (right ? "[right]\nside = \"above\"\n" : "[left]\n") + "kind = \"obstacle\"\ngap = 0.05\n";
    const auto with = [&](const char* of_body, const char* of_bar) {
      return complaint(text, {std::string(right ? "bar.2" : "bar.1") + ".displacement=" + of_body,
                              std::string(right ? "bar.1" : "bar.2") + ".displacement=" + of_bar});
    };
    EXPECT_NE(with(right ? "0.08" : "-0.08", "0").find("penetrates the obstacle"), std::string::npos) << right;
    EXPECT_EQ(with("0", right ? "0.08" : "-0.08"), "") << right;
  }
}

TEST(ChainInput, DisplacementsMayTouchToARounding) {
  EXPECT_EQ(complaint(pair, {"bar.1.displacement=0.3", "bar.2.displacement=0.24999999999999997"}), "");
  EXPECT_NE(complaint(pair, {"bar.1.displacement=0.3", "bar.2.displacement=0.2499999"}), "");
  EXPECT_EQ(complaint(pair, {"left.kind=obstacle", "left.gap=0.1", "bar.1.displacement=-0.10000000000000002"}), "");
  EXPECT_NE(complaint(pair, {"left.kind=obstacle", "left.gap=0.1", "bar.1.displacement=-0.1000001"}), "");
}

TEST(ChainInput, ScenesDifferInTheirProblemAndNotInTheirMesh) {
  const auto differ = [](const char* setting) {
    const std::vector<std::string> settings = {setting};
    return differing_tables(complete(parse_scene(pair, "s")), complete(parse_scene(pair, "s", settings)));
  };
  EXPECT_EQ(differ("joint.1.gap=0.06"), "[joint]");
  EXPECT_EQ(differ("contact.restitution=0.5"), "[contact]");
  EXPECT_EQ(differ("parameters.a=1"), "[parameters]");
  EXPECT_EQ(differ("mesh.elements=60"), "");
}

TEST(ChainInput, ACheckForetellsWhenAJointCloses) {
  for (const char* method : {"cvode", "arkode", "ida", "odeint", "exponential", "rigid"}) {
    const std::vector<std::string> settings = {fmt::format("method.name={}", method)};
    const SceneCheck check = check_scene(parse_scene(pair, "", settings));
    ASSERT_TRUE(check.foreseen) << method;
    ASSERT_EQ(check.foreseen->impacts.size(), 1U) << method;
    const FirstImpact& impact = check.foreseen->impacts[0];
    EXPECT_EQ(impact.where, Where::joint);
    EXPECT_EQ(impact.joint, 1U);
    EXPECT_NEAR(impact.time, 0.05, 1e-5) << method;
    EXPECT_NEAR(impact.speed, 1.0, 1e-5) << method;
  }
}

TEST(ChainInput, OneTableAloneIsABar) {
  const std::string rest = "length = 1.0\nviscosity = 0.1\n[initial]\nvelocity = 1.0\n[time]\nend = 1.0\n";
  const SceneFile one = parse_scene("[[bar]]\n" + rest, ""), bar = parse_scene("[bar]\n" + rest, "");
  EXPECT_EQ(one.description(), bar.description());
}

// A scene is written as that scene, elements included.
TEST(ChainInput, WhatOneTableAloneHasOfItsOwnIsThatOfTheScene) {
  const auto scene = parse_scene(
      "[[bar]]\nlength = 2.0\nelements = 12\ngrading = 1.1\nvelocity = \"1+x\"\n[initial]\nvelocity = 5.0\n"
      "displacement = \"0.1*x\"\n[left]\nkind = \"obstacle\"\ngap = 0.1\n[time]\nend = 1.0\n",
      "");
  EXPECT_TRUE(scene.run.scene.chain.empty());
  EXPECT_EQ(scene.run.elements, 12U);
  EXPECT_EQ(scene.run.grading, 1.1);
  EXPECT_EQ(scene.run.scene.velocity(0.5), 1.5);
  EXPECT_EQ(scene.run.scene.displacement(0.5), 0.05);
  try {
    (void)parse_scene("[[bar]]\nlength = 2.0\nvelocity = \"1+y\"\n[time]\nend = 1.0\n", "s");
    FAIL();
  } catch (const SceneError& error) {
    EXPECT_NE(std::string(error.what()).find("s:3:12"), std::string::npos) << error.what();
  }
}

TEST(ChainInput, IsDescribedAsItWasUnderstood) {
  const std::vector<std::string> finer = {"mesh.elements=90"}, unlike = {"bar.1.nodes=[0,0.1,0.5,1]", "mesh.grading=3"};
  for (const std::vector<std::string>& settings : {std::vector<std::string>{}, finer, unlike}) {
    const SceneFile scene = parse_scene(pair, "", settings);
    const SceneFile again = described_scene(scene.description(), ""), text = parse_scene(scene_text(scene.values), "");
    EXPECT_EQ(again.description(), scene.description());
    EXPECT_EQ(text.description(), scene.description());
    EXPECT_EQ(elements_of(again.run), elements_of(scene.run));
    const Mesh mesh = scene.run.mesh();
    EXPECT_EQ(mesh.elements, scene.run.elements + 1);
    EXPECT_EQ(mesh.node(mesh.members->front().elements), 1.0);
    EXPECT_EQ(mesh.node(mesh.members->front().elements + 1), 1.0);
    EXPECT_EQ(mesh.node(mesh.elements), 2.5);
    for (std::size_t j = 0; j < mesh.elements; ++j) EXPECT_EQ(mesh.node(j), again.run.mesh().node(j));
  }
}

// By the time of a wave: 1 and 1.5 / sqrt(1.5).
TEST(ChainInput, SharesElementsByTheTimeOfAWave) {
  const Case run = parse_scene(pair, "").run;
  EXPECT_EQ(elements_of(run), (std::vector<std::size_t>{45, 55}));
  EXPECT_EQ(elements_of(parse_scene(pair, "", std::vector<std::string>{"bar.1.elements=10"}).run),
            (std::vector<std::size_t>{10, 12}));
}

// From a checkpoint in contact the run goes on with the same bits.
TEST(ChainCheckpoint, GoesOnWithTheSameBits) {
  for (const char* method : {"rigid", "cvode", "arkode"}) {
    const Case run = parse_scene(pair, "",
                                 std::vector<std::string>{fmt::format("method.name={}", method), "contact.epsilon=1e-4",
                                                          "contact.restitution=0"})
                         .run;
    const auto setup = resolve(run);
    const BarSystem system = setup.system();
    std::vector<double> whole, rest;
    std::optional<Checkpoint> middle;
    Observers observers;
    observers.energy = observers.account = true;
    observers.snapshot = [&](const Snapshot& at) { whole.insert(whole.end(), at.u.begin(), at.u.end()); };
    observers.checkpoints = Checkpoints{0.4, {}, [&](const Checkpoint& at) {
                                          if (!middle) middle = at;
                                          return RunControl::go_on;
                                        }};
    const Statistics done = simulate(setup, system, observers);
    ASSERT_TRUE(middle) << method;
    observers.snapshot = [&](const Snapshot& at) { rest.insert(rest.end(), at.u.begin(), at.u.end()); };
    const Statistics again = simulate(setup, system, *middle, observers);
    ASSERT_LT(rest.size(), whole.size());
    EXPECT_TRUE(std::equal(rest.rbegin(), rest.rend(), whole.rbegin())) << method;
    EXPECT_EQ(again.account->joints.at(0).impulse, done.account->joints.at(0).impulse) << method;
    EXPECT_EQ(again.energy->dissipated, done.energy->dissipated) << method;
  }
}

// Places of a bar that begins at x are told at x and more, and rounding must not tell one again: who walks them would
// never end.
TEST(ChainInput, PlacesRiseWhateverTheLengths) {
  const std::array<double, 3> bars[] = {{0.8073685867143122, -0.06981367968132002, 0.3312550660191371},
                                        {0.49614138201264696, 0.6141589647086545, -0.7811067000832328},
                                        {1.3168985033248566, 0.6141589647086545, 0.9970868031325117},
                                        {0.6333197414462723, -0.39105128412027934, 0.7314300628150268},
                                        {0.5220849543949122, -0.6422081530030908, -0.3881621737848254}};
  std::size_t places = 0;
  for (int k = 0; k < 100; ++k) {
    std::string text, joints;
    double whole = 0.0;
    for (const auto& [length, mean, wave] : bars) {
      const double own = length * (1.0 + 0.00137 * k);
      joints += whole > 0.0 ? "[[joint]]\nkind = \"contact\"\n" : "";
      whole += own;
      text += fmt::format("[[bar]]\nlength = {0}\nvelocity = \"-({1}+{2}*sin(3.141592653589793*x/{0})^4)\"\n", own,
                          mean, wave);
    }
    const Case run = parse_scene(text + joints + "[time]\nend = 1.0\n", "").run;
    for (const NextBreak& next : {run.scene.velocity_places.breaks, run.scene.velocity_places.detail}) {
      double before = -1.0;
      for (auto at = next(0.0, whole); at; at = next(*at, whole), ++places) {
        ASSERT_GT(*at, before) << k;
        before = *at;
      }
    }
  }
  EXPECT_GT(places, 400U);  // of joints alone
}

// Random chains: rigid contacts and stiff penalties of restitution 0 agree, energy and momentum are kept.
TEST(RandomChains, AgreeByMethods) {
  std::mt19937 random(44);
  const auto uniform = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  constexpr const char* kinds[] = {"bonded", "contact", "spring"};
  for (int trial = 0; trial < 12; ++trial) {
    const int bars = 2 + trial % 4;
    std::string text, joints;
    for (int k = 0; k < bars; ++k) {
      const double length = uniform(0.5, 2.0);
      text += fmt::format("[[bar]]\nlength = {}\ndensity = {}\nmodulus = {}\nviscosity = {}\nsection = \"{}+{}*x\"\n",
                          length, uniform(0.5, 2.0), uniform(0.5, 2.0), uniform(0.1, 0.3), uniform(0.5, 1.0),
                          uniform(0.0, 0.5));
      if (k + 1 == bars) continue;
      const char* kind = kinds[random() % 3];
      joints += fmt::format("[[joint]]\nkind = \"{}\"\n", kind);
      if (kind[0] == 's') joints += fmt::format("stiffness = {}\ndamping = {}\n", uniform(0.5, 5.0), uniform(0.0, 0.5));
      if (kind[0] == 'c') joints += fmt::format("gap = {}\n", uniform(0.0, 0.1));
    }
    const std::string rest = fmt::format(
        "[left]\nkind = \"obstacle\"\ngap = 0.05\n[right]\nkind = \"{}\"\n[initial]\nvelocity = \"cos({}*x)\"\n[time]\n"
        "end = 3.0\n[mesh]\nelements = 60\n[output]\nevery = 0.25\n[contact]\nepsilon = 1e-6\nrestitution = 0.0\n",
        trial % 2 ? "free" : "fixed", uniform(0.5, 2.0));
    const auto by = [&](const char* method, const char* tolerance) {
      return record(
          parse_scene(text + joints + rest, "",
                      std::vector<std::string>{fmt::format("method.name={}", method), "mesh.mass=fourth_order",
                                               fmt::format("method.relative_tolerance={}", tolerance)})
              .run);
    };
    const Recording rigid = by("rigid", "1e-9"), arkode = by("arkode", "1e-8");
    // The penalty gives way by some 1e-6; a node that its dashpot stops goes sqrt(epsilon) deep at speed 1, and there
    // are several contacts.
    for (std::size_t k = 0; k < rigid.u.size(); ++k)
      ASSERT_NEAR(rigid.u[k], arkode.u[k], 5.0 * std::sqrt(1e-6)) << trial << ' ' << text << joints;
    EXPECT_NEAR(rigid.statistics.energy->balance_error(), 0.0, 1e-7) << trial;
    EXPECT_NEAR(arkode.statistics.energy->balance_error(), 0.0, 1e-5) << trial;
  }
}

// More contacts than a search samples unasked, an end among them.
TEST(RandomChains, ManyContactsAreAllFound) {
  std::string text, joints;
  for (int k = 0; k < 7; ++k) {
    text += fmt::format("[[bar]]\nlength = 1.0\ndensity = {}\nviscosity = 0.2\nvelocity = {}\nelements = 10\n",
                        1.0 + 0.1 * k, 0.4 - 0.2 * k);
    if (k > 0) joints += fmt::format("[[joint]]\nkind = \"contact\"\ngap = {}\n", 0.02 * k);
  }
  const std::string rest =
      "[left]\nkind = \"obstacle\"\ngap = 0.05\n[time]\nend = 6.0\n[mesh]\nmass = \"fourth_order\"\n[output]\nevery = "
      "0.5\n[contact]\nepsilon = 1e-6\nrestitution = 0.0\n";
  const auto by = [&](const std::string& method) {
    return record(parse_scene(text + joints + rest, "",
                              std::vector<std::string>{"method.name=" + method, "method.step=5e-4",
                                                       "method.relative_tolerance=1e-8"})
                      .run);
  };
  const Recording rigid = by("rigid");
  EXPECT_GE(rigid.statistics.account->left.closings, 1U);
  for (const ContactAccount& joint : rigid.statistics.account->joints) EXPECT_GE(joint.closings, 1U);
  for (const char* method : {"cvode", "arkode", "fully_discrete"}) {
    const Recording other = by(method);
    for (std::size_t k = 0; k < rigid.u.size(); ++k) ASSERT_NEAR(rigid.u[k], other.u[k], 5e-3) << method << k;
    EXPECT_NEAR(rigid.statistics.account->left.impulse, other.statistics.account->left.impulse, 5e-3) << method;
  }
}

}  // namespace
}  // namespace viscobar

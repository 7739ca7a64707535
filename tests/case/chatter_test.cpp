#include "case/chatter.hpp"

#include <gtest/gtest.h>

#include <filesystem>

#include "support/paper_throw.hpp"
#include "viscobar/input/scene_file.hpp"

namespace viscobar {
namespace {

struct Heard {
  std::size_t changes = 0;
  std::vector<std::string> warnings;
};

Heard listen(const Case& run) {
  const BarSystem system = resolve(run).system();
  ChatterWatch watch(system);
  Heard heard;
  Observers observers;
  observers.event = [&](const Event& event) {
    ++heard.changes;
    if (const auto chatter = watch.heard(event))
      heard.warnings.push_back(chatter_warning(resolve(run), system, *chatter));
  };
  simulate(resolve(run), system, observers);
  return heard;
}

// A closing and an opening every `period` at the left end of a bar of length and wave speed 1.
std::optional<ChatterWatch::Chatter> after(std::size_t closings, double period) {
  const BarSystem system = resolve(paper_throw(0.0)).system();
  ChatterWatch watch(system);
  std::optional<ChatterWatch::Chatter> found;
  for (std::size_t k = 0; k < closings; ++k) {
    const double t = static_cast<double>(k) * period;
    if (const auto chatter = watch.heard({t, Where::left, 0, Change::closing, -1.0})) found = chatter;
    EXPECT_FALSE(watch.heard({t + period / 2, Where::left, 0, Change::opening, 1.0})) << "an opening is no bounce";
  }
  return found;
}

TEST(ChatterWatch, HearsAContactThatClosesFasterThanAWaveCrossesTheBarAndBack) {
  // 2 L / c = 2, in which 16 closings have 15 intervals.
  const auto chatter = after(16, 1.99 / 15);
  ASSERT_TRUE(chatter);
  EXPECT_EQ(chatter->where, Where::left);
  EXPECT_EQ(chatter->since, 0.0);
  EXPECT_FALSE(after(15, 1.99 / 15));
  EXPECT_FALSE(after(1000, 2.02 / 15)) << "a bar that bounces often, with time between";
}

// One lumped element without stiffness, whose right end is held: the left one is a mass of 1/2, and goes from stop to
// stop some 20 times while no wave comes back.
TEST(ChatterWatch, HearsNoneOfAMassBetweenTwoStops) {
  for (const char* stops : {"[left]\nkind = \"obstacle\"\ngap = 0.1\n[span]\ngap = 0.1\nside = \"above\"\n",
                            "[left]\nkind = \"obstacle\"\ngap = 0.1\nside = \"above\"\n[span]\ngap = 0.05\n",
                            "[span]\ngap = 0.1\nside = \"both\"\n"}) {
    const Heard heard = listen(
        parse_scene(std::string(stops) + "[bar]\nlength = 1.0\nmodulus = 1e-12\n[right]\nkind = \"fixed\"\n[initial]\n"
                                         "velocity = \"x-1\"\n[time]\nend = 8.0\n[mesh]\nelements = 1\nmass = "
                                         "\"lumped\"\n[contact]\nepsilon = 1e-6\n[method]\nname = \"cvode\"\n",
                    "scene")
            .run);
    EXPECT_GT(heard.changes, 64u) << stops;
    EXPECT_TRUE(heard.warnings.empty()) << stops;
  }
}

TEST(ChatterWatch, TellsARunOnce) {
  const BarSystem system = resolve(paper_throw(0.0)).system();
  ChatterWatch watch(system);
  std::size_t told = 0;
  for (int k = 0; k < 100; ++k)
    told +=
        watch.heard({1e-3 * k, k % 2 ? Where::left : Where::right, k % 2 ? 0u : 27u, Change::closing, -1.0}) ? 1 : 0;
  EXPECT_EQ(told, 1u);
}

TEST(ChatterWatch, AFrontUnderASpanIsNoChatter) {
  Case run = paper_throw(0.0);
  run.scene.left = run.scene.right = Free{};
  run.scene.span = Obstacle{0.1};
  run.elements = 1000;
  ChatterWatch watch(resolve(run).system());
  for (std::size_t node = 0; node <= 1000; ++node)
    EXPECT_FALSE(watch.heard({1e-6 * static_cast<double>(node), Where::span, node, Change::closing, -1.0}));
}

TEST(Chatter, IsWarnedOfWithRegimeAndRemedyByEveryMethodThatFollowsIt) {
  for (const double epsilon : {1e-5, 1e-7}) {
    for (const MethodName method : {MethodName::cvode, MethodName::ida, MethodName::arkode, MethodName::odeint}) {
      Case run = paper_throw(0.01);
      run.epsilon = epsilon;
      run.method = method;
      const Heard heard = listen(run);
      ASSERT_EQ(heard.warnings.size(), 1u) << name(method) << " " << epsilon;
      for (const char* part :
           {"zeta", "mesh.mass = \"redistributed\"", "contact.restitution = 0", "contact.epsilon of"})
        EXPECT_NE(heard.warnings[0].find(part), std::string::npos) << heard.warnings[0];
    }
  }
}

TEST(Chatter, IsNotWarnedOfOnceARemedyIsTaken) {
  Case run = paper_throw(0.01);
  run.epsilon = 1e-7;
  Case massless = run, inelastic = run, soft = run;
  massless.mass = Mass::redistributed;
  inelastic.restitution = 0.0;
  soft.epsilon = contact_regimes(resolve(run), resolve(run).system()).front().quiet_epsilon;
  for (const Case& cured : {massless, inelastic, soft}) EXPECT_TRUE(listen(cured).warnings.empty());
}

TEST(Chatter, OfASchemeIsThatOfItsRestitution) {
  Case run = paper_throw(0.01);
  run.method = MethodName::fully_discrete;
  run.step = 1e-4;
  EXPECT_TRUE(listen(run).warnings.empty());
  run.restitution = 1.0;
  const Heard heard = listen(run);
  ASSERT_EQ(heard.warnings.size(), 1u) << heard.changes;
  EXPECT_NE(heard.warnings[0].find("contact.restitution = 0"), std::string::npos) << heard.warnings[0];
}

TEST(Chatter, OrdinaryScenesHaveNone) {
  std::size_t scenes = 0;
  for (const auto& entry : std::filesystem::directory_iterator(VISCOBAR_SOURCE_DIR "/examples/scenes")) {
    const Case run = read_scene(entry.path()).run;
    if (entry.path().stem() == "chatter") continue;  // the one that has it
    EXPECT_TRUE(listen(run).warnings.empty()) << entry.path();
    ++scenes;
  }
  EXPECT_GT(scenes, 5u);
}

}  // namespace
}  // namespace viscobar

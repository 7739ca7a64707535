// How a run by characteristics is told, stopped and gone on with.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "characteristics/followed.hpp"
#include "characteristics/random_bar.hpp"
#include "support/allocations.hpp"
#include "viscobar/case/recording.hpp"
#include "viscobar/input/scene_file.hpp"

namespace viscobar {
namespace {

using oracle::RandomBar;

TEST(CharacteristicsRun, DoesNotDependOnItsOutputTimes) {
  for (std::uint32_t seed = 0; seed < 30; ++seed) {
    RandomBar random(seed);
    const Scene scene = random.scene(RandomBar::Loads::any);
    const Followed few = followed(scene, {0.0, 9.0}), many = followed(scene, equal_times(9.0, 90));
    ASSERT_EQ(few.events.size(), many.events.size());
    for (std::size_t k = 0; k < few.events.size(); ++k) EXPECT_EQ(few.events[k].time, many.events[k].time);
    EXPECT_EQ(few.u.back(), many.u.back());
    EXPECT_EQ(few.statistics.energy->final, many.statistics.energy->final);
    EXPECT_EQ(few.statistics.account->left.impulse, many.statistics.account->left.impulse);
  }
}

TEST(CharacteristicsRun, TellsEventsAndOutputsInOrderOfTime) {
  for (std::uint32_t seed = 0; seed < 30; ++seed) {
    RandomBar random(seed);
    const Scene scene = random.scene(RandomBar::Loads::none);
    double last = 0.0;
    std::size_t outputs = 0;
    Observers observers;
    observers.snapshot = [&](const Snapshot& now) {
      EXPECT_GE(now.time, last);
      last = now.time;
      ++outputs;
    };
    observers.event = [&](const Event& event) {
      EXPECT_GE(event.time, last);
      last = event.time;
    };
    const std::vector<double> times = equal_times(12.0, 37);
    integrate(scene, Mesh{scene.bar.length, 5}, std::nullopt, times, Characteristics{}, observers);
    EXPECT_EQ(outputs, times.size());
  }
}

// The run that makes checkpoints and each that begins from one of them are the same, bit for bit.
TEST(CharacteristicsRun, GoesOnFromEachOfItsCheckpointsBitForBit) {
  for (std::uint32_t seed = 0; seed < 40; ++seed) {
    RandomBar random(seed);
    const Scene scene = random.scene(RandomBar::Loads::any);
    const std::vector<double> times = equal_times(7.0, 23);
    std::vector<Checkpoint> checkpoints;
    Observers observers;
    observers.checkpoints.emplace().every = 0.9;
    observers.checkpoints->take = [&](const Checkpoint& one) {
      checkpoints.push_back(one);
      return RunControl::go_on;
    };
    const Followed whole = followed(scene, times, 8, observers);
    ASSERT_EQ(checkpoints.size(), 7u);
    for (const Checkpoint& from : checkpoints) {
      observers.checkpoints->take = [](const Checkpoint&) { return RunControl::go_on; };
      const Followed rest = followed(scene, times, 8, observers, from);
      ASSERT_EQ(rest.u.size() + from.outputs, whole.u.size());
      for (std::size_t k = 0; k < rest.u.size(); ++k) {
        ASSERT_EQ(rest.u[k], whole.u[k + from.outputs]) << "seed " << seed;
        ASSERT_EQ(rest.v[k], whole.v[k + from.outputs]) << "seed " << seed;
      }
      const std::size_t told = whole.events.size() - rest.events.size();
      for (std::size_t k = 0; k < rest.events.size(); ++k) ASSERT_EQ(rest.events[k].time, whole.events[told + k].time);
      const Statistics &a = whole.statistics, &b = rest.statistics;
      EXPECT_EQ(a.events, b.events);
      EXPECT_EQ(a.steps, b.steps);
      EXPECT_EQ(a.unknowns, b.unknowns);
      EXPECT_EQ(a.energy->work, b.energy->work);
      EXPECT_EQ(a.energy->final, b.energy->final);
      EXPECT_EQ(a.representation->error, b.representation->error);
      EXPECT_EQ(a.account->left.impulse, b.account->left.impulse);
      EXPECT_EQ(a.account->left.lowest, b.account->left.lowest);
      EXPECT_EQ(a.account->left.closings, b.account->left.closings);
    }
    // With and without checkpoints it is the same motion.
    EXPECT_EQ(followed(scene, times, 8).u.back(), whole.u.back());
  }
}

// The bouncing bar after 3000 periods, 18,000 passages: what comes back to a rounding of where it was is no new piece.
TEST(CharacteristicsRun, KeepsItsPiecesFewThroughThousandsOfPassages) {
  Scene scene;
  scene.bar = {10.0, 1.0, 900.0, 0.0};
  scene.left = Obstacle{5.0};
  scene.displacement = scene.velocity = [](double) { return 0.0; };
  scene.load = SteadyLoad{[](double) { return -10.0; }};
  const Followed run = followed(scene, {0.0, 16000.0});
  EXPECT_EQ(run.events.size(), 12000u);
  EXPECT_LT(run.statistics.unknowns, 100u);
  EXPECT_NEAR(run.events.back().time, 16000.0 - 1.0, 1e-8);
  EXPECT_LT(run.statistics.integration_seconds, 5.0);
}

// Each flight of an end leaves two breaks in what it sends, so that the waves of a bar that is pressed between two
// obstacles grow rough for ever. Pieces as steep as that had the search for changes go round in circles.
TEST(CharacteristicsRun, StopsWhereContactsHaveBrokenTheWavesTooFar) {
  Scene scene;
  scene.left = scene.right = Obstacle{0.5};
  scene.displacement = [](double x) { return 0.3 * x; };
  scene.velocity = [](double x) { return std::cos(3.0 * x); };
  scene.load = SteadyLoad{[](double) { return -1.0; }};
  const Statistics exact = followed(scene, {0.0, 60.0}).statistics;
  EXPECT_LT(exact.representation->error, exact.representation->rounding);
  EXPECT_LT(std::abs(exact.energy->balance_error()), 1e-12 * largest_energy(*exact.energy));
  try {
    followed(scene, {0.0, 300.0});
    FAIL() << "ends?";
  } catch (const IntegrationError& error) {
    EXPECT_GT(error.statistics.reached_time, 100.0);
    EXPECT_GT(error.statistics.events, 20'000u);
    EXPECT_NE(std::string(error.what()).find("broken the waves"), std::string::npos) << error.what();
  }
}

TEST(CharacteristicsRun, AsksForNoMemoryFromPassageToPassage) {
  Scene scene;
  scene.left = scene.right = Obstacle{0.5};
  scene.displacement = [](double x) { return 0.1 * x; };
  scene.velocity = [](double x) { return x - 0.5; };
  const auto allocations = [&](double end) {
    const std::size_t before = testing_support::allocations;
    integrate(scene, Mesh{1.0, 10}, std::nullopt, std::vector<double>{0.0, end}, Characteristics{}, {});
    return testing_support::allocations - before;
  };
  scene.left = Free{};
  scene.right = Fixed{};
  allocations(10.0);
  EXPECT_EQ(allocations(100.0), allocations(1000.0));
}

// One of area A, with A times the forces, masses and springs, moves alike; its forces and energies are A times as
// large.
TEST(CharacteristicsRun, AConstantSectionMultipliesForcesAndEnergies) {
  const auto run = [](double area) {
    return parse_scene(
               fmt::format(
                   "[bar]\nlength = 1\nsection = {0}\n[left]\nkind = \"obstacle\"\ngap = 0.1\n[right]\nkind = "
                   "\"free\"\nmass = {1}\nstiffness = {2}\ndashpot = {3}\nforce = \"{4}*sin(2*t)\"\n[initial]\n"
                   "displacement = \"0.05*x\"\nvelocity = -1\n[load]\ndensity = \"(1+x)*cos(3*t)\"\n[time]\nend = 4\n"
                   "[mesh]\nelements = 20\n[method]\nname = \"characteristics\"\n",
                   area, 0.4 * area, 3.0 * area, 0.2 * area, 0.7 * area),
               "")
        .run;
  };
  constexpr double area = 2.5;
  const Recording one = record(run(1.0)), wide = record(run(area));
  ASSERT_GE(one.events.size(), 2u);
  ASSERT_EQ(one.events.size(), wide.events.size());
  for (std::size_t k = 0; k < one.events.size(); ++k) EXPECT_NEAR(one.events[k].time, wide.events[k].time, 1e-9);
  double most = 0.0;
  for (std::size_t k = 0; k < one.times.size(); ++k) {
    for (std::size_t j = 0; j < one.mesh.nodes(); ++j)
      ASSERT_NEAR(one.displacement(k)[j], wide.displacement(k)[j], 1e-9) << one.times[k];
    ASSERT_NEAR(area * one.reaction_left[k], wide.reaction_left[k], 1e-8);
    most = std::max(most, one.reaction_left[k]);
    ASSERT_NEAR(area * one.energy[k].total(), wide.energy[k].total(), 1e-8);
    ASSERT_NEAR(area * one.energy[k].work, wide.energy[k].work, 1e-8);
  }
  EXPECT_GT(most, 0.5);
  EXPECT_NEAR(wide.statistics.energy->balance_error(), 0.0, 1e-9);
}

}  // namespace
}  // namespace viscobar

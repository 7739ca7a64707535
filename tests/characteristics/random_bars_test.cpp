// Random bars against a difference scheme and against their own symmetries; measure_characteristics has thousands.
#include <gtest/gtest.h>

#include <array>

#include "characteristics/cell_waves.hpp"
#include "characteristics/followed.hpp"
#include "characteristics/random_bar.hpp"
#include "support/maximum_norm.hpp"

namespace viscobar {
namespace {

using oracle::CellWaves;
using oracle::RandomBar;

class RandomBars : public testing::TestWithParam<RandomBar::Loads> {};
INSTANTIATE_TEST_SUITE_P(Loads, RandomBars, testing::Values(RandomBar::Loads::none, RandomBar::Loads::any),
                         [](const auto& kind) { return kind.param == RandomBar::Loads::none ? "none" : "any"; });

// The scheme is wrong by a cell's passage at each change of a contact and at each jump, and its bar by as much after
// it: up to 36 / N in 400 scenes.
TEST_P(RandomBars, MoveAsADifferenceSchemeSays) {
  const std::size_t cells = GetParam() == RandomBar::Loads::none ? 4000 : 400, every = cells / 20;
  for (std::uint32_t seed = 0; seed < 150; ++seed) {
    RandomBar random(seed);
    const Scene scene = random.scene(GetParam());
    const std::size_t steps = cells * static_cast<std::size_t>(1 + random.one_of(8));
    const CellWaves scheme(scene, cells, steps);
    std::vector<double> times;
    for (std::size_t k = 0; k <= steps; k += every) times.push_back(scheme.step * static_cast<double>(k));
    const Followed run = followed(scene, times, 20);
    const double bound = 100.0 / static_cast<double>(cells) * largest(run);
    for (std::size_t k = 0; k < times.size(); ++k) {
      ASSERT_NEAR(run.u[k].front(), scheme.left[k * every], bound) << "seed " << seed << ", t = " << times[k];
      ASSERT_NEAR(run.u[k].back(), scheme.right[k * every], bound) << "seed " << seed << ", t = " << times[k];
    }
    for (std::size_t j = 0; j <= 20; ++j)
      ASSERT_NEAR(run.u.back()[j], scheme.nodes[j * every], bound) << "seed " << seed << ", node " << j;
  }
}

// Roundings of some hundred operations a passage.
TEST_P(RandomBars, KeepTheirEnergy) {
  for (std::uint32_t seed = 200; seed < 350; ++seed) {
    RandomBar random(seed);
    const Scene scene = random.scene(GetParam());
    const EnergyAccount energy = *followed(scene, {0.0, random.uniform(0.1, 30.0)}).statistics.energy;
    EXPECT_LT(std::abs(energy.balance_error()), 1e-12 * largest_energy(energy)) << "seed " << seed;
    EXPECT_EQ(energy.dissipated, 0.0);
  }
}

// A bar multiplies what it is given by up to a few at each change.
TEST(RandomBars, AreTheSameInAMirror) {
  for (std::uint32_t seed = 400; seed < 500; ++seed) {
    RandomBar random(seed);
    const Scene scene = random.scene(RandomBar::Loads::none);
    const double length = scene.bar.length;
    Scene mirror = scene;
    std::swap(mirror.left, mirror.right);
    mirror.displacement = [&](double x) { return scene.displacement(length - x); };
    mirror.velocity = [&](double x) { return scene.velocity(length - x); };
    const std::vector<double> times = equal_times(4.0 * length / scene.bar.wave_speed(), 40);
    const Followed one = followed(scene, times), other = followed(mirror, times);
    for (std::size_t k = 0; k < times.size(); ++k) {
      std::vector<double> reversed(other.u[k].rbegin(), other.u[k].rend());
      ASSERT_LT(distance(one.u[k], reversed), 1e-11 * largest(one)) << "seed " << seed << ", t = " << times[k];
    }
  }
}

// Length by 2^3, time by 2^2, mass by 2^-5.
TEST_P(RandomBars, DoNotKnowTheirUnits) {
  constexpr double length = 8.0, time = 4.0, mass = 1.0 / 32.0;
  for (std::uint32_t seed = 500; seed < 540; ++seed) {
    RandomBar random(seed);
    const Scene scene = random.scene(GetParam());
    Scene other = scene;
    other.bar.length *= length;
    other.bar.density *= mass / (length * length * length);
    other.bar.modulus *= mass / (length * time * time);
    other.displacement = [&](double x) { return length * scene.displacement(x / length); };
    other.velocity = [&](double x) { return length / time * scene.velocity(x / length); };
    for (EndCondition* end : {&other.left, &other.right})
      if (auto* obstacle = std::get_if<Obstacle>(end)) obstacle->gap *= length;
    const double force = mass / (length * length * time * time);
    if (scene.load) {
      if (const auto* steady = std::get_if<SteadyLoad>(&*scene.load))
        other.load = SteadyLoad{[=](double x) { return force * steady->profile(x / length); }};
      else
        continue;
    }
    const Followed one = followed(scene, equal_times(10.0, 20)), scaled = followed(other, equal_times(10.0 * time, 20));
    ASSERT_EQ(one.events.size(), scaled.events.size());
    for (std::size_t k = 0; k < one.u.size(); ++k)
      for (std::size_t j = 0; j < one.u[k].size(); ++j) ASSERT_EQ(length * one.u[k][j], scaled.u[k][j]) << seed;
  }
}

// int rho v dx from the nodes, which see a jump to half an element.
TEST(RandomBars, GainTheMomentumOfTheirImpulses) {
  constexpr std::size_t elements = 4000;
  for (std::uint32_t seed = 700; seed < 760; ++seed) {
    RandomBar random(seed);
    const Scene scene = random.scene(RandomBar::Loads::none);
    if (is_fixed(scene.left) || is_fixed(scene.right)) continue;
    const Followed run = followed(scene, {0.0, random.uniform(1.0, 20.0)}, elements);
    std::array<double, 2> momentum{};
    double speed = 0.0;
    for (std::size_t k = 0; k < 2; ++k)
      for (std::size_t j = 0; j <= elements; ++j) {
        momentum[k] += run.v[k][j] * (j % elements == 0 ? 0.5 : 1.0);
        speed = std::max(speed, std::abs(run.v[k][j]));
      }
    const double mass = scene.bar.density * scene.bar.length / elements;
    const double impulse = run.statistics.account->left.impulse + run.statistics.account->right.impulse;
    // Some twenty jumps of 2 max|v| each.
    EXPECT_NEAR(mass * (momentum[1] - momentum[0]), impulse, 40.0 * mass * speed) << seed;
  }
}

// Nothing dissipates, so the film may be shown backwards. The last field is known at the nodes, between which it is
// taken as straight: kinks and jumps are wrong by an element.
TEST(RandomBars, RunBackwards) {
  constexpr std::size_t elements = 400;
  for (std::uint32_t seed = 800; seed < 830; ++seed) {
    RandomBar random(seed);
    const Scene scene = random.scene(RandomBar::Loads::none);
    const std::vector<double> times = equal_times(random.uniform(1.0, 6.0), 30);
    const Followed run = followed(scene, times, elements);
    const auto straight = [&](const std::vector<double>& nodes, double sign) {
      return [=, length = scene.bar.length](double x) {
        const double place = x / length * elements;
        const std::size_t j = std::min(elements - 1, static_cast<std::size_t>(place));
        return sign * (nodes[j] + (place - static_cast<double>(j)) * (nodes[j + 1] - nodes[j]));
      };
    };
    Scene back = scene;
    back.displacement = straight(run.u.back(), 1.0);
    back.velocity = straight(run.v.back(), -1.0);
    const Followed film = followed(back, times, elements);
    for (std::size_t k = 0; k < times.size(); ++k)
      EXPECT_NEAR(film.u[times.size() - 1 - k][0], run.u[k][0], 100.0 / elements * largest(run)) << seed;
  }
}

// A wave that is carried unchanged keeps its breaks where they were.
TEST(RandomBars, ReturnToTheirDataAfterAThousandPassages) {
  for (std::uint32_t seed = 600; seed < 640; ++seed) {
    RandomBar random(seed);
    Scene scene = random.scene(RandomBar::Loads::none);
    scene.left = scene.right = Fixed{};
    // Ends that stand still, as their velocity does: no jump there, so that the data come back bit by bit but for sums.
    const double period = 2.0 * scene.bar.length / scene.bar.wave_speed();
    const Followed run = followed(scene, {0.0, 500.0 * period}, 20);
    EXPECT_LT(distance(run.u[0], run.u[1]), 1e-12) << seed;
  }
}

}  // namespace
}  // namespace viscobar

// An ensemble tells of each bar what its own run does.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "ensemble/random_ensemble.hpp"

namespace {

using namespace viscobar;

double largest_of(std::span<const double> values) {
  double largest = 0.0;
  for (const double value : values)
    if (std::isfinite(value)) largest = std::max(largest, std::abs(value));
  return largest;
}

// Both do the arithmetic of one scheme in another order. Its steps do not amplify roundings but for the condition of
// M, some hundred, and add up 400 of them; accelerations have them over dt, 1e-3.
TEST(Ensemble, LanesAreTheSchemeToRounding) {
  std::mt19937_64 random(11);
  std::size_t compared = 0, decided_by_rounding = 0;
  for (int scene = 0; scene < 60; ++scene) {
    TextEnsemble made = random_ensemble(random, 20);
    const double end = made.run(made.of(0)).end;
    made.scene += fmt::format("[method]\nname=\"fully_discrete\"\nstep={}\nstart=\"{}\"\n",
                              end / std::uniform_real_distribution<double>(60.0, 400.0)(random),
                              scene % 2 == 0 ? "first_order" : "second_order");
    EnsembleStudy study = made.study();
    study.outputs = {"u_left@0.07",  "v_right@0.11", "reaction_left@0.13", "events:6",
                     "impulse_left", "peak_left",    "gauge:0.3@0.2",      "final"};
    const EnsembleResult lanes = ensemble(study);
    study.lanes = false;
    const EnsembleResult alone = ensemble(study);
    for (std::size_t i = 0; i < lanes.bars; ++i) {
      ASSERT_EQ(lanes.ways[i], BarWay::lanes) << made.scene;
      ASSERT_EQ(alone.ways[i], BarWay::alone);
      bool differs = false;
      for (std::size_t o = 0; o < lanes.outputs.size(); ++o) {
        const std::size_t width = lanes.outputs[o].width();
        const std::span<const double> mine = std::span(lanes.values[o]).subspan(i * width, width),
                                      theirs = std::span(alone.values[o]).subspan(i * width, width);
        const double scale = std::max(largest_of(theirs), 1e-3);
        for (std::size_t k = 0; k < width; ++k) {
          if (std::isnan(mine[k]) && std::isnan(theirs[k])) continue;
          differs |= !(std::abs(mine[k] - theirs[k]) <= 1e-10 * scale);
        }
      }
      ++compared;
      decided_by_rounding += differs;
    }
  }
  EXPECT_EQ(compared, 1200u);
  // A node that only just touches does so by a rounding.
  EXPECT_LE(decided_by_rounding, 12u);
  std::printf("decided by rounding: %zu of %zu\n", decided_by_rounding, compared);
}

// `redistributed` takes the mass of a bare node alone, and of which it is bare may differ from bar to bar.
TEST(Ensemble, NodesWithASpringKeepTheirMass) {
  TextEnsemble made{
      "[bar]\nlength=1.2\nviscosity=0.17\n[left]\nkind=\"obstacle\"\ngap=0.3\nside=\"above\"\ndashpot=0.15\n[right]\n"
      "kind=\"obstacle\"\ngap=0.03\n[initial]\nvelocity=\"0.3*x-0.4\"\n[mesh]\nelements=12\nmass=\"redistributed\"\n"
      "[time]\nend=2.2\n[method]\nname=\"fully_discrete\"\nstep=0.002\n",
      {"bar.density"},
      {{0.7, 1.0, 1.3}}};
  for (const char* key : {"bar.density", "left.dashpot"}) {
    made.keys[0] = key;
    if (made.keys[0] == "left.dashpot") made.values[0] = {0.0, 0.1, 0.2};
    EnsembleStudy study = made.study();
    study.outputs = {"u_left@0.1", "u_right@0.1"};
    const EnsembleResult lanes = ensemble(study);
    EXPECT_EQ(lanes.ways[2], made.keys[0] == "bar.density" ? BarWay::lanes : BarWay::alone);
    study.lanes = false;
    const EnsembleResult alone = ensemble(study);
    for (std::size_t o = 0; o < lanes.outputs.size(); ++o)
      for (std::size_t k = 0; k < lanes.values[o].size(); ++k)
        EXPECT_NEAR(lanes.values[o][k], alone.values[o][k], 1e-12) << key << " " << lanes.outputs[o].name << " " << k;
  }
}

// On 4 elements a blow at one end moves the other by 1 % of what it moves its own.
TEST(Ensemble, LanesStruckAtBothEndsAtTheStartAreTheScheme) {
  for (const char* mass : {"consistent", "fourth_order"}) {
    const TextEnsemble made{fmt::format("[bar]\nlength=1\nviscosity=0.1\n[left]\nkind=\"obstacle\"\ngap=0\n[right]\n"
                                        "kind=\"obstacle\"\ngap=0\n[initial]\nvelocity=-1\n[mesh]\nelements=4\n"
                                        "mass=\"{}\"\n[time]\nend=0.5\n[method]\nname=\"fully_discrete\"\nstep=0.01\n",
                                        mass),
                            {"bar.viscosity"},
                            {{0.1, 0.2}}};
    EnsembleStudy study = made.study();
    study.outputs = {"u_left@0.01", "u_right@0.01", "reaction_left@0.01", "impulse_left", "impulse_right"};
    const EnsembleResult lanes = ensemble(study);
    study.lanes = false;
    const EnsembleResult alone = ensemble(study);
    ASSERT_EQ(lanes.ways[0], BarWay::lanes);
    for (std::size_t o = 0; o < lanes.outputs.size(); ++o)
      for (std::size_t k = 0; k < lanes.values[o].size(); ++k)
        EXPECT_NEAR(lanes.values[o][k], alone.values[o][k], 1e-10 * largest_of(alone.values[o]))
            << mass << " " << lanes.outputs[o].name << " " << k;
  }
}

}  // namespace

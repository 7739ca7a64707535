// The scenes of docs/gallery.md, each as a user runs it but for the method, which is chosen: what is exact of them.
// Tolerances of characteristics are some hundred roundings a passage.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "gallery/period_three.hpp"
#include "viscobar/case/recording.hpp"
#include "viscobar/input/scene_file.hpp"

namespace viscobar {
namespace {

struct Told {
  Recording recording;
  RunAccount account;
};

Told automatically(const std::string& name, const std::vector<std::string>& overrides = {}) {
  Case run = read_scene(VISCOBAR_SOURCE_DIR "/examples/scenes/" + name + ".toml", overrides).run;
  run.epsilon.reset();
  run.method = automatic_method(run).method;
  EXPECT_EQ(run.method, run.scene.bar.viscosity > 0.0 ? MethodName::rigid : MethodName::characteristics) << name;
  Told told{record(run), {}};
  Observers observers;
  observers.account = true;
  told.account = *simulate(resolve(run), observers).account;
  return told;
}

TEST(Gallery, BouncingBarOfDoyenErnAndPiperno) {
  const auto [recording, account] = automatically("bouncing");
  ASSERT_EQ(recording.events.size(), 40u);
  constexpr double changes[] = {1.0, 5.0 / 3.0, 11.0 / 3.0, 13.0 / 3.0};
  for (std::size_t k = 0; k < 40; ++k)
    EXPECT_NEAR(recording.events[k].time, 16.0 / 3.0 * static_cast<double>(k / 4) + changes[k % 4], 1e-12);
  EXPECT_NEAR(account.left.impulse, 20 * 800.0 / 3, 1e-9);
  for (std::size_t k = 0; k < recording.times.size(); ++k)
    if (const double t = std::fmod(recording.times[k], 16.0 / 3.0); t <= 1.0) {
      EXPECT_NEAR(recording.displacement(k)[0], -5.0 * t * t, 5e-10) << recording.times[k];
    }
}

TEST(Gallery, NonsmoothModeOfABar) {
  const auto [recording, account] = automatically("nonsmooth-mode");
  ASSERT_EQ(recording.events.size(), 21u);
  for (std::size_t k = 1; k < 21; ++k)
    EXPECT_NEAR(recording.events[k].time, 3.5 * static_cast<double>(k / 2) + (k % 2 == 1 ? 0.25 : -0.25), 1e-12);
  EXPECT_NEAR(account.left.peak_reaction, 0.2, 1e-12);
  EXPECT_NEAR(account.left.highest, -0.1 + 2 * 0.1 * (1.75 - 0.25), 1e-12);
  EXPECT_NEAR(recording.statistics.energy->final, 0.02, 1e-13);
}

// Order four: 4e-9 on 120 elements (docs/fourth-order.md), and what the exact values have of digits.
TEST(Gallery, ReboundOfAViscousBar) {
  const auto [recording, account] = automatically("rebound");
  ASSERT_EQ(recording.events.size(), 2u);
  EXPECT_NEAR(recording.events[1].time, 1.9124710098, 4e-9);
  EXPECT_NEAR(account.left.impulse - 1.0, 0.6507936369, 4e-9);
}

TEST(Gallery, SteelBarsOfSiconosAndCodeAster) {
  struct Steel {
    const char* file;
    double touch, contact, impulse, stress;
  };
  const double c = std::sqrt(210e9 / 7800);
  for (const Steel& steel : {Steel{"impacting-bar", 5e-4, 2 * 0.99 / c, 2 * 7800 * 0.99 * 0.1, 7800 * c * 0.1},
                             Steel{"steel-impact", 2e-5, 8e-5, 2 * 8000 * 0.2 * 100, 4e9}}) {
    const auto [recording, account] = automatically(steel.file);
    ASSERT_EQ(recording.events.size(), 2u);
    EXPECT_NEAR(recording.events[0].time, steel.touch, 1e-9 * steel.touch);
    EXPECT_NEAR(recording.events[1].time - recording.events[0].time, steel.contact, 1e-9 * steel.contact);
    EXPECT_NEAR(account.left.impulse, steel.impulse, 1e-9 * steel.impulse);
    EXPECT_NEAR(account.left.peak_reaction, steel.stress, 1e-9 * steel.stress);
  }
}

TEST(Gallery, PeriodThreeBarOfDabaghiPetrovPousinAndRenard) {
  const auto [recording, account] = automatically("period-3", {"time.end=12", "mesh.elements=20"});
  for (std::size_t k = 0; k < recording.times.size(); ++k)
    for (std::size_t j = 0; j <= 20; ++j)
      EXPECT_NEAR(recording.displacement(k)[j], period_three(recording.mesh.node(j), recording.times[k]), 1e-12);
  EXPECT_NEAR(account.left.impulse, 4 * 0.5, 1e-12);
}

// Beside 0.105 to 0.307 of others on 20 elements.
TEST(Gallery, PeriodThreeBarOnAMeshIsNearerThanThePublishedOnes) {
  for (const char* method : {"rigid", "fully_discrete"}) {
    const Case run = read_scene(VISCOBAR_SOURCE_DIR "/examples/scenes/period-3.toml",
                                std::vector<std::string>{"time.end=12", "output.every=0.01", "mesh.elements=20",
                                                         "method.step=0.002", std::string("method.name=") + method})
                         .run;
    EXPECT_LT(error_of_period_three(record(run)), 0.07) << method;
  }
}

}  // namespace
}  // namespace viscobar

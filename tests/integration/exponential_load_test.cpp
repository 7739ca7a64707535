// Loads by the exponential method, which takes them as polynomials of each step; held to rounding like the rest of it.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <optional>
#include <string>

#include "support/exponential_runs.hpp"
#include "viscobar/case/recording.hpp"
#include "viscobar/input/scene_file.hpp"

namespace viscobar::testing_exponential_load {
namespace {

using namespace testing_support;

TEST(Exponential, SteadyLoadOnAFreeBarGivesAParabolaOfTime) {
  Scene scene = falling_bar(1.0, 0.5, 0.0);
  scene.left = Free{};
  scene.load = SteadyLoad{[](double) { return 3.0; }};
  for (const Mass mass : {Mass::consistent, Mass::lumped}) {
    const auto run = record(BarSystem(scene, Mesh{1.0, 20}, mass), grid(4.0, 5));
    for (std::size_t k = 0; k < run.times.size(); ++k) {
      const double t = run.times[k];
      for (std::size_t j = 0; j < run.u[k].size(); ++j) {
        EXPECT_NEAR(run.u[k][j], -0.5 * t + 1.5 * t * t, 24 * accuracy);  // of the largest displacement
        EXPECT_NEAR(run.v[k][j], -0.5 + 3.0 * t, 12 * accuracy);
      }
    }
  }
}

TEST(Exponential, CrossesAJumpOfTheLoad) {
  // v = 1 for t > 1 after a unit of momentum in [0, 1].
  Scene scene = falling_bar(1.0, 0.0, 0.1);
  scene.left = Free{};
  scene.load = SeparableLoad{[](double) { return 1.0; }, [](double t) { return t < 1 ? 1.0 : 0.0; }};
  const auto run = record(BarSystem(scene, Mesh{1.0, 6}, Mass::consistent), {0.0, 0.3, 3.0});
  for (const double u : run.u.back()) EXPECT_NEAR(u, 2.5, 3 * accuracy);
}

TEST(Exponential, CrossesKinksOfTheLoadAndIsNotHeldUpByItsRounding) {
  // A unit |sin 5 t| gives 2/5 of momentum each pi/5; v - v(T)/2 is odd about T/2, so that u(T) = T v(T) / 2. Late in
  // the run the rounding of t alone disturbs the load by more than 1e-14.
  Scene scene = falling_bar(1.0, 0.0, 0.0);
  scene.left = Free{};
  scene.load = SeparableLoad{[](double) { return 1.0; }, [](double t) { return std::abs(std::sin(5 * t)); }};
  const double end = 20 * std::numbers::pi / 5, u = end * 8.0 / 2;
  const auto run = record(BarSystem(scene, Mesh{1.0, 6}, Mass::consistent), {0.0, end});
  for (const double found : run.u.back()) EXPECT_NEAR(found, u, u * accuracy);
  EXPECT_LT(run.statistics.steps, 20 * 2 * 64u);  // a step a halving, down to rounding and up again at each kink
}

// Each piece adds a little to what the load is made of: parts of one rounding, which stay orthogonal.
TEST(Exponential, APulseThatTravelsIsFollowedInAsManyPiecesAsThereAre) {
  Case run =
      parse_scene(
          "[bar]\nlength = 1.0\ndensity = 0.831\nmodulus = 1.566\nviscosity = 0.134\n[right]\nkind = \"fixed\"\n"
          "[load]\ndensity = \"3*exp(-((x-1.25*t)/0.08)^2)\"\n[mesh]\nelements = 120\n[time]\nend = 0.45\n[output]\n"
          "every = 0.45\n[method]\nname = \"exponential\"\n",
          "")
          .run;
  std::vector<std::vector<double>> found;
  for (const bool in_pieces : {false, true}) {
    if (in_pieces)
      std::get<GeneralLoad>(*run.scene.load).breaks = [piece = 2.687 / 16384](double after, double until) {
        const double next = (std::floor(after / piece + 1e-6) + 1.0) * piece;
        return next < until ? std::optional(next) : std::nullopt;
      };
    found.push_back(viscobar::record(run).u);
  }
  for (std::size_t j = 0; j < found[0].size(); ++j) EXPECT_NEAR(found[1][j], found[0][j], 1e-12) << j;
}

// A force of triangles with the impulse 1: t is known to a rounding, 4e-16 of it, and the force to that times its
// slope.
TEST(Exponential, FollowsAFrontAsSteepAsTimeHasDigits) {
  for (const double width : {1e-3, 1e-6, 1e-8}) {
    Scene scene = falling_bar(1.0, 0.0, 0.4);
    scene.left = Free{};
    EndForce force{[=](double t) { return std::max(0.0, 1.0 - std::abs(t - 3.1415) / width) / width; }};
    force.breaks = [=](double after, double until) -> std::optional<double> {
      for (const double at : {3.1415 - width, 3.1415, 3.1415 + width})
        if (at > after && at < until) return at;
      return std::nullopt;
    };
    scene.right_input.force = force;
    const auto run = record(BarSystem(scene, Mesh{1.0, 6}, Mass::consistent), {0.0, 3.0, 20.0});
    const double rounding = 4e-16 / width;                  // of the force in the largest, 1 / width
    const double vibration = std::exp(-0.2 * 9.87 * 16.8);  // that is left, of the slowest mode
    for (const double u : run.u.back())
      EXPECT_NEAR(u, 20.0 - 3.1415, 17.0 * (8.0 * rounding + accuracy) + vibration) << width;
  }
}

TEST(Exponential, FollowsALoadOverAllDecadesThatNumbersHave) {
  // A blow of the shape exp(-400 (t - s)^2) has the impulse sqrt(pi/400) at s. It grows and falls by 745 powers of e
  // within the range of numbers; a step of degree 12 follows one to rounding, and one of half a power is tried at
  // worst.
  const double s = 1.646, impulse = -1.3 * std::sqrt(std::numbers::pi / 400);
  const SeparableLoad blow{[](double) { return -1.3; }, [s](double t) { return std::exp(-400 * (t - s) * (t - s)); }};
  for (const bool moving : {false, true}) {
    Scene scene = falling_bar(1.0, moving ? 1.0 : 0.0, 0.1);
    scene.left = Free{};
    scene.load = blow;
    const auto run = record(BarSystem(scene, Mesh{1.0, 5}, Mass::consistent), {0.0, 4.0});
    for (const double u : run.u.back()) EXPECT_NEAR(u, impulse * (4 - s) - (moving ? 4 : 0), 4 * accuracy);
    EXPECT_LT(run.statistics.steps, moving ? 500u : 4 * 745u);  // beside a motion of size 1, 700 of them are nothing
  }
  const SteadyLoad tiny{[](double x) { return 1e-200 * (1 + x); }};
  Scene scene = falling_bar(1.0, 0.0, 0.1);
  scene.left = Free{};
  scene.load = SeparableLoad{tiny.profile, [](double t) { return std::cos(3 * t); }};
  const auto run = record(BarSystem(scene, Mesh{1.0, 5}, Mass::lumped), {0.0, 4.0});
  double mean = 0.0;
  for (std::size_t j = 0; j < 6; ++j) mean += run.u.back()[j] * (j % 5 == 0 ? 0.1 : 0.2);
  EXPECT_NEAR(mean, 1.5e-200 * (1 - std::cos(12.0)) / 9, 4 * accuracy * 1e-200);
}

TEST(Exponential, ALoadThatNoPolynomialFollowsIsAnError) {
  Scene scene = falling_bar(1.0, 0.0, 0.1);
  scene.load = SeparableLoad{[](double) { return 1.0; }, [](double t) { return 1.0 + 1e-6 * std::sin(1e20 * t); }};
  try {
    record(BarSystem(scene, Mesh{1.0, 6}, Mass::consistent), {0.0, 3.0});
    FAIL() << "ran through";
  } catch (const IntegrationError& error) {
    EXPECT_NE(std::string(error.what()).find("load is too rough"), std::string::npos) << error.what();
    EXPECT_FALSE(error.statistics.completed);
  }
}

TEST(Exponential, ALoadThatIsNotFiniteStopsTheRunAndSaysWhen) {
  Scene scene = falling_bar(0.2, 1.0, 0.1);
  scene.load = SeparableLoad{[](double) { return 1.0; }, [](double t) { return std::sqrt(0.5 - t); }};
  try {
    record(BarSystem(scene, Mesh{1.0, 6}, Mass::consistent), grid(1.0, 4));
    FAIL() << "ran through";
  } catch (const IntegrationError& error) {
    EXPECT_NE(std::string(error.what()).find("history of the load"), std::string::npos) << error.what();
    EXPECT_GT(error.statistics.reached_time, 0.1);
    EXPECT_LE(error.statistics.reached_time, 0.5);
  }
}

// 1 - cos is known to roundings of 1, so that (1 - cos 2t)^4 = 16 t^8 - ... has no digits at its beginning. The bar is
// linear: it answers to a load of any size alike.
TEST(Exponential, FollowsALoadThatBeginsWithoutDigits) {
  const auto times = uniform_times(0.25, 8);
  const auto driven = [&](double size, const auto& method, Mass mass) {
    Scene scene;
    scene.bar.viscosity = 0.1;
    scene.displacement = scene.velocity = [](double) { return 0.0; };
    scene.left_input.force = EndForce{[size](double t) { return size * std::pow(1.0 - std::cos(2.0 * t), 4); }, {}};
    return viscobar::record(BarSystem(scene, {1.0, 12}, mass), times, method).u.back();
  };
  for (const Mass mass : {Mass::consistent, Mass::redistributed, Mass::fourth_order}) {
    const auto large = driven(1.0, Exponential{}, mass), other = driven(1.0, Cvode{{1e-4}, {1e-10}}, mass);
    for (const double size : {1.0, 1e-3, 1e-12}) {
      const auto u = driven(size, Exponential{}, mass);
      for (std::size_t i = 0; i < u.size(); ++i) {
        EXPECT_NEAR(u[i] / size, large[i], 1e-11 * large.front()) << "what the load is known to";
        EXPECT_NEAR(u[i] / size, other[i], 100 * 1e-10 * large.front()) << "what cvode promises";
      }
    }
  }
}

}  // namespace
}  // namespace viscobar::testing_exponential_load

// Data whose formulas have breaks in x enter a mesh by moments.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <numeric>
#include <string>
#include <utility>
#include <vector>

#include "viscobar/dynamics/bar_system.hpp"
#include "viscobar/dynamics/load_vector.hpp"
#include "viscobar/input/scene_file.hpp"

namespace viscobar::testing_data_in_x {
namespace {

Case scene_with(const std::string& data, Mass mass, int elements) {
  return parse_scene(fmt::format("bar.length = 1.0\nbar.density = 2.0\nbar.viscosity = 0.5\nleft.kind = \"obstacle\"\n"
                                 "left.gap = 10.0\ntime.end = 1.0\nmethod.name = \"rigid\"\nmesh.elements = {}\n"
                                 "mesh.mass = \"{}\"\n{}\n",
                                 elements, name(mass), data),
                     "scene")
      .run;
}

double momentum(const BarSystem& system) {
  std::vector<double> product(system.size());
  system.inertia().matrix().multiply(system.initial_state().v, product);
  return std::accumulate(product.begin(), product.end(), 0.0);
}

// Gauss' formula and the sums over 40 nodes are wrong by roundings alone.
constexpr double rounding = 1e-14;

TEST(DataInX, VelocitiesWithJumpsAndKinksHaveTheirMomentumOnEveryMass) {
  struct {
    const char* formula;
    double integral;
  } const known[] = {{"x > 0.41 && x < 0.44 ? 1 : 0", 0.03},
                     {"x > 0.413 && x < 0.414 ? 1000 : 0", 1.0},
                     {"max(0, 0.2 - abs(x - 0.469))", 0.04},
                     {"x > 0.25 && x < 0.26 ? x^3 : 0", (std::pow(0.26, 4) - std::pow(0.25, 4)) / 4}};
  for (const Mass mass : all_masses)
    for (const auto& [formula, integral] : known)
      for (const int elements : {7, 16, 40}) {
        const Case run = scene_with(fmt::format("initial.velocity = \"{}\"", formula), mass, elements);
        EXPECT_NEAR(momentum(resolve(run).system()), 2.0 * integral, rounding) << name(mass) << formula << elements;
      }
}

TEST(DataInX, LoadsWithBreaksHaveTheirResultantWhateverTheirKind) {
  struct {
    const char* load;
    double resultant;
  } const known[] = {{"load.density = \"x > 0.26 && x < 0.3 ? -5 : 0\"", -0.2},
                     {"load.profile = \"x > 0.26 && x < 0.3 ? -5 : 0\"\nload.history = \"1 + t\"", -0.34},
                     {"load.density = \"x < 0.4*t ? -2 : 0\"", -0.56},
                     {"load.density = \"abs(x - t) < 0.01 ? 50*t : 0\"", 0.7}};
  const double t = 0.7;
  for (const Mass mass : all_masses)
    for (const auto& [load, resultant] : known) {
      const BarSystem system = resolve(scene_with(load, mass, 16)).system();
      LoadVector vector(system);
      const std::span<const double> whole = vector.at(t);
      // The paper's product counts an end twice, where the front is.
      const double end = mass == Mass::paper ? whole[0] / 2.0 : 0.0;
      EXPECT_NEAR(std::accumulate(whole.begin(), whole.end(), 0.0) - end, resultant, 10 * rounding)
          << name(mass) << load;
      for (std::size_t i = 0; i < whole.size(); ++i) EXPECT_NEAR(vector.at(t, i), whole[i], rounding) << load << i;
    }
}

// A twelfth of an element wide: nodes do not see it. Between its places, 0.4 widths apart at most, Gauss' four points
// leave out f^(8) s^9 4!^4 / (9 8!^3), some 1e-9 of it; its flanks have wider pieces.
TEST(DataInX, ASpotThatStandsStillHasItsResultantHoweverItIsWritten) {
  const double t = 0.7, resultant = 0.005 * std::sqrt(std::numbers::pi) * std::exp(-t);
  for (const Mass mass : all_masses)
    for (const char* load : {"load.density = \"exp(-t)*exp(-((x - 0.437)/0.005)^2)\"",
                             "load.density = \"-exp(-((x - 0.437)/0.005)^2)/-exp(t)\"",
                             "load.profile = \"exp(-((x - 0.437)/0.005)^2)\"\nload.history = \"exp(-t)\""}) {
      const BarSystem system = resolve(scene_with(load, mass, 16)).system();
      LoadVector vector(system);
      const std::span<const double> whole = vector.at(t);
      EXPECT_NEAR(std::accumulate(whole.begin(), whole.end(), 0.0), resultant, 1e-8 * resultant) << name(mass) << load;
    }
}

TEST(DataInX, SmoothVelocitiesAreTheirNodalValuesOnThePapersMasses) {
  for (const Mass mass : {Mass::consistent, Mass::lumped, Mass::paper}) {
    const BarSystem system = resolve(scene_with("initial.velocity = \"cos(3*x)\"", mass, 16)).system();
    const State start = system.initial_state();
    for (std::size_t i = 0; i < start.v.size(); ++i)
      EXPECT_EQ(start.v[i], std::cos(3 * system.mesh().node(i))) << name(mass);
  }
}

// On a mesh too coarse for it a wave has no nodal values that mean it; its integral is that of the constant beside it.
TEST(DataInX, WavesShorterThanElementsAreNotAliased) {
  for (const Mass mass : all_masses)
    for (const int elements : {4, 16, 32, 64}) {
      if (mass == Mass::paper) continue;  // its bar is h too heavy, and its momentum is
      const Case run = scene_with("initial.velocity = \"1 + cos(64*pi*x)\"", mass, elements);
      EXPECT_NEAR(momentum(resolve(run).system()), 2.0, 1e-6) << name(mass) << elements;
    }
}

// The flanks of a pulse, below a fiftieth of its height, have half a per cent of its momentum.
TEST(DataInX, ShortPulsesHaveTheMomentumOfTheirFlanks) {
  const double root = std::sqrt(std::numbers::pi);
  for (const Mass mass : all_masses)
    for (const int elements : {4, 16, 100})
      for (const double width : {3e-3, 7e-4, 1e-5}) {
        for (const auto& [formula, integral] :
             {std::pair(fmt::format("exp(-((x - 0.2875)/{})^2)/{}", width, width), root),
              std::pair(fmt::format("1/(1 + ((x - 0.2875)/{})^2)^4/{}", width, width),
                        5.0 * std::numbers::pi / 16.0)}) {
          const Case run = scene_with(fmt::format("initial.velocity = \"{}\"", formula), mass, elements);
          EXPECT_NEAR(momentum(resolve(run).system()), 2.0 * integral, 1e-5) << name(mass) << elements << formula;
        }
      }
}

}  // namespace
}  // namespace viscobar::testing_data_in_x

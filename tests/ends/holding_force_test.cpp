// The force that holds or moves a fixed end: what its own row lacks, of the order of the mass.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "viscobar/case/recording.hpp"
#include "viscobar/input/scene_file.hpp"

namespace viscobar {
namespace {

constexpr double half_pi = std::numbers::pi / 2;
constexpr const char* methods_on_meshes[] = {"cvode", "ida",         "arkode",         "odeint",
                                             "rigid", "exponential", "fully_discrete", "finite_difference"};

std::string numerics(const std::string& method, int elements, const std::string& mass, double end, double step) {
  return fmt::format(
      "[time]\nend = {}\n[mesh]\nelements = {}\nmass = \"{}\"\n[method]\nname = \"{}\"\nrelative_tolerance = 1e-11\nstep "
      "= {}\nstart = \"second_order\"\n[output]\nevery = 0.02\n",
      end, elements, mass, method, step);
}

Recording run(const std::string& text) { return record(parse_scene(text, "").run); }

// The largest error of the left reaction on [0.2, ...], where the mesh's start is over.
double error(const Recording& of, const auto& exact) {
  double most = 0.0;
  for (std::size_t k = 0; k < of.times.size(); ++k)
    if (of.times[k] > 0.195) most = std::max(most, std::abs(of.reaction_left[k] - exact(k, of.times[k])));
  return most;
}

// The whole weight, on every mesh and mass that weighs the bar right: K u = M f at the nodes, to rounding.
TEST(HoldingForce, OfAHangingBarIsItsWeight) {
  for (const char* method : methods_on_meshes)
    for (const int elements : {1, 2, 10, 100}) {
      SCOPED_TRACE(fmt::format("{} {}", method, elements));
      const char* const mass = elements > 2 && std::string(method) != "finite_difference" ? "fourth_order" : "lumped";
      const std::string head = "[bar]\nlength = 1.0\nviscosity = 0.1\n", load = "[load]\ndensity = -9.8\n";
      const std::string how = numerics(method, elements, mass, 0.2, 0.01);
      const auto held = [&](const char* left, const char* right, const char* u) {
        return run(head + "[left]\nkind = \"" + left + "\"\n[right]\nkind = \"" + right +
                   "\"\n[initial]\ndisplacement = \"" + u + "\"\n" + load + how);
      };
      const auto expect = [](const std::vector<double>& reaction, double exact) {
        for (const double r : reaction) EXPECT_NEAR(r, exact, 1e-10);
      };
      const Recording left = held("fixed", "free", "9.8*(x^2/2-x)");
      expect(left.reaction_left, 9.8);
      expect(left.reaction_right, 0.0);
      expect(held("free", "fixed", "4.9*(x^2-1)").reaction_right, 9.8);
      if (elements == 1) continue;
      const Recording both = held("fixed", "fixed", "4.9*(x^2-x)");
      expect(both.reaction_left, 4.9);
      expect(both.reaction_right, 4.9);
    }
}

// u = sin(pi x / 2) cos(pi t / 2), R_left = -u_x(0, t); on one mesh the same by all, and mirrored at the right end.
TEST(HoldingForce, OfAStandingWaveIsOfTheOrderOfTheMass) {
  const auto exact = [](std::size_t, double t) { return -half_pi * std::cos(half_pi * t); };
  const auto of = [&](const std::string& method, int elements, double step) {
    return error(run("[bar]\nlength = 1.0\n[left]\nkind = \"fixed\"\n[initial]\ndisplacement = \"sin(pi*x/2)\"\n" +
                     numerics(method, elements, "fourth_order", 2.0, step)),
                 exact);
  };
  // Measured on the matrices themselves, by exponentials: 2.1e-5, 1.3e-6, 8.5e-8 on 10, 20, 40 elements; where the high
  // modes of the start are at rest, 8.2e-8 on 40.
  for (const char* method : {"cvode", "ida", "arkode", "odeint", "rigid", "exponential"}) {
    EXPECT_NEAR(of(method, 10, 1e-3), 2.1e-5, 0.05e-5) << method;
    EXPECT_NEAR(of(method, 40, 1e-3), 8.2e-8, 0.1e-8) << method;
  }
  // The scheme's own error is one of dt^2: u is late by (omega dt)^2 5/24 omega t, its R by as much of pi/2.
  const double dt = 1e-4, late = 5.0 / 24.0 * std::pow(half_pi * dt, 2) * 2.0 * half_pi * half_pi;
  EXPECT_NEAR(of("fully_discrete", 20, dt), 1.3e-6, 0.05e-6 + late);
}

// With viscosity no closed form is known; that of 160 elements is one, to 1e-9.
TEST(HoldingForce, OfAMovedEndIsOfTheOrderOfTheMass) {
  const auto scene = [](const std::string& method, int elements) {
    return run("[bar]\nlength = 1.0\nviscosity = 0.1\n[left]\nkind = \"fixed\"\nmotion = \"t^2/2\"\n" +
               numerics(method, elements, "fourth_order", 1.9, 1e-3));
  };
  const Recording fine = scene("rigid", 160);
  const auto exact = [&](std::size_t k, double) { return fine.reaction_left[k]; };
  // By exponentials of the matrices: 1.3e-4, 8.3e-6, 6.7e-7 on 10, 20, 40 elements.
  for (const char* method : {"cvode", "ida", "arkode", "rigid", "exponential"}) {
    EXPECT_NEAR(error(scene(method, 20), exact), 8.3e-6, 0.1e-6) << method;
    EXPECT_NEAR(error(scene(method, 40), exact), 6.7e-7, 0.1e-7) << method;
  }
}

// An elastic bar whose end moves as t^2/2 is held by R = t until the echo comes: its work is t^3/3.
TEST(HoldingForce, OfAnElasticBarIsThatOfTheWaveAndDoesItsWork) {
  for (const char* method : {"cvode", "rigid", "exponential"}) {
    const Recording done = run("[bar]\nlength = 1.0\n[left]\nkind = \"fixed\"\nmotion = \"t^2/2\"\n" +
                               numerics(method, 40, "fourth_order", 1.9, 1e-3));
    // 1.5e-4 by exponentials of the matrices; 7.4e-5 with the high modes at rest, where the acceleration begins.
    EXPECT_NEAR(error(done, [](std::size_t, double t) { return t; }), 7.4e-5, 0.1e-5) << method;
  }
}

// Central differences of whole runs, whose own errors are those of the tolerance over the difference.
TEST(HoldingForce, HasTheDerivativesOfItsDifferences) {
  const std::string keys[] = {"bar.density", "bar.modulus", "bar.viscosity", "bar.length", "parameters.p"};
  const auto scene = [&](const char* method, const std::string& key, double change) {
    const auto of = [&](const char* name, double value) { return value + (key == name ? change : 0.0); };
    return fmt::format(
        "[parameters]\np = {}\n[bar]\nlength = {}\ndensity = {}\nmodulus = {}\nviscosity = {}\n[left]\nkind = "
        "\"fixed\"\nmotion = \"p*t^2\"\n[right]\nkind = \"fixed\"\n[initial]\ndisplacement = "
        "\"0.1*p*x*(1.3-x)\"\n[load]\ndensity = \"p*cos(2*x)*sin(3*t)\"\n[sensitivity]\nof = "
        "[\"bar.density\", \"bar.modulus\", \"bar.viscosity\", \"bar.length\", \"parameters.p\"]\n{}",
        of("parameters.p", 0.7), of("bar.length", 1.3), of("bar.density", 2.0), of("bar.modulus", 3.0),
        of("bar.viscosity", 0.4), numerics(method, 8, "fourth_order", 1.0, 1e-3));
  };
  for (const char* method : {"cvode", "ida", "rigid"}) {
    const Recording here = run(scene(method, "", 0.0));
    for (std::size_t i = 0; i < std::size(keys); ++i) {
      const double d = 1e-4;
      const Recording less = run(scene(method, keys[i], -d)), more = run(scene(method, keys[i], d));
      for (std::size_t k = 0; k < here.times.size(); ++k) {
        const auto& slopes = here.sensitivities[i];
        const double left = (more.reaction_left[k] - less.reaction_left[k]) / (2 * d);
        const double right = (more.reaction_right[k] - less.reaction_right[k]) / (2 * d);
        EXPECT_NEAR(slopes.reaction_left[k], left, 2e-5) << method << " " << keys[i] << " " << here.times[k];
        EXPECT_NEAR(slopes.reaction_right[k], right, 2e-5) << method << " " << keys[i] << " " << here.times[k];
      }
    }
  }
}

}  // namespace
}  // namespace viscobar

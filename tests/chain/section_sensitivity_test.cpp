// Derivatives by numbers of sections, and by lengths of bars under a load, against differences of runs.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "viscobar/case/recording.hpp"
#include "viscobar/input/scene_file.hpp"

namespace viscobar::section_derivatives {
namespace {

// d/dp by differences over 4e-4 of p, of fourth order: wrong by some 1e-13 of it and 1e-11 / 1e-4 of the runs. The
// derivative is of runs of 1e-9, and its own matrices are good to 1e-10.
void expect_derivative(const std::string& text, const std::string& key, double value, const std::string& method) {
  const Case start = parse_scene(text, "", std::vector<std::string>{"method.name=" + method}).run;
  const auto at = [&](double now, bool derivative) {
    std::vector<std::string> settings = {"method.name=" + method, fmt::format("{}={:.17g}", key, now)};
    if (method == "rigid") settings.push_back("contact.restitution=0");  // where it would bounce without end
    if (derivative) settings.push_back(fmt::format("sensitivity.of=[\"{}\"]", key));
    settings.push_back(derivative ? "method.relative_tolerance=1e-10" : "method.relative_tolerance=1e-11");
    Case run = parse_scene(text, "", settings).run;
    run.elements = start.elements, run.bar_meshes = start.bar_meshes;
    return record(run);
  };
  const double d = 1e-4 * value;
  const Recording own = at(value, true), low = at(value - d, false), high = at(value + d, false),
                  lower = at(value - 2.0 * d, false), higher = at(value + 2.0 * d, false);
  ASSERT_EQ(low.events.size(), own.events.size()) << method << key;
  ASSERT_EQ(high.events.size(), own.events.size()) << method << key;
  double largest = 0.0, off = 0.0;
  for (std::size_t i = 0; i < own.u.size(); ++i) {
    const double truth = (8.0 * (high.u[i] - low.u[i]) - (higher.u[i] - lower.u[i])) / (12.0 * d);
    largest = std::max(largest, std::abs(truth));
    off = std::max(off, std::abs(own.sensitivities.at(0).u[i] - truth));
  }
  EXPECT_GT(largest, 1e-3) << method << ' ' << key;
  EXPECT_LT(off, 1e-5 * largest) << method << ' ' << key << ' ' << largest;
  const SensitivityAccount& account = *own.statistics.sensitivity;
  const auto impulse = [](const Recording& of) { return of.statistics.account->left.impulse; };
  const double of_impulse = (impulse(high) - impulse(low)) / (2.0 * d),
               of_energy = (high.statistics.energy->final - low.statistics.energy->final) / (2.0 * d);
  EXPECT_NEAR(account.impulse_left[0], of_impulse, 1e-4 * (1.0 + std::abs(of_impulse))) << method << ' ' << key;
  EXPECT_NEAR(account.energy[0], of_energy, 1e-4 * (1.0 + std::abs(of_energy))) << method << ' ' << key;
  for (std::size_t k = 0; k < own.events.size(); ++k) {
    const double of_time = (high.events[k].time - low.events[k].time) / (2.0 * d);
    EXPECT_NEAR(own.events[k].sensitivities.at(0).time, of_time, 1e-4 * (1.0 + std::abs(of_time)))
        << method << ' ' << key << k;
  }
}

const std::string rest =
    "[time]\nend = 2.0\n[output]\nevery = 0.1\n[contact]\nepsilon = 1e-2\nrestitution = 0.3\n[parameters]\nb = 0.8\nc = 0.5\n";

// k'' is not 0, so that a number of the side that stays behind at its node shows.
const std::string side = "[side]\nstiffness = \"2+x^2\"\ndrag = \"0.3+0.2*sin(x)\"\n";

TEST(SectionSensitivities, OfOneBarAreDifferencesOfRuns) {
  const std::string horn =
      "[bar]\nlength = 1.0\nviscosity = 0.1\nsection = \"exp(b*x)\"\n[left]\nkind = \"obstacle\"\ngap = 0.1\nmass = 0.1\n[initial]\n"
      "velocity = \"-1-0.3*x\"\n[load]\nprofile = \"-0.5-x\"\nhistory = \"cos(3*t)\"\n[mesh]\nelements = 10\n" +
      rest;
  for (const std::string& scene : {horn, horn + side})
    for (const char* method : {"rigid", "cvode", "ida", "arkode"}) {
      expect_derivative(scene, "parameters.b", 0.8, method);
      expect_derivative(scene, "bar.length", 1.0, method);
      expect_derivative(scene, "bar.modulus", 1.0, method);
    }
}

TEST(SectionSensitivities, OfBarsInLineAreDifferencesOfRuns) {
  const std::string chain =
      "[[bar]]\nlength = 1.0\nviscosity = 0.1\nsection = 1.5\nelements = 8\nvelocity = -1.0\n[[bar]]\nlength = 0.7\nmodulus = 3.0\n"
      "viscosity = 0.2\nsection = \"1+c*x\"\nelements = 6\nvelocity = \"-1+0.3*x\"\n[[bar]]\nlength = 0.5\nviscosity = 0.1\nelements = 5\n"
      "velocity = -1.5\n[[joint]]\nkind = \"bonded\"\n[[joint]]\nkind = \"contact\"\ngap = 0.05\n[left]\nkind = \"obstacle\"\ngap = "
      "0.1\n[load]\ndensity = \"-0.3*sin(2*t)*(1+x)\"\n[mesh]\nmass = \"fourth_order\"\n" +
      rest;
  for (const std::string& scene : {chain, chain + side})
    for (const char* method : {"rigid", "cvode"}) {
      expect_derivative(scene, "parameters.c", 0.5, method);
      expect_derivative(scene, "bar.1.section", 1.5, method);
      expect_derivative(scene, "bar.1.length", 1.0, method);
      expect_derivative(scene, "bar.2.length", 0.7, method);
      expect_derivative(scene, "bar.3.density", 1.0, method);
    }
}

// At a held end the velocities of the start are by its own.
TEST(SectionSensitivities, OfBarsWhoseEndIsDrivenFromTheStartOnAreDifferencesOfRuns) {
  const std::string driven =
      "[[bar]]\nlength = 1.0\nviscosity = 0.1\nsection = \"1.5+c*x\"\nelements = 4\nvelocity = \"-1+b*x\"\n[[bar]]\n"
      "length = 0.7\nmodulus = 3.0\nviscosity = 0.2\nelements = 3\nvelocity = -0.4\n[left]\nkind = \"obstacle\"\ngap = "
      "0.1\n[right]\nkind = \"fixed\"\nmotion = \"0.2*sin(2*t)\"\n[load]\ndensity = \"-0.3*sin(2*t)*(1+x)\"\n" +
      rest;
  for (const char* mass : {"fourth_order", "consistent", "lumped"})
    for (const std::string& scene : {driven, driven + side}) {
      const std::string text = scene + fmt::format("[mesh]\nmass = \"{}\"\n", mass);
      for (const char* method : {"rigid", "cvode"}) {
        expect_derivative(text, "parameters.c", 0.5, method);
        expect_derivative(text, "bar.1.length", 1.0, method);
        expect_derivative(text, "bar.2.length", 0.7, method);
      }
    }
}

}  // namespace
}  // namespace viscobar::section_derivatives

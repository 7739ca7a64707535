#include <fmt/format.h>

#include <cmath>
#include <cstdlib>

#include "hard/catalogue.hpp"

namespace viscobar::hard {

namespace {

using Scenes = std::vector<HardScene>;

const std::vector<Mass> every_mass = {Mass::consistent, Mass::lumped, Mass::paper, Mass::redistributed};
const std::vector<Mass> two_masses = {Mass::consistent, Mass::redistributed};
const std::vector<MethodName> schemes = {MethodName::fully_discrete, MethodName::finite_difference};

// Massive contact nodes bounce some 2 / sqrt(epsilon) times in a unit of contact: hundreds of them are run.
void penalties(Scenes& scenes) {
  for (const char* epsilon : {"1", "1e-2", "1e-4", "1e-6", "1e-8", "1e-10", "1e-12", "1e-14"}) {
    const double end = std::min(2.0, 0.1 + 5000 * std::sqrt(std::atof(epsilon)));
    const std::string penalty = fmt::format("contact.epsilon={}", epsilon);
    scenes.push_back({fmt::format("epsilon {}, massive nodes", epsilon),
                      "fall",
                      {penalty, fmt::format("time.end={}", end)},
                      {Mass::consistent, Mass::lumped},
                      {first_contact(0.1), agreement(Sensitivity::measured)}});
    scenes.push_back({fmt::format("epsilon {}, massless nodes", epsilon),
                      "fall",
                      {penalty, "time.end=4"},
                      {Mass::redistributed},
                      {first_contact(0.1), agreement()}});
  }
}

void materials(Scenes& scenes) {
  for (const char* viscosity : {"0", "1e-12", "1e-3", "1", "1e3"})
    scenes.push_back({fmt::format("viscosity {}", viscosity),
                      "fall",
                      {fmt::format("bar.viscosity={}", viscosity), "contact.epsilon=1e-4"},
                      every_mass,
                      {first_contact(0.1), agreement()}});
  for (const char* restitution : {"0", "0.5", "1"})
    scenes.push_back({fmt::format("restitution {}", restitution),
                      "fall",
                      {fmt::format("contact.restitution={}", restitution)},
                      two_masses,
                      {first_contact(0.1), agreement()}});
  scenes.push_back({"density 1e6", "heavy", {}, two_masses, {first_contact(0.1), agreement()}});
  scenes.push_back({"density 1e-6", "light", {}, two_masses, {first_contact(1e-4), agreement()}});
}

void meshes(Scenes& scenes) {
  for (const char* elements : {"1", "2", "3"})
    scenes.push_back({fmt::format("elements {}", elements),
                      "fall",
                      {fmt::format("mesh.elements={}", elements)},
                      every_mass,
                      {first_contact(0.1), agreement()}});
  scenes.push_back({"elements 1000",
                    "fall",
                    {"mesh.elements=1000", "bar.viscosity=1e-3", "time.end=0.3", "method.step=1e-4"},
                    two_masses,
                    {first_contact(0.1), agreement()}});
  // To a hundred transits of an element after the contact.
  const auto undamped_impact = [](const char* name, const char* elements, std::vector<std::string> overrides,
                                  bool slow) {
    HardScene scene{name,
                    "fall",
                    {fmt::format("mesh.elements={}", elements), "bar.viscosity=0"},
                    {Mass::lumped},
                    {first_contact(0.1), impact_law()}};
    scene.overrides.insert(scene.overrides.end(), overrides.begin(), overrides.end());
    scene.slow = slow;
    return scene;
  };
  scenes.push_back(undamped_impact("elements 1e4", "10000",
                                   {"contact.epsilon=2e-3", "time.end=0.11", "output.every=0.001", "method.step=1e-4"},
                                   false));
  scenes.push_back(undamped_impact("elements 1e5", "100000",
                                   {"contact.epsilon=1e-4", "time.end=0.1003", "output.every=1e-4", "method.step=1e-5"},
                                   true));
  scenes.push_back({"grading 1e6", "fall", {"mesh.grading=1e6"}, two_masses, {first_contact(0.1), agreement()}});
}

void gaps(Scenes& scenes) {
  scenes.push_back({"gap 0", "fall", {"left.gap=0"}, two_masses, {first_contact(0.0), agreement()}});
  scenes.push_back({"gap 1e-15", "fall", {"left.gap=1e-15"}, two_masses, {first_contact(1e-15), agreement()}});
  // Relative to the largest displacement: 1e-13 is 1e-7 in units of the contact, less than the dense solves of odeint's
  // rosenbrock4 add up to in such a flight.
  scenes.push_back({"gap 1e6",
                    "fall",
                    {"left.gap=1e6", "time.end=1000002", "output.every=10000", "method.step=0.5",
                     "method.relative_tolerance=1e-13", "method.absolute_tolerance=1e-9"},
                    two_masses,
                    {first_contact(1e6), agreement()},
                    {},
                    {MethodName::cvode, MethodName::ida, MethodName::arkode, MethodName::rigid, MethodName::exponential,
                     MethodName::fully_discrete, MethodName::finite_difference}});
}

// A motion that is L times as large, obstacle included, is the same motion: to the last bit, L being a power of two.
Case smaller(Case run, double factor) {
  run.scene.left = Obstacle{std::get<Obstacle>(run.scene.left).gap / factor};
  run.scene.velocity = [v = run.scene.velocity, factor](double x) { return v(x) / factor; };
  if (run.tolerance.absolute) *run.tolerance.absolute /= factor;
  return run;
}

HardScene amplitude(const char* name, double factor) {
  return {name,
          "fall",
          {fmt::format("left.gap={:.17g}", 0.1 * factor), fmt::format("initial.velocity={:.17g}", -factor),
           fmt::format("method.absolute_tolerance={:.17g}", 1e-11 * factor)},
          two_masses,
          {first_contact(0.1), scaled([factor](Case run) { return smaller(std::move(run), factor); }, factor, 0.0)}};
}

// Lengths in units 2^-20 as large, times in units 2^30 as large, masses 2^40: what remains to be compared is the
// motion.
HardScene units() {
  const double l = std::exp2(20), t = std::exp2(-30), density = std::exp2(40), stress = density * l * l / (t * t);
  const auto original = [=](Case run) {
    Bar& bar = run.scene.bar;
    bar = {bar.length / l, bar.density / density, bar.modulus / stress, bar.viscosity / (stress * t)};
    run.scene.left = Obstacle{0.1};
    run.scene.velocity = [](double) { return -1.0; };
    *run.epsilon *= stress / l;
    *run.step /= t;
    run.end /= t;
    run.output_every /= t;
    if (run.tolerance.absolute) *run.tolerance.absolute /= l;
    return run;
  };
  const auto set = [](const char* key, double value) { return fmt::format("{}={:.17g}", key, value); };
  return {"units",
          "fall",
          {set("bar.length", l), set("bar.density", density), set("bar.modulus", stress),
           set("bar.viscosity", 0.1 * stress * t), set("left.gap", 0.1 * l), set("initial.velocity", -l / t),
           set("contact.epsilon", 1e-3 * l / stress), set("method.step", 1e-3 * t), set("time.end", 2 * t),
           set("output.every", 0.02 * t), set("method.absolute_tolerance", 1e-11 * l)},
          two_masses,
          // One absolute tolerance serves displacement and velocity, and has the units of the former: the runs differ.
          {first_contact(0.1 * t), scaled(original, l, 200 * 1e-8)}};
}

void steps(Scenes& scenes) {
  for (int decade = -3; decade <= 3; ++decade) {
    const double step = 0.125 * std::pow(10.0, decade);
    HardScene scene{
        fmt::format("dt/h 1e{}", decade),
        "fall",
        {fmt::format("method.step={:.17g}", step), fmt::format("time.end={:.17g}", std::max(2.0, 20 * step)),
         fmt::format("output.every={:.17g}", std::max(0.02, step))},
        every_mass,
        {},
        {},
        schemes};
    if (decade < 0) scene.oracles.push_back(agreement());
    scenes.push_back(scene);
  }
}

void tolerances(Scenes& scenes) {
  scenes.push_back({"relative tolerance 1e-14",
                    "fall",
                    {"method.relative_tolerance=1e-14", "method.absolute_tolerance=1e-15"},
                    two_masses,
                    {first_contact(0.1), agreement()}});
  scenes.push_back({"relative tolerance 0.1",
                    "fall",
                    {"method.relative_tolerance=0.1"},
                    two_masses,
                    {first_contact(0.1), agreement()}});
}

}  // namespace

std::vector<HardScene> parameter_scenes() {
  Scenes scenes;
  penalties(scenes);
  materials(scenes);
  meshes(scenes);
  gaps(scenes);
  scenes.push_back(amplitude("displacement 1e12", std::exp2(40)));
  scenes.push_back(amplitude("displacement 1e-12", std::exp2(-40)));
  scenes.push_back(units());
  steps(scenes);
  tolerances(scenes);
  return scenes;
}

}  // namespace viscobar::hard

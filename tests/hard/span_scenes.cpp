#include <fmt/format.h>

#include <cmath>

#include "hard/catalogue.hpp"

namespace viscobar::hard {

namespace {

using Scenes = std::vector<HardScene>;

const std::vector<Mass> full_masses = {Mass::consistent, Mass::lumped};

void distributed(Scenes& scenes) {
  struct Shape {
    const char* name;
    std::vector<std::string> overrides;
  };
  const Shape shapes[] = {{"part of the nodes", {}},
                          {"all nodes", {"initial.velocity=-1"}},
                          {"alternating nodes", {"initial.displacement=0.02*cos(16*pi*x)", "initial.velocity=-1"}}};
  for (const Shape& shape : shapes)
    for (const char* epsilon : {"1e-3", "1e-6"}) {
      HardScene scene{fmt::format("span, {}, epsilon {}", shape.name, epsilon),
                      "span",
                      shape.overrides,
                      full_masses,
                      {agreement(Sensitivity::measured)}};
      scene.overrides.push_back(fmt::format("contact.epsilon={}", epsilon));
      scenes.push_back(scene);
    }
  scenes.push_back(
      {"span and both ends", "both-ends", {"span.gap=0.05"}, full_masses, {agreement(Sensitivity::measured)}});
}

void long_runs(Scenes& scenes) {
  // d = epsilon (1 - cos(t / sqrt(epsilon))): its zeros are double ones.
  const auto swing = [](double, double t) { return -1e-4 * (1 - std::cos(100 * t)); };
  scenes.push_back(
      {"span, grazing from inside",
       "span-rest",
       {},
       full_masses,
       {exact(swing)},
       {},
       {MethodName::cvode, MethodName::ida, MethodName::arkode, MethodName::odeint, MethodName::exponential}});
  const std::vector<MethodName> penalised = {MethodName::cvode, MethodName::ida, MethodName::arkode, MethodName::odeint,
                                             MethodName::exponential};
  const std::vector<MethodName> schemes = {MethodName::fully_discrete, MethodName::finite_difference};
  scenes.push_back(
      {"100 bounces", "bounce", {}, {Mass::lumped}, {bouncing(0.5, 1e-4), energy_held(0.5)}, {}, penalised});
  // The speed of 1 a step too deep, twice g of the weight: v g dt.
  scenes.push_back({"100 bounces, schemes", "bounce", {}, {Mass::lumped}, {energy_held(0.5, 1.0)}, {}, schemes});
  scenes.push_back({"10000 bounces",
                    "bounce",
                    {"time.end=20330", "output.every=10"},
                    {Mass::lumped},
                    {bouncing(0.5, 1e-4), energy_held(0.5)},
                    {},
                    penalised,
                    true});
  scenes.push_back({"10000 bounces, schemes",
                    "bounce",
                    {"time.end=20000", "output.every=10"},
                    {Mass::lumped},
                    {energy_held(0.5, 1.0)},
                    {},
                    schemes,
                    true});
  scenes.push_back({"period three, 20 periods",
                    "period-3",
                    {},
                    {Mass::redistributed},
                    {energy_held(0.125, 1.0)},
                    {},
                    {MethodName::ida, MethodName::arkode, MethodName::rigid, MethodName::exponential}});
}

}  // namespace

std::vector<HardScene> span_scenes() {
  Scenes scenes;
  distributed(scenes);
  long_runs(scenes);
  return scenes;
}

}  // namespace viscobar::hard

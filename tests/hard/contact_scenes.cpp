#include <fmt/format.h>

#include <cmath>

#include "hard/catalogue.hpp"

namespace viscobar::hard {

namespace {

using Scenes = std::vector<HardScene>;

const std::vector<Mass> two_masses = {Mass::consistent, Mass::redistributed};
// Those that a steady load accelerates as one point.
const std::vector<Mass> full_masses = {Mass::consistent, Mass::lumped};
const std::vector<MethodName> penalised = {MethodName::cvode, MethodName::ida, MethodName::arkode, MethodName::odeint,
                                           MethodName::exponential};
const std::vector<MethodName> all_but_rigid = {MethodName::cvode,
                                               MethodName::ida,
                                               MethodName::arkode,
                                               MethodName::odeint,
                                               MethodName::exponential,
                                               MethodName::fully_discrete,
                                               MethodName::finite_difference};

void both_ends(Scenes& scenes) {
  for (const char* epsilon : {"1e-2", "1e-4", "1e-6"})
    scenes.push_back({fmt::format("both ends at once, epsilon {}", epsilon),
                      "both-ends",
                      {fmt::format("contact.epsilon={}", epsilon)},
                      two_masses,
                      {mirrored(), agreement(Sensitivity::measured)}});
  scenes.push_back({"both ends at once, thrown flat",
                    "flat-throw",
                    {},
                    two_masses,
                    {mirrored(), first_contact(0.1), agreement(Sensitivity::measured)}});
}

// u = -t + t^2/2 with the obstacle where it turns round, and a little above and below.
void grazing(Scenes& scenes) {
  const auto flight = [](double, double t) { return -t + t * t / 2; };
  const std::vector<std::string> tight = {"method.relative_tolerance=1e-13", "method.absolute_tolerance=1e-15"};
  scenes.push_back({"graze, exactly", "graze", {}, full_masses, {exact(flight, 1.0)}, {}, all_but_rigid});
  scenes.push_back({"graze, missed by 1e-9",
                    "graze",
                    {"left.gap=0.500000001", tight[0], tight[1]},
                    full_masses,
                    {exact(flight, 1.0)},
                    {},
                    all_but_rigid});
  // Two crossings within any step that the tolerance asks for: the contact lasts 2 sqrt(2 depth), and its spring gives
  // the velocity at most depth / epsilon times that, which is spread over the bar.
  for (const double depth : {1e-9, 1e-7}) {
    const double half = std::sqrt(2 * depth), gap = 0.5 - depth;
    scenes.push_back({fmt::format("two crossings in a step, depth {}", depth),
                      "graze",
                      {fmt::format("left.gap={:.17g}", gap), "contact.epsilon=1", tight[0], tight[1]},
                      full_masses,
                      {changes({{1 - half, half, 1.0}, {1 + half, half, 1.0}}), agreement()},
                      {},
                      penalised});
  }
  scenes.push_back({"graze, 1e-4 deep", "graze", {"left.gap=0.4999"}, two_masses, {agreement()}});
}

void starts(Scenes& scenes) {
  const auto still = [](double, double) { return 0.0; };
  scenes.push_back({"start on the obstacle, at rest", "on-obstacle", {}, two_masses, {exact(still), untouched()}});
  scenes.push_back({"start on the obstacle, moving in",
                    "on-obstacle",
                    {"initial.velocity=-1"},
                    two_masses,
                    {first_contact(0.0), agreement()}});
  scenes.push_back({"start on the obstacle, moving out",
                    "on-obstacle",
                    {"initial.velocity=1"},
                    two_masses,
                    {exact([](double, double t) { return t; }), untouched()}});
  scenes.push_back({"start on the obstacle, pulled away",
                    "on-obstacle",
                    {"load.density=1"},
                    full_masses,
                    {exact([](double, double t) { return t * t / 2; }, 1.0), untouched()},
                    {},
                    all_but_rigid});
  scenes.push_back({"start on the obstacle, pressed by strain",
                    "on-obstacle",
                    {"initial.displacement=-0.1*x"},
                    two_masses,
                    {agreement()}});
  scenes.push_back({"start on the obstacle, released by strain",
                    "on-obstacle",
                    {"initial.displacement=0.1*x"},
                    two_masses,
                    {agreement()}});
}

// Equilibrium under f = -1: the reaction is 1, and P1 elements are exact at the nodes.
void resting(Scenes& scenes) {
  const auto hanging = [](double epsilon) { return [=](double x) { return -epsilon - x + x * x / 2; }; };
  // The slowest mode, kappa = pi/2, decays like exp(-0.3 kappa^2 t / 2): by 1e-16 at t = 100. The exact obstacle does
  // without the epsilon.
  scenes.push_back({"rest for ever", "rest", {}, two_masses, {settled(hanging(1e-4), 1.01e-4), agreement()}});
  scenes.push_back(
      {"rest for ever, epsilon 1e-10", "rest", {"contact.epsilon=1e-10"}, two_masses, {settled(hanging(1e-10), 1e-9)}});
  scenes.push_back({"rest for ever, from equilibrium",
                    "rest",
                    {"initial.displacement=-x+x*x/2", "contact.epsilon=1e-8"},
                    two_masses,
                    {settled(hanging(1e-8), 1e-7)}});
}

void at_a_time(Scenes& scenes) {
  scenes.push_back(
      {"contact at the end time", "fall", {"left.gap=2"}, two_masses, {exact([](double, double t) { return -t; })}});
  scenes.push_back({"contact just after the end time",
                    "fall",
                    {"left.gap=2.00000001"},
                    two_masses,
                    {exact([](double, double t) { return -t; }), untouched()}});
  scenes.push_back({"contact at an output time",
                    "fall",
                    {"left.gap=0.5", "output.every=0.125"},
                    two_masses,
                    {first_contact(0.5), agreement()}});
  scenes.push_back({"an output at every rounding",
                    "fall",
                    {"time.end=0.2", "output.every=1e-5"},
                    two_masses,
                    {first_contact(0.1), agreement()}});
}

void chatter(Scenes& scenes) {
  scenes.push_back({"chatter", "chatter", {}, {Mass::consistent}, {mirrored(), agreement(Sensitivity::measured)}});
  scenes.push_back({"chatter, no viscosity",
                    "chatter",
                    {"bar.viscosity=0", "time.end=1.6"},
                    {Mass::consistent},
                    {mirrored(), agreement(Sensitivity::measured)}});
  scenes.push_back({"chatter, restitution 0.5",
                    "chatter",
                    {"contact.restitution=0.5"},
                    {Mass::consistent},
                    {mirrored(), agreement(Sensitivity::measured)}});
  scenes.push_back({"chatter under a load",
                    "chatter",
                    {"bar.viscosity=0", "load.density=-1", "mesh.elements=8", "contact.epsilon=1e-4", "time.end=4"},
                    {Mass::consistent, Mass::lumped},
                    {mirrored(), agreement(Sensitivity::measured)}});
}

}  // namespace

std::vector<HardScene> contact_scenes() {
  Scenes scenes;
  both_ends(scenes);
  grazing(scenes);
  starts(scenes);
  resting(scenes);
  at_a_time(scenes);
  chatter(scenes);
  return scenes;
}

}  // namespace viscobar::hard

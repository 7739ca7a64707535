#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <string>
#include <vector>

#include "viscobar/case/end_traces.hpp"
#include "viscobar/studies/limit/limit.hpp"

namespace viscobar {

/// A scene whose verdict is known by theory.
struct VerdictScene {
  std::string name, load;
  Case run;
  bool pressed = false;  ///< lies on its obstacle under a load from the start, and stays
};

/// The verdict that theory has, docs/penalty-limit.md: massless contact nodes and one law of impact converge; nodes
/// with mass rebound from an undamped penalty and not in the scheme; a span on a mass that couples neighbours has no
/// common law. A bar that is pressed on its obstacle converges on any of them. Where nothing touches there is none.
inline Verdict verdict_by_theory(const Case& run, bool touches, bool pressed) {
  if (!touches) return Verdict::undecided;
  if (run.mass == Mass::redistributed || pressed) return Verdict::converges;
  const bool apart = !run.scene.span || run.mass == Mass::lumped || run.mass == Mass::paper;
  return run.restitution && apart ? Verdict::converges : Verdict::plateau;
}

/// Scenes drawn from a seeded generator whose numbers are the same on every machine.
inline std::vector<VerdictScene> random_verdict_scenes(std::size_t count, unsigned seed = 1523) {
  std::mt19937 generator(seed);
  const auto uniform = [&](double low, double high) {
    return low + (high - low) * static_cast<double>(generator()) / 4294967296.0;
  };
  const auto one_of = [&](std::size_t n) { return static_cast<std::size_t>(uniform(0.0, static_cast<double>(n))); };
  std::vector<VerdictScene> scenes;
  for (std::size_t k = 0; k < count; ++k) {
    VerdictScene scene;
    Case& run = scene.run;
    scene.name = fmt::format("random {}", k + 1);
    Bar& bar = run.scene.bar;
    bar.length = uniform(0.5, 2.0);
    bar.density = uniform(0.5, 2.0);
    bar.modulus = uniform(0.5, 2.0);
    bar.viscosity = one_of(6) == 0 ? 0.0 : std::pow(10.0, uniform(-3.0, 0.0));
    run.elements = 8 + one_of(25);
    run.scene.left = Obstacle{uniform(0.02, 0.2)};
    const std::size_t right = one_of(3);
    if (right == 0) run.scene.right = Obstacle{uniform(0.02, 0.2)};
    if (right == 1) run.scene.right = Fixed{};
    // As many with massless nodes, with one restitution and with the paper's pair.
    const std::size_t law = k % 3;
    if (law == 0)
      run.mass = Mass::redistributed;
    else
      run.mass = std::vector{Mass::consistent, Mass::lumped, Mass::paper}[one_of(3)];
    if (law == 1) run.restitution = std::vector{0.0, 0.0, 0.5, 1.0}[one_of(4)];
    const double speed = uniform(0.2, 1.0), tilt = uniform(-0.5, 0.5) / bar.length, bend = uniform(0.0, 0.3);
    const bool held = right == 1;
    const double length = bar.length;
    run.scene.displacement = [=](double x) { return bend * x * (length - x); };
    run.scene.velocity = [=](double x) { return -speed * (held ? 1.0 - x / length : 1.0 + tilt * x); };
    const double force = uniform(-0.5, 0.2), frequency = uniform(1.0, 6.0);
    const std::size_t load = one_of(3);
    if (load == 1) run.scene.load = SteadyLoad{[=](double) { return force; }};
    if (load == 2)
      run.scene.load = SeparableLoad{[=](double x) { return force * (1.0 - x / length); },
                                     [=](double t) { return std::sin(frequency * t); }};
    scene.load = load == 0 ? "none" : load == 1 ? "steady" : "sin";
    if (k % 15 == 14) {
      scene.pressed = true;
      scene.load = "steady, on the obstacle";
      run.restitution.reset();
      bar.viscosity = std::max(bar.viscosity, 0.05);  // so that the reaction does not swing back to zero
      run.scene.left = Obstacle{0.0};
      run.scene.right = Free{};
      run.scene.displacement = run.scene.velocity = [](double) { return 0.0; };
      run.scene.load = SteadyLoad{[](double) { return -0.5; }};
    }
    run.end = run.output_every = uniform(1.5, 3.0) * length * bar.slowness();
    run.epsilon = 1e-4;
    run.step = std::pow(10.0, uniform(-4.0, -1.5));
    scenes.push_back(std::move(scene));
  }
  return scenes;
}

inline LimitStudy verdict_study(const VerdictScene& scene) {
  LimitStudy study;
  study.scene = scene.run;
  const double unit = natural_epsilon(scene.run.scene);
  study.epsilons = decades(1e-2 * unit, 1e-8 * unit);
  return study;
}

}  // namespace viscobar

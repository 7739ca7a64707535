#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <random>
#include <utility>

#include "schemes/step_energy.hpp"

namespace viscobar::testing_energy_law {
namespace {

constexpr double eps = std::numeric_limits<double>::epsilon();
constexpr Mass all_masses[] = {Mass::consistent, Mass::lumped, Mass::paper, Mass::redistributed, Mass::fourth_order};

struct Setting {
  EndCondition left, right;
  Mass mass;
  double viscosity;
  bool loaded, span;
};

std::vector<Setting> all_settings() {
  std::vector<Setting> settings;
  const EndCondition ends[] = {Free{}, Fixed{}, Obstacle{0.2}};
  for (const auto& left : ends)
    for (const auto& right : ends)
      for (const Mass mass : all_masses)
        for (const double viscosity : {0.0, 0.3})
          for (const bool loaded : {false, true})
            for (const bool span : {false, true})
              if (!(span && mass == Mass::redistributed))
                settings.push_back({left, right, mass, viscosity, loaded, span});
  return settings;
}

// Nodal values that oscillate from node to node as any can, none below the obstacles.
Scene random_scene(const Setting& setting, std::mt19937& random) {
  std::uniform_real_distribution<double> uniform(0.5, 2.0);
  Scene scene;
  scene.bar = {1.0, uniform(random), uniform(random), setting.viscosity * uniform(random)};
  scene.left = setting.left;
  scene.right = setting.right;
  if (setting.span) scene.span = Obstacle{0.15};
  const double phase = uniform(random);
  scene.displacement = [phase](double x) { return 0.1 + 0.2 * std::sin(1e4 * x + phase); };
  scene.velocity = [phase](double x) { return std::cos(3e4 * x * x + phase) - 1.0; };
  if (setting.loaded)
    scene.load = GeneralLoad{[phase](double x, double t) { return 5 * std::sin(1e5 * (x + phase) * (t + 1.0)); }};
  return scene;
}

constexpr std::pair<Impact, double> all_impacts[] = {{Impact::paoli_schatzman, 0.0}, {Impact::paoli_schatzman, 0.7},
                                                     {Impact::paoli_schatzman, 1.0}, {Impact::moreau, 0.0},
                                                     {Impact::moreau, 0.7},          {Impact::moreau, 1.0}};

// Energy that impacts take from n to n + 1, by the laws of docs/model.md; after balance().
double taken(const TimeStep& step, Impact impact, double dt, double e) {
  double sum = 0.0;
  for (std::size_t k = 0; k < step.contacts().size(); ++k) {
    const Contact& contact = step.contacts()[k];
    const double p = step.p()[contact.unknown], before = step.u()[contact.unknown] - dt * p + contact.gap;
    sum += step.reaction()[k] *
           (impact == Impact::moreau ? dt * (1.0 - e) / 2.0 * std::max(-p, 0.0) : (1.0 + e) / 2.0 * before);
  }
  return sum;
}

// E^{n+1/2} - E^{n-1/2} = dt (f, v) - eta dt a(v, v) + dt lambda.v at every step, the last term being what impacts
// take.
TEST(FullyDiscrete, ObeysTheDiscreteEnergyLawAtEveryStepForEveryStepSize) {
  std::mt19937 random(1);
  const Mesh mesh{1.0, 16};
  std::map<std::pair<Impact, double>, int> impacts, gains;  // steps with a reaction, and those that gain
  for (const Setting& setting : all_settings()) {
    const Scene scene = random_scene(setting, random);
    const BarSystem system(scene, mesh, setting.mass);
    for (const double ratio : {0.01, 0.3, 1.0, 30.0, 1000.0})
      for (const auto& [impact, restitution] : all_impacts) {
        const double dt = ratio * mesh.spacing();
        TimeStep step(system, system.initial_state(), 0.0, {.step = dt, .restitution = restitution, .impact = impact});
        const StepEnergy energy(system, step, std::array{0.0, 40.0 * dt}, dt);
        std::vector<double> v(system.size());
        BandedMatrix matrix;
        system.dynamic_stiffness(1.0, dt / 2, dt * dt / 2, matrix);
        const std::vector<double> compliance = inverse_diagonal(matrix);
        for (int n = 1; n <= 40; ++n) {
          const double before = energy.energy();
          double work = 0.0, loss = 0.0, moved = 0.0, lifted = 0.0, solved = 0.0;
          for (std::size_t k = 0; k < step.contacts().size(); ++k)
            lifted += step.reaction()[k] * compliance[step.contacts()[k].unknown];
          for (std::size_t i = 0; i < v.size(); ++i) {
            v[i] = step.p()[i] + dt / 2 * step.acceleration()[i];
            solved += dt * matrix.diagonal[i] * (std::abs(step.acceleration()[i]) + lifted) * std::abs(v[i]);
          }
          for (std::size_t k = 0; k < step.contacts().size(); ++k) {
            const double power = step.reaction()[k] * v[step.contacts()[k].unknown];
            loss -= dt * power;
            moved += dt * std::abs(power);
          }
          if (system.loaded()) work = dt * std::inner_product(v.begin(), v.end(), step.load().begin(), 0.0);
          const double law = taken(step, impact, dt, restitution);
          const double viscous = dt * system.bar().viscosity * system.elements().squared_strain_rate(v);
          step.advance();
          const double ends = system.has_end_rows() ? dt * energy.end_power() : 0.0;
          const double after = energy.energy();
          // Rounding of the rows of the solve and of the reactions' correction of it, of u (strains are differences of
          // it), and of the sums.
          double largest = 0.2;
          for (const double u : step.u()) largest = std::max(largest, std::abs(u));
          const double strain = 2 * largest / mesh.spacing();
          const double scale = before + after + solved + viscous + std::abs(work) + moved +
                               system.bar().modulus * strain * largest * static_cast<double>(mesh.nodes());
          ASSERT_NEAR(after - before, work - viscous - loss - ends, 100 * eps * scale)
              << "dt/h " << ratio << " " << name(setting.mass) << " e " << restitution << " step " << n;
          ASSERT_NEAR(loss, law, 100 * eps * scale) << ratio << " " << name(setting.mass) << " e " << restitution;
          if (impact == Impact::moreau || restitution == 0.0) {
            ASSERT_GE(loss, -100 * eps * scale);
          }
          impacts[{impact, restitution}] += moved > 0.0;
          gains[{impact, restitution}] += loss < -100 * eps * scale;
          step.balance(static_cast<double>(n + 1) * dt);
        }
      }
  }
  for (const auto& which : all_impacts) {
    EXPECT_GT(impacts[which], 1000) << which.second;
    EXPECT_EQ(gains[which] > 0, which.first == Impact::paoli_schatzman && which.second > 0.0) << which.second;
  }
}

// One node of mass m on a spring k: the two steps of an impact, and nothing else, change its energy by
//   -(1 - e^2) (m p^2 / 2 + k (g^n^2 + g^{n-1}^2) / 4) + (1 + e) / 2 F (g^n + g^{n-1}),    F = k gap,
// g = u + gap. At e = 1 that is a gain wherever g^n + g^{n-1} > 0, and up to F |p| dt, which no step is too short for.
TEST(FullyDiscrete, AnImpactOfPaoliAndSchatzmanOnASpringGainsUpToForceTimesPathOfAStepAtAnyStep) {
  const double gap = 0.25, m = 0.5, k = 1.0, force = k * gap;
  for (const double e : {0.25, 0.5, 1.0})
    for (const double dt : {1.0 / 8, 1.0 / 64, 1.0 / 1024}) {
      double largest = -1.0, smallest = 1.0;
      for (int phase = 0; phase < 64; ++phase) {
        Scene scene;
        scene.left = Obstacle{gap};
        scene.right = Fixed{};
        scene.displacement = [=](double x) { return (1.0 - x) * (-gap + (4 + phase / 64.0) * dt); };
        scene.velocity = [](double x) { return x - 1.0; };
        const BarSystem system(scene, {1.0, 1}, Mass::lumped);
        TimeStep step(system, system.initial_state(), 0.0, {.step = dt, .restitution = e});
        const StepEnergy energy(system, step, std::array{0.0, 1.0}, dt);
        double t = dt;
        const auto advance = [&] {
          step.advance();
          step.balance(t += dt);
        };
        while (!step.active()[0]) advance();
        const double before = energy.energy(), p = step.p()[0], g = step.u()[0] + gap, g_before = g - dt * p;
        advance();
        if (!step.active()[0]) continue;  // the spring drew it off before the second step
        step.advance();
        const double change = energy.energy() - before;
        EXPECT_NEAR(change,
                    -(1 - e * e) * (m * p * p / 2 + k * (g * g + g_before * g_before) / 4) +
                        (1 + e) / 2 * force * (g + g_before),
                    20 * eps / dt);
        largest = std::max(largest, change / (force * -p * dt));
        smallest = std::min(smallest, change / (force * -p * dt));
      }
      if (e == 1.0) {
        EXPECT_LE(largest, 1.0 + 0.5 * dt);
        EXPECT_GE(largest, 0.9);
        EXPECT_LE(smallest, -0.9);
      }
    }
}

// A bar held at its right end, that touches the obstacle unstrained, rebounds for ever: what impacts gain is a share of
// the energy, and shares multiply.
TEST(FullyDiscrete, ReboundsForEverMayGrowWithoutBoundByPaoliAndSchatzmanAndNeverByMoreau) {
  Scene scene;
  scene.bar.length = 1.0625;
  scene.left = Obstacle{0.0};
  scene.right = Fixed{};
  scene.displacement = [](double) { return 0.0; };
  scene.velocity = [](double) { return 0.0625; };
  const BarSystem system(scene, {1.0625, 3}, Mass::consistent);
  const double times[] = {0.0, 6800.0};
  Observers observers;
  observers.energy = true;
  for (const auto& [restitution, dt] : {std::pair{1.0, 0.1}, {0.5, 0.4}}) {
    FullyDiscrete scheme{.step = dt, .restitution = restitution};
    const EnergyAccount grown = *integrate(system, system.initial_state(), times, scheme, observers).energy;
    EXPECT_GT(grown.final, 1e10 * grown.initial) << restitution;
    EXPECT_GT(grown.growth, 1e9 * grown.initial) << restitution;
    scheme.impact = Impact::moreau;
    const EnergyAccount kept = *integrate(system, system.initial_state(), times, scheme, observers).energy;
    const double rounding = 6800.0 / dt * 100 * eps * kept.initial;
    EXPECT_LE(kept.final, kept.initial + rounding) << restitution;
    if (restitution == 1.0) {
      EXPECT_GE(kept.final, kept.initial - rounding);
    }
  }
}

// A node passes the obstacle within one step and is never deeper than after it.
TEST(FullyDiscrete, MoreausImpactLetsANodeNoDeeperThanOneStepOfItsFall) {
  std::mt19937 random(3);
  const Mesh mesh{1.0, 16};
  for (const Setting& setting : all_settings()) {
    const BarSystem system(random_scene(setting, random), mesh, setting.mass);
    for (const double ratio : {0.1, 1.0, 30.0})
      for (const double e : {0.0, 0.7, 1.0}) {
        const double dt = ratio * mesh.spacing();
        TimeStep step(system, system.initial_state(), 0.0, {.step = dt, .restitution = e, .impact = Impact::moreau});
        double fall = 0.0, deepest = 0.0, size = 1.0;
        for (int n = 1; n <= 200; ++n) {
          for (const Contact& contact : step.contacts()) {
            const double u = step.u()[contact.unknown], p = step.p()[contact.unknown];
            if (u - dt * p > -contact.gap) fall = std::max(fall, -dt * p);
            deepest = std::max(deepest, -(u + contact.gap));
            size = std::max(size, std::abs(u) + std::abs(dt * p));
          }
          ASSERT_LE(deepest, fall + 4 * n * eps * size) << ratio << " " << name(setting.mass) << " e " << e;
          step.advance();
          step.balance(static_cast<double>(n + 1) * dt);
        }
      }
  }
}

TEST(FullyDiscrete, IsUnconditionallyStableWithoutLoadUnlessImpactsOfPaoliAndSchatzmanRebound) {
  std::mt19937 random(2);
  const Mesh mesh{1.0, 16};
  for (const Setting& setting : all_settings()) {
    if (setting.loaded) continue;
    const BarSystem system(random_scene(setting, random), mesh, setting.mass);
    for (const double ratio : {0.1, 1.0, 1000.0})
      for (const Start start : {Start::first_order, Start::second_order})
        for (const auto& [impact, restitution] : all_impacts) {
          const double dt = ratio * mesh.spacing();
          const double times[] = {0.0, 500 * dt};
          Observers observers;
          observers.energy = true;
          const FullyDiscrete scheme{dt, start, restitution, impact};
          const auto energy = *integrate(system, system.initial_state(), times, scheme, observers).energy;
          const double rounding = 500 * 100 * eps * (energy.initial + energy.final);
          // The symmetric part of `fourth_order` makes no energy that only falls; 1.5 times the first is what such
          // data, which oscillate from node to node, were found to reach.
          const double initial = (system.has_end_rows() ? 2.0 : 1.0) * energy.initial;
          EXPECT_LE(energy.final, initial + energy.growth + rounding) << ratio << " " << name(setting.mass);
          EXPECT_NEAR(energy.balance_error(), 0.0, rounding);
          EXPECT_EQ(energy.work, 0.0);
          if (impact == Impact::moreau || restitution == 0.0) {
            EXPECT_LE(energy.growth, rounding) << ratio << " " << name(setting.mass) << " e " << restitution;
          }
        }
  }
}

}  // namespace
}  // namespace viscobar::testing_energy_law

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numeric>
#include <random>

#include "schemes/time_step.hpp"

namespace viscobar {
namespace {

constexpr double eps = std::numeric_limits<double>::epsilon();
constexpr Mass all_masses[] = {Mass::consistent, Mass::lumped, Mass::paper, Mass::redistributed};

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

// E^{n+1/2} - E^{n-1/2} = dt (f, v) - eta dt a(v, v) + dt lambda.v at every step, the last term being a loss.
TEST(FullyDiscrete, ObeysTheDiscreteEnergyLawAtEveryStepForEveryStepSize) {
  std::mt19937 random(1);
  const Mesh mesh{1.0, 16};
  for (const Setting& setting : all_settings()) {
    const Scene scene = random_scene(setting, random);
    const BarSystem system(scene, mesh, setting.mass);
    for (const double ratio : {0.01, 0.3, 1.0, 30.0, 1000.0})
      for (const double restitution : {0.0, 0.7}) {
        const double dt = ratio * mesh.spacing();
        TimeStep step(system, system.initial_state(), 0.0, {.step = dt, .restitution = restitution});
        std::vector<double> v(system.size());
        SymmetricTridiagonal matrix;
        system.dynamic_stiffness(1.0, dt / 2, dt * dt / 2, matrix);
        const std::vector<double> compliance = inverse_diagonal(matrix);
        for (int n = 1; n <= 40; ++n) {
          const double before = step.energy();
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
          const double viscous = dt * system.bar().viscosity * system.squared_strain_rate(v);
          step.advance();
          const double after = step.energy();
          // Rounding of the rows of the solve and of the reactions' correction of it, of u (strains are differences of
          // it), and of the sums.
          double largest = 0.2;
          for (const double u : step.u()) largest = std::max(largest, std::abs(u));
          const double strain = 2 * largest / mesh.spacing();
          const double scale = before + after + solved + viscous + std::abs(work) + moved +
                               system.bar().modulus * strain * largest * static_cast<double>(mesh.nodes());
          ASSERT_NEAR(after - before, work - viscous - loss, 100 * eps * scale)
              << "dt/h " << ratio << " " << name(setting.mass) << " e " << restitution << " step " << n;
          if (restitution == 0.0) {
            ASSERT_GE(loss, -100 * eps * scale);
          }
          step.balance(static_cast<double>(n + 1) * dt);
        }
      }
  }
}

TEST(FullyDiscrete, IsUnconditionallyStableWithoutLoad) {
  std::mt19937 random(2);
  const Mesh mesh{1.0, 16};
  for (const Setting& setting : all_settings()) {
    if (setting.loaded) continue;
    const BarSystem system(random_scene(setting, random), mesh, setting.mass);
    for (const double ratio : {0.1, 1.0, 1000.0})
      for (const Start start : {Start::first_order, Start::second_order}) {
        const double dt = ratio * mesh.spacing();
        const double times[] = {0.0, 500 * dt};
        Observers observers;
        observers.energy = true;
        const auto energy =
            *integrate(system, system.initial_state(), times, FullyDiscrete{dt, start}, observers).energy;
        EXPECT_LE(energy.final, energy.initial * (1 + 500 * 100 * eps)) << ratio << " " << name(setting.mass);
        EXPECT_NEAR(energy.balance_error(), 0.0, 500 * 100 * eps * energy.initial);
        EXPECT_EQ(energy.work, 0.0);
      }
  }
}

}  // namespace
}  // namespace viscobar

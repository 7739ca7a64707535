#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <utility>

#include "support/allocations.hpp"
#include "viscobar/schemes/schemes.hpp"

namespace viscobar::testing_allocation {
namespace {

using testing_support::allocations;

std::size_t allocations_of(const BarSystem& system, double step, double end, double restitution, Impact impact) {
  const State start = system.initial_state();
  std::vector<double> times(101);
  for (std::size_t k = 0; k < times.size(); ++k) times[k] = end * static_cast<double>(k) / 100.0;
  double seen = 0.0;
  Observers observers;
  observers.snapshot = [&](const Snapshot& now) { seen += now.u.front(); };
  observers.event = [&](const Event& event) { seen += event.time; };
  observers.progress = [&](double time) {
    seen += time;
    return RunControl::go_on;
  };
  observers.energy = observers.account = true;
  const std::size_t before = allocations;
  integrate(system, start, times, FullyDiscrete{.step = step, .restitution = restitution, .impact = impact}, observers);
  return allocations - before;
}

TEST(FullyDiscrete, StepsAllocateNothing) {
  for (const bool span : {false, true})
    for (const auto& [restitution, impact] :
         {std::pair{0.0, Impact::paoli_schatzman}, {0.5, Impact::paoli_schatzman}, {0.5, Impact::moreau}}) {
      Scene scene;
      scene.bar.viscosity = 0.01;
      scene.left = scene.right = Obstacle{0.1};
      if (span) scene.span = Obstacle{0.05};
      scene.displacement = [](double x) { return x * (1 - x); };
      scene.velocity = [](double x) { return -x * (1 - x); };
      scene.load = GeneralLoad{[](double x, double t) { return std::cos(std::numbers::pi * x) * std::sin(9 * t) - 1; }};
      for (const Mass mass : {Mass::consistent, Mass::fourth_order}) {
        const BarSystem system(scene, {1.0, 40}, mass);
        allocations_of(system, 0.01, 1.0, restitution, impact);  // makes the tables that all runs share
        EXPECT_EQ(allocations_of(system, 0.01, 10.0, restitution, impact),
                  allocations_of(system, 0.001, 10.0, restitution, impact))
            << name(mass) << (span ? " over a span" : "") << ", restitution " << restitution;
      }
    }
}

}  // namespace
}  // namespace viscobar::testing_allocation

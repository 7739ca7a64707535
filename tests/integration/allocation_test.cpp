#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <new>

#include "viscobar/integration/integrate.hpp"

namespace {
std::size_t allocations = 0;
}

void* operator new(std::size_t size) {
  ++allocations;
  if (void* memory = std::malloc(size ? size : 1)) return memory;
  throw std::bad_alloc();
}
void operator delete(void* memory) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }

namespace viscobar {
namespace {

template <class Method>
Statistics run(const BarSystem& system, double tolerance, std::size_t& allocated) {
  Method method{};
  method.penalty.epsilon = 1e-3;
  method.tolerance = {tolerance, 1e-3 * tolerance, ErrorControl::local};
  const State start = system.initial_state();
  double seen = 0.0;
  Observers observers;
  observers.snapshot = [&](const Snapshot& now) { seen += now.u.front(); };
  observers.progress = [&](double time) { seen += time; };
  observers.energy = true;
  std::vector<double> times(101);
  for (std::size_t k = 0; k < times.size(); ++k) times[k] = 0.02 * static_cast<double>(k);
  const std::size_t before = allocations;
  const Statistics statistics = integrate(system, start, times, method, observers);
  allocated = allocations - before;
  return statistics;
}

// The same scene in several times the steps allocates as often. Its contacts are watched, but do not change: locating a
// change may allocate.
template <class Method>
void expect_no_allocation_a_step() {
  Scene scene;
  scene.bar.viscosity = 0.1;
  scene.left = scene.right = Obstacle{10.0};
  scene.displacement = [](double x) { return x * (1 - x); };
  scene.velocity = [](double x) { return -x * (1 - x); };
  scene.load = GeneralLoad{[](double x, double t) { return -1.0 + 0.1 * x * std::sin(t); }};
  const BarSystem system(scene, {1.0, 100}, Mass::lumped);
  std::size_t few = 0, many = 0;
  run<Method>(system, 1e-4, few);  // makes the tables that all runs share
  const Statistics coarse = run<Method>(system, 1e-4, few), fine = run<Method>(system, 1e-9, many);
  EXPECT_GT(fine.steps, 3 * coarse.steps);
  EXPECT_EQ(fine.event_evaluations, fine.steps);
  EXPECT_EQ(many, few);
}

TEST(Cvode, StepsAllocateNothing) { expect_no_allocation_a_step<Cvode>(); }
TEST(Ida, StepsAllocateNothing) { expect_no_allocation_a_step<Ida>(); }

}  // namespace
}  // namespace viscobar

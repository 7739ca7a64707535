// What a step of scheme (2.8) costs, per node, beside a vector triad a_i = b_i + s c_i over the same J in the same run.
#include <benchmark/benchmark.h>

#include <vector>

#include "benchmark/scenes.hpp"
#include "viscobar/schemes/schemes.hpp"

namespace viscobar {
namespace {

void per_node(benchmark::State& state, double times) {
  const double nodes = static_cast<double>(state.range(0));
  state.counters["per_node"] =
      benchmark::Counter(nodes * times, benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}

void triad(benchmark::State& state) {
  const std::size_t n = static_cast<std::size_t>(state.range(0));
  std::vector<double> a(n, 0.0), b(n, 1.0), c(n, 2.0);
  const double s = 1e-3;
  for (auto _ : state) {
    for (std::size_t i = 0; i < n; ++i) a[i] = b[i] + s * c[i];
    benchmark::DoNotOptimize(a.data());
    benchmark::ClobberMemory();
  }
  per_node(state, 1.0);
}

// The throw: in flight, in contact and back, dt = h / 2, all of a run but the output.
void scheme_step(benchmark::State& state) {
  const std::size_t elements = static_cast<std::size_t>(state.range(0));
  const BarSystem system(throw_scene(), {1.0, elements}, Mass::consistent);
  const State start = system.initial_state();
  const double steps = std::max(200.0, 4e6 / static_cast<double>(elements)), dt = 0.5 / static_cast<double>(elements);
  const std::vector<double> times{0.0, steps * dt};
  for (auto _ : state) integrate(system, start, times, FullyDiscrete{.step = dt}, {});
  per_node(state, steps);
}

BENCHMARK(triad)->RangeMultiplier(10)->Range(100, 1000000);
BENCHMARK(scheme_step)->RangeMultiplier(10)->Range(100, 1000000);

}  // namespace
}  // namespace viscobar

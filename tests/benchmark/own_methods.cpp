// What a run of cvode and ida costs: the throw, T = 2, at the default tolerances.
#include <benchmark/benchmark.h>

#include <vector>

#include "benchmark/scenes.hpp"
#include "viscobar/integration/integrate.hpp"

namespace viscobar {
namespace {

template <class Method>
void run(benchmark::State& state, Mass mass) {
  const BarSystem system(throw_scene(), {1.0, static_cast<std::size_t>(state.range(0))}, mass);
  const State start = system.initial_state();
  const std::vector<double> times{0.0, 2.0};
  Method method{};
  method.penalty.epsilon = 1e-4;
  Statistics statistics;
  for (auto _ : state) statistics = integrate(system, start, times, method, {});
  state.counters["steps"] = static_cast<double>(statistics.steps);
  state.counters["factorisations"] = static_cast<double>(statistics.matrix_factorisations);
  state.counters["per_step"] =
      benchmark::Counter(static_cast<double>(statistics.steps),
                         benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}

void cvode(benchmark::State& state) { run<Cvode>(state, Mass::lumped); }
void ida(benchmark::State& state) { run<Ida>(state, Mass::lumped); }

BENCHMARK(cvode)->Arg(27)->Arg(1000)->Arg(10000)->Unit(benchmark::kMillisecond);
BENCHMARK(ida)->Arg(27)->Arg(1000)->Arg(10000)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace viscobar

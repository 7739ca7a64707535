// Cost of a step of scheme (2.8) per node, beside a vector triad a_i = b_i + s c_i over as many numbers and beside
// the scheme in the paper's way, in the same run. A bar under its weight with both ends in flight, and with both in
// contact.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <vector>

#include "benchmark/baselines.hpp"
#include "benchmark/scenes.hpp"
#include "viscobar/schemes/schemes.hpp"

namespace viscobar {
namespace {

constexpr double flight = 1e12, contact = 0.0;  // gaps; the bar falls for up to 2e4 units of time

void per_node(benchmark::State& state, double times) {
  const double nodes = static_cast<double>(state.range(0));
  state.counters["per_node"] =
      benchmark::Counter(nodes * times, benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}

std::size_t step_count(benchmark::State& state) {
  return static_cast<std::size_t>(std::max(200.0, 4e6 / static_cast<double>(state.range(0))));
}

BarSystem bar(benchmark::State& state, double gap) {
  return BarSystem(weight_scene(0.1, gap), {1.0, static_cast<std::size_t>(state.range(0))}, Mass::consistent);
}

double half_element(benchmark::State& state) { return 0.5 / static_cast<double>(state.range(0)); }

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

// All of a run but the output; dt = h / 2.
void scheme(benchmark::State& state, double gap) {
  const BarSystem system = bar(state, gap);
  const State start = system.initial_state();
  const std::size_t steps = step_count(state);
  const double dt = half_element(state);
  const std::vector<double> times{0.0, static_cast<double>(steps) * dt};
  for (auto _ : state) integrate(system, start, times, FullyDiscrete{.step = dt}, {});
  per_node(state, static_cast<double>(steps));
}

template <auto run>
void baseline_of(benchmark::State& state, double gap) {
  const BarSystem system = bar(state, gap);
  const std::size_t steps = step_count(state) / 4;
  for (auto _ : state) benchmark::DoNotOptimize(run(system, half_element(state), steps));
  per_node(state, static_cast<double>(steps));
}
constexpr auto paper = baseline_of<baseline::paper_scheme>, plain = baseline_of<baseline::plain_scheme>;

BENCHMARK(triad)->RangeMultiplier(10)->Range(100, 1000000)->Repetitions(9);
BENCHMARK_CAPTURE(scheme, flight, flight)->RangeMultiplier(10)->Range(100, 1000000)->Repetitions(9);
BENCHMARK_CAPTURE(scheme, contact, contact)->RangeMultiplier(10)->Range(100, 1000000)->Repetitions(9);
BENCHMARK_CAPTURE(scheme, flight, flight)->Arg(10)->Arg(16)->Arg(27)->Repetitions(9);
BENCHMARK_CAPTURE(scheme, contact, contact)->Arg(10)->Arg(16)->Arg(27)->Repetitions(9);
BENCHMARK_CAPTURE(plain, flight, flight)->Arg(10)->Arg(16)->Arg(27)->Arg(100)->Repetitions(9);
BENCHMARK_CAPTURE(plain, contact, contact)->Arg(10)->Arg(16)->Arg(27)->Arg(100)->Repetitions(9);
BENCHMARK_CAPTURE(paper, flight, flight)->Arg(1000)->Arg(100000);
BENCHMARK_CAPTURE(paper, contact, contact)->Arg(1000)->Arg(100000);

}  // namespace
}  // namespace viscobar

// Value of a fit on sensitivities, their gain over differences of runs, and their cost: docs/fit.md,
// docs/sensitivity.md.
//
//     cmake --build --preset release --target measure_fit && build/release/tests/measure_fit
#include "viscobar/studies/fit/fit.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <ctime>
#include <random>
#include <vector>

#include "support/falling_bar.hpp"
#include "viscobar/case/recording.hpp"

namespace {

using namespace viscobar;

constexpr double truth[] = {0.08, 0.1, 1.0};  // viscosity, gap, modulus
constexpr const char* keys[] = {"bar.viscosity", "left.gap", "bar.modulus"};

Case bar(std::span<const double> values) {
  Case run;
  run.scene = falling_bar(values[1], 1.0, values[0]);
  run.scene.bar.modulus = values[2];
  run.elements = 30;
  run.method = MethodName::rigid;
  run.end = 4.0;
  run.output_every = 0.01;
  for (const char* key : keys) run.directions.push_back(direction(run, key));
  return run;
}

double seconds_since(std::clock_t started) { return static_cast<double>(std::clock() - started) / CLOCKS_PER_SEC; }

// The median time of a run with so many parameters; its steps and factorisations do not depend on them.
void print_costs(MethodName method, std::size_t elements) {
  constexpr const char* all[] = {"bar.viscosity", "left.gap", "bar.modulus", "bar.density", "bar.length"};
  double without = 0.0;
  for (const std::size_t count : {0, 1, 3, 5}) {
    Case run = bar(std::vector{0.05, 0.1, 1.0});
    run.method = method;
    run.epsilon = 1e-4;
    run.elements = elements;
    run.end = 3.0;
    run.directions.clear();
    for (std::size_t k = 0; k < count; ++k) run.directions.push_back(direction(run, all[k]));
    const BarSystem system = resolve(run).system();
    Observers observers;
    observers.energy = observers.account = true;
    observers.directions = run.directions;
    std::vector<double> seconds;
    Statistics done;
    for (int k = 0; k < 25; ++k) {
      const auto started = std::clock();
      done = simulate(resolve(run), system, observers);
      seconds.push_back(seconds_since(started));
    }
    std::ranges::sort(seconds);
    if (count == 0) without = seconds[12];
    fmt::print("| {} | {} | {} | {} | {} | {} | {:.2f} | {:.1f} |\n", name(method), elements, count, done.steps,
               done.linear_solves, done.matrix_factorisations, 1e3 * seconds[12], seconds[12] / without);
  }
}

struct Tally {
  std::vector<std::size_t> runs;
  std::size_t within = 0, converged = 0;
  double seconds = 0.0;
};

}  // namespace

int main(int argc, char** argv) {
  const int seeds = argc > 1 ? std::atoi(argv[1]) : 100;
  const Case exact = bar(truth);
  std::vector<double> times = exact.output_times();
  times.erase(times.begin());
  const Recording made = record([&] {
    Case run = exact;
    run.directions.clear();
    run.elements = 240;
    run.tolerance = {1e-10};
    return run;
  }());
  std::vector<double> trace;
  double largest = 0.0;
  for (std::size_t k = 1; k < made.times.size(); ++k) {
    trace.push_back(made.displacement(k).front());
    largest = std::max(largest, std::abs(trace.back()));
  }
  const double noise = 0.01 * largest;
  fmt::print("{} samples of u(0,t), made on 240 elements, noise {:.3g}; viscosity, gap and modulus from {} seeds\n\n",
             trace.size(), noise, seeds);
  fmt::print("| derivatives by | runs: least | median | most | converged | within three deviations | seconds |\n");
  fmt::print("|---|---|---|---|---|---|---|\n");
  for (const bool differences : {false, true}) {
    Tally tally;
    for (int seed = 1; seed <= seeds; ++seed) {
      std::mt19937 random(static_cast<unsigned>(seed));
      std::normal_distribution<double> error(0.0, noise);
      std::uniform_real_distribution<double> factor(0.6, 1.6);
      FitStudy study;
      study.model = bar;
      study.times = times;
      study.differences = differences;
      MeasuredTrace measured{TraceColumn::u_left, trace, noise};
      for (double& value : measured.values) value += error(random);
      study.traces.push_back(measured);
      for (std::size_t k = 0; k < 3; ++k)
        study.parameters.push_back({keys[k], truth[k] * factor(random), 1e-3 * truth[k], 1e3 * truth[k]});
      const auto started = std::clock();
      const FitResult result = fit(study);
      tally.seconds += seconds_since(started);
      tally.runs.push_back(result.runs);
      tally.converged += result.converged ? 1 : 0;
      bool within = true;
      for (std::size_t k = 0; k < 3; ++k)
        within = within &&
                 std::abs(result.parameters[k].estimate - truth[k]) <= 3.0 * result.parameters[k].standard_deviation;
      tally.within += within ? 1 : 0;
    }
    std::ranges::sort(tally.runs);
    fmt::print("| {} | {} | {} | {} | {} | {} | {:.2f} |\n", differences ? "differences" : "sensitivities",
               tally.runs.front(), tally.runs[tally.runs.size() / 2], tally.runs.back(), tally.converged, tally.within,
               tally.seconds);
  }
  fmt::print("\n| method | elements | parameters | steps | solves | factorisations | milliseconds | runs without |\n");
  fmt::print("|---|---|---|---|---|---|---|---|\n");
  for (const MethodName method : {MethodName::rigid, MethodName::cvode})
    for (const std::size_t elements : {50, 1000}) print_costs(method, elements);
}

// cvode, ida and arkode against stock CVODE and Boost.Odeint: one scene, the same semi-discrete system, the same
// tolerances; the error of u(0, t) at 201 times against a run of cvode at tolerance 1e-11.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>

#include "benchmark/baselines.hpp"
#include "benchmark/scenes.hpp"
#include "viscobar/integration/integrate.hpp"

namespace viscobar {
namespace {

using baseline::Problem;
using baseline::Trace;

constexpr double epsilon = 1e-4;

std::vector<double> output_times() {
  std::vector<double> times(201);
  for (std::size_t k = 0; k < times.size(); ++k) times[k] = 2.0 * static_cast<double>(k) / 200.0;
  return times;
}

template <class Method>
Trace own(const Problem& problem, double relative, double absolute, ErrorControl control) {
  Method method{};
  method.penalty.epsilon = problem.epsilon;
  method.tolerance = {relative, absolute, control};
  Trace trace;
  Observers observers;
  observers.snapshot = [&](const Snapshot& now) { trace.left.push_back(now.u.front()); };
  trace.steps = integrate(problem.system, problem.system.initial_state(), problem.times, method, observers).steps;
  return trace;
}

const Trace& reference(const Problem& problem) {
  static std::map<std::size_t, Trace> known;
  auto [place, missing] = known.try_emplace(problem.system.size());
  if (missing) place->second = own<Cvode>(problem, 1e-11, 1e-14, ErrorControl::global);
  return place->second;
}

double difference(const Trace& a, const Trace& b) {
  double largest = 0.0;
  for (std::size_t k = 0; k < b.left.size(); ++k) largest = std::max(largest, std::abs(a.left[k] - b.left[k]));
  return largest;
}

using Contender = std::function<Trace(const Problem&, double relative, double absolute)>;

void compare(benchmark::State& state, const Contender& contender, std::size_t elements, double tolerance) {
  const BarSystem system(throw_scene(), {1.0, elements}, Mass::lumped);
  const Problem problem{system, epsilon, output_times()};
  Trace trace;
  for (auto _ : state) trace = contender(problem, tolerance, 1e-3 * tolerance);
  state.counters["steps"] = static_cast<double>(trace.steps);
  state.counters["error"] = difference(trace, reference(problem));
}

template <class Method, ErrorControl control>
Trace ours(const Problem& problem, double relative, double absolute) {
  return own<Method>(problem, relative, absolute, control);
}

int register_all() {
  struct Entry {
    const char* name;
    Contender run;
    std::size_t largest;  // mesh that it can take
  };
  const Entry entries[] = {
      {"cvode_local", ours<Cvode, ErrorControl::local>, 10000},
      {"cvode_global", ours<Cvode, ErrorControl::global>, 10000},
      {"ida_local", ours<Ida, ErrorControl::local>, 10000},
      {"ida_global", ours<Ida, ErrorControl::global>, 10000},
      {"arkode_local", ours<Arkode, ErrorControl::local>, 10000},
      {"arkode_global", ours<Arkode, ErrorControl::global>, 10000},
      {"stock_restart",
       [](auto& p, double r, double a) { return baseline::stock_cvode(p, r, a, baseline::AtChange::restart); }, 10000},
      {"stock_plain",
       [](auto& p, double r, double a) { return baseline::stock_cvode(p, r, a, baseline::AtChange::nothing); }, 10000},
      {"rosenbrock4", baseline::rosenbrock4, 27},
      {"dopri5", baseline::dopri5, 27},
  };
  for (const std::size_t elements : {std::size_t{27}, std::size_t{1000}, std::size_t{10000}})
    for (const Entry& entry : entries)
      for (const int digits : {4, 6, 8}) {
        if (elements > entry.largest || (elements == 10000 && digits != 6)) continue;
        const double tolerance = std::pow(10.0, -digits);
        const std::string name =
            "integrators/" + std::string(entry.name) + "/" + std::to_string(elements) + "/" + std::to_string(digits);
        benchmark::RegisterBenchmark(name.c_str(), [=](benchmark::State& state) {
          compare(state, entry.run, elements, tolerance);
        })->Unit(benchmark::kMillisecond);
      }
  return 0;
}

[[maybe_unused]] const int registered = register_all();

}  // namespace
}  // namespace viscobar

// Cost of the treatment of a contact change, measured on stock CVODE, where nothing else changes with it: step across
// the kink, or re-initialise with one of three first steps. Beside it cvode, whose legs are frozen, at the local
// tolerance and as it is by default, at the global one.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <variant>

#include "benchmark/baselines.hpp"
#include "benchmark/scenes.hpp"
#include "viscobar/integration/integrate.hpp"

namespace viscobar {
namespace {

using baseline::AtChange;
using baseline::Problem;
using baseline::Trace;

struct Setting {
  const char* name;
  double viscosity, epsilon;
  bool rests, loaded, adams;
};

constexpr Setting settings[] = {
    {"throw", 0.1, 1e-4, false, true, false},
    {"chatter 1e-4", 0.01, 1e-4, false, false, true},
    {"chatter 1e-6", 0.01, 1e-6, false, false, true},
    {"resting", 1.0, 1e-4, true, true, false},
};

Trace own(const Problem& problem, double tolerance, ErrorControl control) {
  Cvode method;
  method.penalty.epsilon = problem.epsilon;
  method.tolerance = {tolerance, 1e-3 * tolerance, control};
  Trace trace;
  Observers observers;
  observers.snapshot = [&](const Snapshot& now) { trace.left.push_back(now.u.front()); };
  const Statistics statistics =
      integrate(problem.system, problem.system.initial_state(), problem.times, method, observers);
  trace.steps = statistics.steps;
  trace.changes = statistics.events;
  return trace;
}

using Policy = std::variant<AtChange, ErrorControl>;  // of stock CVODE, of cvode

void measure(benchmark::State& state, const Setting& setting, const Policy& policy) {
  Scene scene = setting.rests ? weight_scene(setting.viscosity, 0.01) : throw_scene(setting.viscosity);
  if (!setting.loaded) scene.load.reset();
  const BarSystem system(scene, {1.0, 27}, Mass::lumped);
  Problem problem{system, setting.epsilon, {}};
  for (int k = 0; k <= 200; ++k) problem.times.push_back(6.0 * k / 200.0);
  const double tolerance = 1e-8;
  const auto* const stock = std::get_if<AtChange>(&policy);
  Trace trace;
  for (auto _ : state)
    trace = stock ? baseline::stock_cvode(problem, tolerance, 1e-3 * tolerance, *stock, setting.adams)
                  : own(problem, tolerance, std::get<ErrorControl>(policy));
  const Trace reference = own(problem, 1e-11, ErrorControl::global);
  double error = 0.0;
  for (std::size_t k = 0; k < reference.left.size(); ++k)
    error = std::max(error, std::abs(trace.left[k] - reference.left[k]));
  state.counters["changes"] = static_cast<double>(reference.changes);
  state.counters["steps"] = static_cast<double>(trace.steps);
  state.counters["error"] = error;
}

int register_all() {
  const std::pair<const char*, Policy> policies[] = {
      {"across", AtChange::nothing},    {"restart", AtChange::restart}, {"kept", AtChange::restart_kept},
      {"last", AtChange::restart_last}, {"cvode", ErrorControl::local}, {"cvode_global", ErrorControl::global}};
  for (const Setting& setting : settings)
    for (const auto& [name, policy] : policies)
      benchmark::RegisterBenchmark(
          (std::string("policy/") + name + "/" + setting.name).c_str(),
          [&setting, policy = policy](benchmark::State& state) { measure(state, setting, policy); })
          ->Unit(benchmark::kMillisecond);
  return 0;
}

[[maybe_unused]] const int registered = register_all();

}  // namespace
}  // namespace viscobar

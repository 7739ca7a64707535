// Cost of runs of cvode, ida and arkode by mesh, and by penalty and mass: the throw, T = 2.
#include <benchmark/benchmark.h>

#include <cmath>
#include <string>
#include <vector>

#include "benchmark/scenes.hpp"
#include "viscobar/integration/integrate.hpp"

namespace viscobar {
namespace {

struct Setting {
  std::size_t elements;
  Mass mass;
  double epsilon, relative, absolute;
  ErrorControl control;
};

template <class Method>
void run(benchmark::State& state, const Setting& setting) {
  const BarSystem system(throw_scene(), {1.0, setting.elements}, setting.mass);
  const State start = system.initial_state();
  const std::vector<double> times{0.0, 2.0};
  Method method{};
  method.penalty.epsilon = setting.epsilon;
  method.tolerance = {setting.relative, setting.absolute, setting.control};
  Statistics statistics;
  for (auto _ : state) statistics = integrate(system, start, times, method, {});
  state.counters["steps"] = static_cast<double>(statistics.steps);
  state.counters["factorisations"] = static_cast<double>(statistics.matrix_factorisations);
  state.counters["events"] = static_cast<double>(statistics.events);
}

template <class Method>
void add(const std::string& name, const Setting& setting) {
  benchmark::RegisterBenchmark(name.c_str(), run<Method>, setting)->Unit(benchmark::kMillisecond);
}

int register_all() {
  for (const std::size_t elements : {27, 100, 1000, 10000, 100000})
    for (const Mass mass : {Mass::lumped, Mass::redistributed})
      add<Cvode>("cvode/mesh/" + std::string(name(mass)) + "/" + std::to_string(elements),
                 {elements, mass, 1e-4, 1e-6, 1e-9, ErrorControl::global});
  for (int digits = 3; digits <= 8; ++digits)
    for (const Mass mass : {Mass::lumped, Mass::redistributed}) {
      const std::string label = "/epsilon/" + std::string(name(mass)) + "/" + std::to_string(digits);
      const Setting setting{400, mass, std::pow(10.0, -digits), 1e-5, 1e-8, ErrorControl::global};
      add<Cvode>("cvode" + label, setting);
      add<Ida>("ida" + label, setting);
      add<Arkode>("arkode" + label, setting);
    }
  return 0;
}

[[maybe_unused]] const int registered = register_all();

}  // namespace
}  // namespace viscobar

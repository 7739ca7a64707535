// One run with sensitivities, for scripts/sensitivity-cost, which counts its instructions: docs/sensitivity.md.
//
//     measure_sensitivity_cost METHOD ELEMENTS PARAMETERS
#include <fmt/format.h>

#include <array>
#include <cstdlib>
#include <exception>
#include <stdexcept>
#include <string_view>

#include "support/falling_bar.hpp"
#include "viscobar/case/case.hpp"

namespace {

using namespace viscobar;

constexpr std::array keys = {"bar.viscosity", "left.gap", "bar.modulus", "bar.density", "bar.length"};

MethodName method_of(std::string_view word) {
  for (const MethodName method : {MethodName::rigid, MethodName::cvode, MethodName::ida, MethodName::arkode})
    if (name(method) == word) return method;
  throw std::invalid_argument("METHOD is rigid, cvode, ida or arkode");
}

// The bar that rebounds of measure_fit's table of costs.
Case rebound(MethodName method, std::size_t elements, std::size_t parameters) {
  Case run;
  run.scene = falling_bar(0.1, 1.0, 0.05);
  run.method = method;
  run.elements = elements;
  run.epsilon = 1e-4;
  run.end = 3.0;
  run.output_every = 0.01;
  for (std::size_t k = 0; k < parameters; ++k) run.directions.push_back(direction(run, keys.at(k)));
  return run;
}

}  // namespace

/// The run that is counted, without the start of the program. A name that callgrind's --toggle-collect knows.
extern "C" [[gnu::noinline]] void measured_run(const Case* run, const BarSystem* system, const Observers* observers,
                                               Statistics* done) {
  *done = simulate(resolve(*run), *system, *observers);
}

int main(int argc, char** argv) try {
  if (argc != 4) throw std::invalid_argument("usage: measure_sensitivity_cost METHOD ELEMENTS PARAMETERS");
  const Case run = rebound(method_of(argv[1]), static_cast<std::size_t>(std::atoi(argv[2])),
                           static_cast<std::size_t>(std::atoi(argv[3])));
  const BarSystem system = resolve(run).system();
  Observers observers;
  observers.energy = observers.account = true;
  observers.directions = run.directions;
  Statistics done;
  measured_run(&run, &system, &observers, &done);
  fmt::print("{} {} {}\n", done.steps, done.linear_solves, done.matrix_factorisations);
} catch (const std::exception& error) {
  fmt::print(stderr, "{}\n", error.what());
  return EXIT_FAILURE;
}

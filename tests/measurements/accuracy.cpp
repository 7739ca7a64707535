// Prints how far the adaptive methods are from the exponential reference, in multiples of the requested tolerance, and
// what it costs them: the tables of docs/methods.md. Run: build/release/tests/measure_accuracy
#include <fmt/format.h>

#include <algorithm>
#include <string>

#include "support/maximum_norm.hpp"
#include "support/paper_throw.hpp"
#include "viscobar/case/recording.hpp"

namespace {

using namespace viscobar;

Case two_obstacles(double viscosity, double epsilon, Mass mass) {
  Case run = paper_throw(viscosity);
  run.mass = mass;
  run.epsilon = epsilon;
  run.output_every = 0.05;
  return run;
}

struct Variant {
  const char* label;
  MethodName method;
  ErrorControl control;
  Formulas formulas = Formulas::automatic;
  Stepper stepper = Stepper::automatic;
};

}  // namespace

int main() {
  const Variant variants[] = {
      {"cvode", MethodName::cvode, ErrorControl::global},
      {"ida", MethodName::ida, ErrorControl::global},
      {"arkode", MethodName::arkode, ErrorControl::global},
      {"odeint, dopri5", MethodName::odeint, ErrorControl::global, Formulas::automatic, Stepper::dopri5},
      {"odeint, rosenbrock4", MethodName::odeint, ErrorControl::global, Formulas::automatic, Stepper::rosenbrock4},
      {"cvode, local error control", MethodName::cvode, ErrorControl::local},
      {"arkode, local error control", MethodName::arkode, ErrorControl::local},
      {"cvode, bdf only", MethodName::cvode, ErrorControl::global, Formulas::bdf},
      {"cvode, adams only", MethodName::cvode, ErrorControl::global, Formulas::adams},
  };
  fmt::print("[0,1], both ends an obstacle at 0.1, u_0 = x(1-x), u_1 = -u_0, 27 elements, T = 6\n");
  fmt::print(
      "error of u / tolerance, contact changes, steps, milliseconds (best of five); tolerance 1e-6, 1e-8, 1e-10\n");
  for (const double viscosity : {0.0, 0.01, 0.1, 1.0}) {
    for (const double epsilon : {1e-2, 1e-4, 1e-6}) {
      for (const Mass mass : {Mass::consistent, Mass::redistributed}) {
        Case run = two_obstacles(viscosity, epsilon, mass);
        run.method = MethodName::exponential;
        const Recording reference = record(run);
        fmt::print("\nviscosity {}, epsilon {}, {}: {} contact changes\n", viscosity, epsilon, name(mass),
                   reference.events.size());
        for (const Variant& variant : variants) {
          run.method = variant.method;
          run.formulas = variant.formulas;
          run.stepper = variant.stepper;
          if (!faults(resolve(run)).empty()) continue;
          // Massless nodes are stiff at any time: Adams' formulas would take as many steps as they have time constants.
          if (variant.formulas == Formulas::adams && (mass == Mass::redistributed || viscosity > 0.05)) continue;
          // Where nothing is stiff a dense step only costs.
          if (variant.stepper == Stepper::rosenbrock4 && viscosity == 0.0) continue;
          std::string line = fmt::format("  {:<28}", variant.label);
          for (const double tolerance : {1e-6, 1e-8, 1e-10}) {
            run.tolerance = {tolerance, tolerance * 1e-3, variant.control};
            const Recording recording = record(run);
            double seconds = recording.statistics.integration_seconds;
            for (int again = 0; again < 4 && seconds < 0.1; ++again)
              seconds = std::min(seconds, record(run).statistics.integration_seconds);
            line += fmt::format("  {:>9.3g} {:>4} {:>6} {:>6.2f}", relative_error(recording.u, reference.u) / tolerance,
                                recording.events.size(), recording.statistics.steps, 1e3 * seconds);
          }
          fmt::print("{}\n", line);
        }
      }
    }
  }
}

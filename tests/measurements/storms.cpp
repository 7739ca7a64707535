// Prints what scenes with many contact changes cost the adaptive methods, and how far they are from a reference: the
// tables of docs/internals/storms.md. Run: build/release/tests/measure_storms [SCENE [METHOD [TOLERANCE [quick]]]],
// with parts of names; quick leaves the reference out. Seconds are of the processor, the best of five.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "support/bouncing_bar.hpp"
#include "support/maximum_norm.hpp"
#include "support/paper_throw.hpp"
#include "support/processor_seconds.hpp"
#include "viscobar/case/recording.hpp"

namespace {

using namespace viscobar;

struct Setting {
  std::string name;
  Case run;
};

Case chatter(double epsilon) {
  Case run = paper_throw(0.01);
  run.epsilon = epsilon;
  run.output_every = 0.1;
  return run;
}

// A bar over a span obstacle, pulled down; `wave` is the height of its first shape.
Case over_span(std::size_t elements, double wave, double viscosity, double end) {
  Case run;
  run.mass = Mass::consistent;
  run.scene.bar.viscosity = viscosity;
  run.scene.span = Obstacle{0.1};
  run.scene.displacement = [wave](double x) { return wave * std::cos(7.0 * x); };
  run.scene.velocity = [](double) { return -1.0; };
  run.scene.load = SteadyLoad{[](double) { return -10.0; }};
  run.elements = elements;
  run.epsilon = 1e-4;
  run.end = end;
  return run;
}

// A bar that a steady load presses on its obstacle, where it comes to rest.
Case pressed(double epsilon) {
  Case run;
  run.mass = Mass::consistent;
  run.scene.bar.viscosity = 0.3;
  run.scene.left = Obstacle{0.0};
  run.scene.displacement = run.scene.velocity = [](double) { return 0.0; };
  run.scene.load = SteadyLoad{[](double) { return -1.0; }};
  run.elements = 8;
  run.epsilon = epsilon;
  run.end = 1.0;
  return run;
}

std::vector<Setting> settings() {
  std::vector<Setting> list;
  for (int decade = 2; decade <= 8; ++decade)
    list.push_back({fmt::format("chatter-1e-{}", decade), chatter(std::pow(10.0, -decade))});
  for (const std::size_t elements : {200, 1000}) {
    list.push_back({fmt::format("span-flat-{}", elements), over_span(elements, 0.0, 0.01, 2.0)});
    list.push_back({fmt::format("span-wavy-{}", elements), over_span(elements, 0.02, 0.01, 2.0)});
    list.push_back({fmt::format("span-undamped-{}", elements), over_span(elements, 0.02, 0.0, 1.0)});
  }
  list.push_back({"bouncing", bouncing_bar(40.0)});
  for (int decade = 6; decade <= 12; decade += 2)
    list.push_back({fmt::format("rest-1e-{}", decade), pressed(std::pow(10.0, -decade))});
  return list;
}

struct Variant {
  std::string label;
  MethodName method;
  Stepper stepper = Stepper::automatic;
};

bool wanted(const std::string& name, const char* word) { return !word || name.find(word) != std::string::npos; }

}  // namespace

int main(int argc, char** argv) {
  const char* scene = argc > 1 ? argv[1] : nullptr;
  const char* method = argc > 2 ? argv[2] : nullptr;
  const std::vector<double> tolerances = argc > 3 ? std::vector{std::stod(argv[3])} : std::vector{1e-4, 1e-6, 1e-8};
  const bool judge = argc <= 4;  // a fourth word: run only, without a reference
  const Variant variants[] = {{"cvode", MethodName::cvode},
                              {"ida", MethodName::ida},
                              {"arkode", MethodName::arkode},
                              {"dopri5", MethodName::odeint, Stepper::dopri5}};
  for (Setting setting : settings()) {
    if (!wanted(setting.name, scene)) continue;
    Case& run = setting.run;
    run.output_every = run.end / 50;
    std::vector<double> reference;
    if (judge) {
      run.method = run.elements <= 60 ? MethodName::exponential : MethodName::arkode;
      run.tolerance = {1e-10, 1e-13};
      const double before = processor_seconds();
      const Recording best = record(run);
      reference = best.u;
      fmt::print("{}: {} contact changes, reference by {} in {:.3g} s\n", setting.name, best.events.size(),
                 name(run.method), processor_seconds() - before);
    }
    for (const Variant& variant : variants) {
      if (!wanted(variant.label, method)) continue;
      run.method = variant.method;
      run.stepper = variant.stepper;
      for (const double tolerance : tolerances) {
        run.tolerance = {tolerance, tolerance * 1e-3};
        try {
          double before = processor_seconds();
          const Recording recording = record(run);
          double seconds = processor_seconds() - before;
          for (int again = 0; again < 4 && seconds < 1.0; ++again) {
            before = processor_seconds();
            record(run);
            seconds = std::min(seconds, processor_seconds() - before);
          }
          const Statistics& s = recording.statistics;
          fmt::print("  {:<8} {:.0e}  changes {:>6}  steps {:>8} ({:.1f} a change)  evaluations {:>8}  {:>8.3g} s{}\n",
                     variant.label, tolerance, s.events, s.steps,
                     static_cast<double>(s.steps) / static_cast<double>(std::max<std::size_t>(s.events, 1)),
                     s.rhs_evaluations, seconds,
                     judge
                         ? fmt::format("  error / tolerance {:.3g}", relative_error(recording.u, reference) / tolerance)
                         : "");
        } catch (const IntegrationError& failure) {
          fmt::print("  {:<8} {:.0e}  {}\n", variant.label, tolerance, failure.what());
        }
        std::fflush(stdout);
      }
    }
  }
}

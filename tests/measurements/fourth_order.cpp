// Prints the tables of docs/fourth-order.md. Run:
// cmake --build --preset release --target measure_fourth_order && build/release/tests/measure_fourth_order [TABLE]...
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <map>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include "studies/parallel.hpp"
#include "support/falling_bar.hpp"
#include "viscobar/case/case.hpp"
#include "viscobar/case/end_traces.hpp"

namespace {

using namespace viscobar;

Case bar_over_an_obstacle(double viscosity, double gap, double load, double end) {
  Case run;
  run.scene = falling_bar(gap, 1.0, viscosity);
  if (load != 0.0) run.scene.load = SteadyLoad{[load](double) { return load; }};
  run.method = MethodName::rigid;
  run.restitution = 0.0;
  run.tolerance = {1e-11, 1e-14};
  run.end = end;
  run.output_every = 0.05;
  return run;
}

Case thrown_onto_an_obstacle(double viscosity) {
  Case run = bar_over_an_obstacle(viscosity, 0.1, 0.0, 2.5);
  run.scene.displacement = [](double x) { return 0.4 * x * (1 - x); };
  run.scene.velocity = [](double x) { return -0.5 - x; };
  run.scene.load = SteadyLoad{[](double x) { return -1 - x * x; }};
  return run;
}

EndTraces traces_on(Case run, std::size_t elements, Mass mass) {
  run.elements = elements;
  run.mass = mass;
  return trace_ends(run, run.output_times());
}

double latest_change(const EndTraces& a, const EndTraces& b) {
  double largest = 0.0;
  for (std::size_t k = 0; k < a.events.size(); ++k)
    largest = std::max(largest, std::abs(a.events[k].time - b.events[k].time));
  return largest;
}

void contact_table() {
  struct Row {
    const char* words;
    Case run;
    std::size_t coarsest;
  };
  const std::vector<Row> rows = {{"thrown under -1 - x^2, viscosity 1", thrown_onto_an_obstacle(1.0), 30},
                                 {"the same, 0.1", thrown_onto_an_obstacle(0.1), 30},
                                 {"the same, 0.03", thrown_onto_an_obstacle(0.03), 30},
                                 {"pressed by -4, 0.05", bar_over_an_obstacle(0.05, 0.1, -4.0, 6.0), 25},
                                 {"pressed by -1, 0.003", bar_over_an_obstacle(0.003, 0.1, -1.0, 6.0), 25},
                                 {"the same, 0.001", bar_over_an_obstacle(0.001, 0.1, -1.0, 6.0), 25}};
  fmt::print(
      "\nEnd traces: error at J, 2 J, 4 J, 8 J (consistent mass), against fourth_order on 32 J; rigid, restitution "
      "0\n\n"
      "| scene | J | first | second | third | fourth | orders | changes (consistent) | times of changes |\n"
      "|---|---|---|---|---|---|---|---|---|\n");
  for (const Row& row : rows) {
    std::vector<EndTraces> fourth(5), consistent(4);
    parallel_for(9, [&](std::size_t k) {
      const std::size_t elements = row.coarsest << (k < 4 ? k : k == 4 ? 5 : k - 5);
      (k < 5 ? fourth[k] : consistent[k - 5]) =
          traces_on(row.run, elements, k < 5 ? Mass::fourth_order : Mass::consistent);
    });
    std::string cells, orders, changes, times;
    double before = 0.0;
    for (std::size_t k = 0; k < 4; ++k) {
      const double error = largest_difference(fourth[k], fourth[4]);
      cells += fmt::format(" {:.1e} ({:.1e}) |", error, largest_difference(consistent[k], fourth[4]));
      if (k > 0) orders += fmt::format("{}{:.2f}", k > 1 ? ", " : "", std::log2(before / error));
      before = error;
      changes += fmt::format("{}{} ({})", k > 0 ? ", " : "", fourth[k].events.size(), consistent[k].events.size());
      times += fourth[k].events.size() == fourth[4].events.size()
                   ? fmt::format("{}{:.0e}", k > 0 ? ", " : "", latest_change(fourth[k], fourth[4]))
                   : "-";
    }
    fmt::print("| {} | {} |{} {} | {}; {} | {} |\n", row.words, row.coarsest, cells, orders, changes,
               fourth[4].events.size(), times);
  }
}

Case thrown_at_both(double viscosity, Mass mass) {
  Case run;
  run.scene.bar.viscosity = viscosity;
  run.scene.left = run.scene.right = Obstacle{0.1};
  run.scene.displacement = [](double x) { return x * (1 - x); };
  run.scene.velocity = [](double x) { return -x * (1 - x); };
  run.elements = 27;
  run.mass = mass;
  run.tolerance = {1e-10, 1e-13};
  run.end = 2.4;
  run.output_every = 0.01;
  return run;
}

// Seconds of the method alone for an error in space and time together: the fastest of the meshes (a fourth of an octave
// apart), methods, tolerances (half a decade) and steps (half an octave) tried that keeps it. (2.8) has dt for a
// tolerance. Error and seconds are those of a run that tells its state at times `every` apart.
void speed(double every) {
  constexpr Mass masses[] = {Mass::consistent, Mass::lumped, Mass::redistributed, Mass::fourth_order};
  constexpr double targets[] = {1e-4, 1e-6, 1e-8};
  fmt::print(
      "\nSpeed, two obstacles, rigid or (2.8), restitution 0, T = 2.4, samples every {}: seconds and setting for an error "
      "of the end traces, as a part of max|u|\n\n| viscosity | mass | 1e-4 | 1e-6 | 1e-8 |\n|---|---|---|---|---|\n",
      every);
  for (const double viscosity : {0.1, 0.01}) {
    Case run = thrown_at_both(viscosity, Mass::fourth_order);
    run.output_every = every;
    run.method = MethodName::rigid;
    run.restitution = 0.0;
    const auto times = run.output_times();
    run.elements = 2000;
    run.tolerance = {1e-12, 1e-15};
    const EndTraces reference = trace_ends(run, times);
    constexpr double largest = 0.25;  // in the middle, at the start
    std::map<Mass, std::array<double, 3>> best;
    for (const Mass mass : masses) {
      std::array<std::string, 3> words;
      best[mass].fill(1e9);
      run.mass = mass;
      // Returns the error.
      const auto attempt = [&](const std::string& setting) {
        EndTraces traces = trace_ends(run, times);
        const double error = largest_difference(traces, reference) / largest;
        double seconds = traces.statistics.integration_seconds;
        bool useful = false;
        for (std::size_t k = 0; k < 3; ++k) useful |= error <= targets[k] && seconds < 1.5 * best[mass][k];
        // The first of runs that take microseconds find cold caches.
        double spent = 0.0;
        for (int again = 0; useful && (again < 8 || spent < 0.01) && seconds < 0.5; ++again) {
          const double once = trace_ends(run, times).statistics.integration_seconds;
          seconds = std::min(seconds, once), spent += once;
        }
        for (std::size_t k = 0; k < 3; ++k)
          if (error <= targets[k] && seconds < best[mass][k]) best[mass][k] = seconds, words[k] = setting;
        return error;
      };
      // Settings from coarse to fine, as long as they lower the error of that mesh.
      const auto refine = [&](auto&& next) {
        double least = 1e9;
        for (int idle = 0; idle < 5;) {
          const std::optional<std::string> setting = next();
          if (!setting) return;
          const double error = attempt(*setting);
          idle = error < 0.8 * least ? 0 : idle + 1;
          least = std::min(least, error);
        }
      };
      for (double j = 10.0; j < 20000.0; j *= std::pow(2.0, 0.25)) {
        run.elements = static_cast<std::size_t>(std::lround(j));
        if (mass == Mass::fourth_order && run.elements > 1300) break;
        run.method = MethodName::rigid;
        refine([&, tolerance = 1e-2 * std::sqrt(10.0)]() mutable -> std::optional<std::string> {
          if ((tolerance /= std::sqrt(10.0)) < 5e-10) return std::nullopt;
          run.tolerance = {tolerance, tolerance * 1e-3};
          return fmt::format("rigid, {} elements, {:.0e}", run.elements, tolerance);
        });
        run.method = MethodName::fully_discrete;
        run.start = Start::second_order;
        // A whole number of steps between outputs.
        refine([&, parts = 0.5]() mutable -> std::optional<std::string> {
          const double dt = every / (parts < 1.0 ? parts : std::round(parts));
          parts *= std::numbers::sqrt2;
          if (2.4 / dt * j > 3e8) return std::nullopt;
          run.step = dt;
          return fmt::format("(2.8), {} elements, dt {:.1e}", run.elements, dt);
        });
      }
      std::string cells;
      for (std::size_t k = 0; k < 3; ++k)
        cells += words[k].empty() ? " not reached |" : fmt::format(" {:.2g} s ({}) |", best[mass][k], words[k]);
      fmt::print("| {} | {} |{}\n", viscosity, name(mass), cells);
    }
    std::string cells;
    for (std::size_t k = 0; k < 3; ++k) {
      double others = 1e9;
      for (const Mass mass : masses)
        if (mass != Mass::fourth_order) others = std::min(others, best[mass][k]);
      cells += others < 1e9 ? fmt::format(" {:.3g} |", others / best[Mass::fourth_order][k]) : " not reached by them |";
    }
    fmt::print("| {} | best of the others over fourth_order |{}\n", viscosity, cells);
  }
}

}  // namespace

int main(int count, char** arguments) {
  const std::vector<std::pair<std::string, std::function<void()>>> tables = {
      {"contact", contact_table}, {"speed", [] { speed(0.05), speed(0.02); }}};
  for (const auto& [word, print] : tables)
    if (count == 1 || std::find(arguments + 1, arguments + count, word) != arguments + count) print();
}

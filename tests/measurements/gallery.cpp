// Prints the tables of docs/gallery.md: bars of others with exact numbers, by our methods, beside what others
// published. scripts/gallery runs it, and beside it what of the others' programs this machine has. Run in the project's
// folder:
//     cmake --build --preset release --target measure_gallery && build/release/tests/measure_gallery
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include "gallery/period_three.hpp"
#include "viscobar/case/end_traces.hpp"
#include "viscobar/case/recording.hpp"
#include "viscobar/input/scene_file.hpp"

namespace {

using namespace viscobar;

using Overrides = std::vector<std::string>;

// The epsilon of a scene is for methods that need it: of it and of the method, automatic is told nothing.
constexpr const char* automatically = "method.name=automatic";

Case scene(const std::string& name, const Overrides& overrides) {
  Case run = read_scene("examples/scenes/" + name + ".toml", overrides).run;
  if (std::ranges::find(overrides, automatically) != overrides.end()) {
    run.epsilon.reset();
    run.method = automatic_method(run).method;
  }
  return run;
}

// Least time of twenty runs, or of as many as fit into a second.
double seconds(double first, auto&& again) {
  double best = first, spent = first;
  for (int run = 1; run < 20 && spent < 1.0; ++run) {
    const double now = again();
    best = std::min(best, now);
    spent += now;
  }
  return best;
}

double seconds(const Recording& recording, const Case& run) {
  return seconds(recording.statistics.integration_seconds, [&] { return record(run).statistics.integration_seconds; });
}

// Account of the left end, which does not depend on the output times.
EndAccount account(const Case& run) {
  Observers observers;
  observers.account = true;
  return simulate(resolve(run), observers).account->left;
}

struct Road {
  const char* words;
  Overrides overrides;
};

// Left end of the bar of Doyen, Ern and Piperno: free fall z = 0 of u = z - 5 t^2; the wave g(s) = 5 s^2 - 5 that the
// contact sends from s = 1 on comes back after 2 L / c = 2/3, and doubles at the free end.
double doyen(double t) {
  t = std::fmod(t, 16.0 / 3.0);
  if (t > 8.0 / 3.0) t = 16.0 / 3.0 - t;  // the motion is its own film backwards
  if (t <= 1.0) return -5.0 * t * t;
  const double k = std::floor((t - 1.0) * 1.5), s = t - 2.0 * k / 3.0;
  if (k == 0.0) return -5.0;
  return 80.0 / 9.0 * (2.0 * k - 1.0) + 2.0 * (5.0 * s * s - 5.0) - 5.0 * t * t;
}

// Error of changes, where there are as many as should be.
std::string latest(const Recording& recording, const std::vector<double>& exact) {
  if (recording.events.size() != exact.size()) return "-";
  double off = 0.0;
  for (std::size_t k = 0; k < exact.size(); ++k) off = std::max(off, std::abs(recording.events[k].time - exact[k]));
  return fmt::format("{:.1e}", off);
}

void bouncing() {
  fmt::print(
      "\nB1, bouncing.toml: ten periods; error of the left end in multiples of the drop height 5, after three periods "
      "and after ten\n\n"
      "| method | contact changes (exact 40) | their times | three periods | ten periods | seconds |\n"
      "|---|---|---|---|---|---|\n");
  std::vector<double> exact;
  for (int period = 0; period < 10; ++period)
    for (const double t : {1.0, 5.0 / 3, 11.0 / 3, 13.0 / 3}) exact.push_back(16.0 / 3 * period + t);
  const std::string rigid = "method.name=rigid", loose = "method.relative_tolerance=1e-7";
  const auto meshed = [&](const char* mass, const char* elements, Overrides more = {}) {
    more.insert(more.end(), {std::string("mesh.mass=") + mass, std::string("mesh.elements=") + elements});
    return more;
  };
  const std::vector<Road> roads = {
      {"automatic: characteristics", {automatically}},
      {"rigid, fourth_order, 200 elements", meshed("fourth_order", "200", {rigid, loose})},
      {"rigid, fourth_order, 400 elements", meshed("fourth_order", "400", {rigid, loose})},
      {"rigid, consistent, 200 elements", meshed("consistent", "200", {rigid, loose})},
      {"(2.8), fourth_order, 200 elements, dt 1e-3",
       meshed("fourth_order", "200", {"method.name=fully_discrete", "method.step=1e-3"})},
      {"(2.8), redistributed, 200 elements, dt 1e-3",
       meshed("redistributed", "200", {"method.name=fully_discrete", "method.step=1e-3"})}};
  for (const auto& [words, overrides] : roads) {
    const Case run = scene("bouncing", overrides);
    const Recording recording = record(run);
    double three = 0.0, ten = 0.0;
    for (std::size_t k = 0; k < recording.times.size(); ++k) {
      const double off = std::abs(recording.displacement(k)[0] - doyen(recording.times[k])) / 5.0;
      ten = std::max(ten, off);
      if (recording.times[k] <= 16.0) three = ten;
    }
    fmt::print("| {} | {} | {} | {:.1e} | {:.1e} | {:.2g} |\n", words, recording.events.size(),
               latest(recording, exact), three, ten, seconds(recording, run));
  }
}

void nonsmooth_modes() {
  fmt::print(
      "\nB2, nonsmooth-mode.toml and its sisters: ten periods T; largest error\n\n"
      "| T | method | contact changes (exact 21) | their times | reaction | max u(0) | energy | seconds |\n"
      "|---|---|---|---|---|---|---|---|\n");
  for (const double period : {3.1, 3.5, 3.9}) {
    const double gap = 0.1, v = gap / (2 * (period - 3)), a = 2 - period / 2;
    std::vector<double> exact = {0.0};
    for (int k = 0; k < 10; ++k) exact.insert(exact.end(), {period * k + a, period * (k + 1) - a});
    const Overrides mode = {
        fmt::format("initial.displacement=x < {0:.17g} ? {1:.17g} - {2:.17g}*x : {3:.17g} + {2:.17g}*x", a, -gap, 2 * v,
                    -gap - 4 * v * a),
        fmt::format("time.end={:.17g}", 10 * period), "method.relative_tolerance=1e-7"};
    for (const auto& [words, more] :
         {Road{"automatic: characteristics", {automatically}},
          Road{"rigid, fourth_order, 400 elements", {"method.name=rigid", "mesh.elements=400"}}}) {
      Overrides overrides = mode;
      overrides.insert(overrides.end(), more.begin(), more.end());
      const Case run = scene("nonsmooth-mode", overrides);
      const Recording recording = record(run);
      const EndAccount left = account(run);
      fmt::print("| {} | {} | {} | {} | {:.1e} | {:.1e} | {:.1e} | {:.2g} |\n", period, words, recording.events.size(),
                 latest(recording, exact), std::abs(left.peak_reaction - 2 * v) / (2 * v),
                 std::abs(left.highest - (-gap + 2 * v * (period / 2 - a))),
                 std::abs(recording.statistics.energy->final / (2 * v * v) - 1), seconds(recording, run));
    }
  }
}

void rebound() {
  fmt::print(
      "\nB3, rebound.toml: error of the contact time / of the speed of rebound\n\n"
      "| viscosity | exact | method | elements | error | seconds |\n|---|---|---|---|---|---|\n");
  struct Exact {
    double viscosity, opening, speed;
  };
  for (const auto& [viscosity, opening, speed] :
       {Exact{1.0, 1.3692116746, 0.1503140958}, Exact{0.1, 1.9124710098, 0.6507936369},
        Exact{0.01, 1.9912495450, 0.8874003786}})
    for (const auto& [words, elements] : {std::pair{"fourth_order", 30},
                                          {"fourth_order", 60},
                                          {"fourth_order", 120},
                                          {"consistent", 120},
                                          {"redistributed", 120}}) {
      const Case run =
          scene("rebound", {automatically, fmt::format("bar.viscosity={}", viscosity),
                            fmt::format("mesh.mass={}", words), fmt::format("mesh.elements={}", elements)});
      const Recording recording = record(run);
      const double off = recording.events.size() == 2 ? std::abs(recording.events[1].time - opening) : std::nan("");
      fmt::print("| {} | {:.10f} / {:.10f} | automatic: {}, {} | {} | {:.1e} / {:.1e} | {:.2g} |\n", viscosity, opening,
                 speed, name(run.method), words, elements, off, std::abs(account(run).impulse - 1.0 - speed),
                 seconds(recording, run));
    }
}

void steel() {
  struct Steel {
    const char *title, *file;
    double section, length, density, modulus, speed, gap;
    const char* others;
  };
  for (const Steel& steel :
       {Steel{"B4, impacting-bar.toml", "impacting-bar", 3.14e-4, 0.99, 7800, 210e9, 0.1, 5e-5,
              "| Siconos, theta scheme, step 2e-6 (published) | 3.82e-4 | 0.48143 | 1253.7 | 0.9940 | |\n"},
        Steel{"B6, steel-impact.toml", "steel-impact", 1.0, 0.2, 8000, 2e11, 100, 2e-3, ""}}) {
    const double c = std::sqrt(steel.modulus / steel.density), contact = 2 * steel.length / c;
    const double pushed = 2 * steel.density * steel.length * steel.speed * steel.section;
    fmt::print(
        "\n{}: touch at {:.4g}; with its section {}\n\n| method | contact lasts | impulse | mean force | energy kept | "
        "seconds |\n|---|---|---|---|---|---|\n| exact | {:.4e} | {:.5g} | {:.5g} | 1 | |\n{}",
        steel.title, steel.gap / steel.speed, steel.section, contact, pushed, pushed / contact, steel.others);
    for (const auto& [words, overrides] :
         {Road{"automatic: characteristics", {automatically}},
          Road{"rigid, fourth_order", {"method.name=rigid", "mesh.mass=fourth_order"}},
          Road{"rigid, redistributed", {"method.name=rigid", "mesh.mass=redistributed"}},
          Road{"(2.8), redistributed", {"method.name=fully_discrete", "mesh.mass=redistributed"}}}) {
      const Case run = scene(steel.file, overrides);
      const Recording recording = record(run);
      double lasts = 0.0;
      for (std::size_t k = 0; k + 1 < recording.events.size(); k += 2)
        lasts += recording.events[k + 1].time - recording.events[k].time;
      const double force = account(run).impulse * steel.section;
      fmt::print("| {}, {} elements | {:.4e} ({:+.1e}), {} changes | {:.5g} ({:+.1e}) | {:.5g} | {:.6f} | {:.2g} |\n",
                 words, run.elements, lasts, lasts / contact - 1, recording.events.size(), force, force / pushed - 1,
                 force / lasts, recording.statistics.energy->final / recording.statistics.energy->initial,
                 seconds(recording, run));
    }
  }
}

void period_three_bar() {
  fmt::print(
      "\nB5, period-3.toml to T = 12: largest L2 norm of the error of u, in multiples of the largest of u\n\n"
      "| method | 20 elements | 100 elements | seconds |\n|---|---|---|---|\n"
      "| Nitsche (published) | 0.105 | 0.0370 | |\n| Taylor and Flanagan (published) | 0.111 | 0.0394 | |\n"
      "| redistributed mass (published) | 0.126 | 0.0384 | |\n| penalty (published) | 0.307 | 0.0661 | |\n");
  for (const auto& [words, overrides] :
       {Road{"automatic: characteristics", {automatically}}, Road{"rigid, redistributed", {"method.name=rigid"}},
        Road{"rigid, fourth_order", {"method.name=rigid", "mesh.mass=fourth_order"}},
        Road{"rigid, consistent", {"method.name=rigid", "mesh.mass=consistent"}},
        Road{"(2.8), redistributed, dt = 0.002", {"method.name=fully_discrete", "method.step=0.002"}},
        Road{"(2.8), fourth_order, dt = 0.002",
             {"method.name=fully_discrete", "method.step=0.002", "mesh.mass=fourth_order"}},
        Road{"(2.8), lumped, dt = h", {"method.name=fully_discrete", "mesh.mass=lumped"}}}) {
    std::string cells;
    double cost = 0.0;
    for (const int elements : {20, 100}) {
      Overrides all = {"time.end=12", "output.every=0.002", fmt::format("mesh.elements={}", elements)};
      if (std::string(words).ends_with("dt = h")) all.push_back(fmt::format("method.step={}", 1.0 / elements));
      all.insert(all.end(), overrides.begin(), overrides.end());
      const Case run = scene("period-3", all);
      const Recording recording = record(run);
      cells += fmt::format(" {:.3g} |", error_of_period_three(recording));
      cost = seconds(recording, run);
    }
    fmt::print("| {} |{} {:.2g} |\n", words, cells, cost);
  }
}

// The paper's scheme against the limit that it approximates, by rigid with the same restitution.
void paper_panels() {
  fmt::print(
      "\nThe paper's panels: the scene's own scheme (2.8) and, of the same bar without epsilon and step, what "
      "automatic makes of it, on the scene's mass and on fourth_order\n\n"
      "| scene | (2.8): changes, seconds | rigid: method, changes, seconds | largest difference of an end | "
      "fourth_order: changes, seconds | largest difference to rigid |\n|---|---|---|---|---|---|\n");
  for (const char* panel : {"paper-both-ends", "paper-both-ends-loaded", "paper-left-end", "paper-left-end-loaded",
                            "unit-both-ends", "unit-both-ends-loaded", "unit-left-end", "unit-left-end-loaded"}) {
    const Case own = scene(panel, {});
    const Case limit = scene(panel, {automatically});
    const Case fourth = scene(panel, {automatically, "mesh.mass=fourth_order"});
    const auto times = own.output_times();
    const EndTraces scheme = trace_ends(own, times), rigid = trace_ends(limit, times), fine = trace_ends(fourth, times);
    const auto told = [&](const EndTraces& traces, const Case& run) {
      return fmt::format("{}, {:.2g}", traces.events.size(), seconds(traces.statistics.integration_seconds, [&] {
                           return trace_ends(run, times).statistics.integration_seconds;
                         }));
    };
    fmt::print("| {} | {} | {}, {} | {:.1e} | {} | {:.1e} |\n", panel, told(scheme, own), name(limit.method),
               told(rigid, limit), largest_difference(scheme, rigid), told(fine, fourth),
               largest_difference(rigid, fine));
  }
}

}  // namespace

int main(int count, char** arguments) {
  const std::vector<std::pair<std::string, std::function<void()>>> tables = {
      {"B1", bouncing}, {"B2", nonsmooth_modes},  {"B3", rebound},
      {"B4", steel},    {"B5", period_three_bar}, {"paper", paper_panels}};
  for (const auto& [word, print] : tables)
    if (count == 1 || std::find(arguments + 1, arguments + count, word) != arguments + count) print();
}

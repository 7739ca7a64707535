// Prints the tables of docs/accuracy-on-request.md. Run:
// build/release/tests/measure_requests [gallery | random COUNT SEED TIGHTEST | hard COUNT SEED]
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <functional>
#include <iterator>
#include <map>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "studies/accuracy/plan.hpp"
#include "support/processor_seconds.hpp"
#include "viscobar/case/end_traces.hpp"
#include "viscobar/case/recording.hpp"
#include "viscobar/input/scene_file.hpp"
#include "viscobar/studies/accuracy/accuracy.hpp"

namespace {

using namespace viscobar;

std::string setting(const Case& run) {
  if (run.method == MethodName::characteristics) return "characteristics";
  std::string text = fmt::format("{}, {} {}", name(run.method), run.elements, name(resolve(run).mass));
  text +=
      is_scheme(run.method) ? fmt::format(", dt {:.1e}", *run.step) : fmt::format(", {:.1e}", run.tolerance.relative);
  return is_penalised(run.method) ? text + fmt::format(", eps {:.1e}", *run.epsilon) : text;
}

struct Verdict {
  double effectivity = 0.0, over = 0.0;  // estimate / error, error / request
  bool kept = false, known = false;
  double seconds = 0.0, own_seconds = 0.0, truth_seconds = 0.0;
};

// Kinds of random scenes, with their methods.
enum class Kind { viscous, penalised, undamped, span, span_penalised };
constexpr Kind all_kinds[] = {Kind::viscous, Kind::penalised, Kind::undamped, Kind::span, Kind::span_penalised};
constexpr const char* words_of_kinds[] = {"viscous, obstacles on all sides, `rigid`", "viscous, penalised methods",
                                          "without viscosity, `rigid` and penalised methods",
                                          "span obstacle, `fully_discrete`", "span obstacle, penalised methods"};
bool has_span(Kind kind) { return kind == Kind::span || kind == Kind::span_penalised; }

// A bar with random ends, data and load, smooth in x; k/16 mostly. `above`: obstacles on either side.
std::string random_scene(std::mt19937_64& random, Kind kind, bool above) {
  const auto pick = [&](int low, int high) { return std::uniform_int_distribution<int>(low, high)(random); };
  const auto real = [&](double low, double high) { return std::uniform_real_distribution<double>(low, high)(random); };
  const double length = pick(16, 40) / 16.0, damping = std::pow(10.0, real(-2.5, 0.3));
  std::string text = fmt::format("[bar]\nlength={}\ndensity={}\nmodulus={}\nviscosity={}\n", length,
                                 pick(16, 32) / 16.0, pick(16, 32) / 16.0,
                                 kind == Kind::undamped ? 0.0
                                 : has_span(kind)       ? std::max(damping, 0.05)
                                                        : damping);
  bool obstacle = has_span(kind);
  const double sign = above && pick(0, 1) == 1 ? -1.0 : 1.0;
  for (const char* end : {"left", "right"}) {
    const int what = pick(0, 3);
    if (!has_span(kind) && (what >= 2 || (!obstacle && end[0] == 'r'))) {
      obstacle = true;
      text += fmt::format("[{}]\nkind=\"obstacle\"\ngap={}\nside=\"{}\"\n", end, pick(0, 6) / 16.0,
                          sign > 0.0 ? "below" : "above");
    } else {
      text += fmt::format("[{}]\nkind=\"{}\"\n", end, what % 2 == 0 ? "free" : "fixed");
    }
  }
  const double wave = pick(0, 8) / 16.0;
  if (has_span(kind)) {
    const char* sides[] = {"below", "above", "both"};
    text +=
        fmt::format("[span]\ngap={}\nside=\"{}\"\n", (17.0 * wave + 4.0) / 16.0 + pick(0, 4) / 16.0, sides[pick(0, 2)]);
  }
  // With `above` also data whose slope is not zero at free ends.
  const double slope = above && !has_span(kind) ? pick(0, 8) / 16.0 : 0.0;
  text += fmt::format(
      "[initial]\ndisplacement=\"{0}*({1}+{2}*cos({3}*pi*x/{4})+{5}*x)\"\n"
      "velocity=\"{0}*({6}+{7}*cos({8}*pi*x/{4})+{5}*x)\"\n",
      sign, pick(0, 4) / 16.0 + (has_span(kind) ? 0.0 : 1.0625 * wave), wave, pick(0, 4), length, slope,
      pick(-32, 8) / 16.0, pick(1, 16) / 16.0, pick(0, 4));
  if (pick(0, 1) == 1)
    text += fmt::format("[load]\nprofile=\"{}*({}+{}*cos({}*pi*x/{}))\"\nhistory=\"{}\"\n", sign, pick(-32, 16) / 16.0,
                        pick(0, 16) / 16.0, pick(0, 3), length,
                        pick(0, 1) == 0 ? "1" : fmt::format("sin({}*t)", pick(1, 64) / 8.0));
  const char* penalised[] = {"cvode", "ida", "arkode"};
  if (kind == Kind::penalised || kind == Kind::span_penalised)
    text += fmt::format("[method]\nname=\"{}\"\n", penalised[pick(0, 2)]);
  if (kind == Kind::undamped) text += fmt::format("[method]\nname=\"{}\"\n", pick(0, 1) == 0 ? "rigid" : "arkode");
  const double end = pick(8, 48) / 16.0;
  return text + fmt::format("[time]\nend={}\n[output]\nevery={}\n", end, end / pick(10, 600));
}

// Reference: the exact motion, or one far closer to it than the run.
Case truth_of(const Case& run) {
  Case truth = run;
  truth.restitution.reset();
  truth.mass = Mass::fourth_order;
  truth.elements *= 4;
  truth.tolerance = Tolerance{std::clamp(std::min(run.tolerance.relative, 1e-8) / 30.0, 1e-13, 1e-7)};
  truth.method = run.scene.bar.viscosity == 0.0 ? MethodName::characteristics : MethodName::rigid;
  if (!run.scene.span) return truth;
  truth.method = MethodName::arkode;
  truth.mass = Mass::lumped;
  truth.restitution = 0.0;
  truth.elements = std::max<std::size_t>(truth.elements, 512);
  truth.tolerance = Tolerance{1e-7};
  truth.epsilon = 1e-13 * natural_epsilon(run.scene);
  return truth;
}

Verdict judged(const AccuracyStudy& study, std::string* text) {
  Verdict verdict;
  AccuracyResult result;
  verdict.seconds = seconds_of([&] { result = solve(study); });
  verdict.own_seconds = record(result.run).statistics.integration_seconds;
  verdict.kept = result.estimate.kept;
  *text = fmt::format("{}, of {}: estimate {:.2e} ({:.1e} {:.1e} {:.1e}) request {:.2e}, order {:.3g}; {}",
                      setting(result.run), name(result.estimate.of), result.estimate.total, result.estimate.space,
                      result.estimate.penalty, result.estimate.time, *result.estimate.requested,
                      result.estimate.order.value_or(0.0), result.estimate.doubt);
  if (result.run.elements > (study.scene.scene.span ? 256u : 2100u)) return verdict;
  const Case truth = truth_of(result.run);
  const auto sample = [&](const Case& run) { return accuracy::sample_of(run, run.output_times()); };
  accuracy::Sample exact;
  verdict.truth_seconds = seconds_of([&] { exact = sample(truth); });
  // Contacts are those that matter to the error that was asked for.
  accuracy::Resolution resolution;
  resolution.impedance = truth.scene.bar.impedance();
  if (study.request.of == Goal::contact_times) resolution.duration = 0.5 * *result.estimate.requested;
  const accuracy::Sample found = sample(result.run);
  const double error = accuracy::difference(found, exact, study.request.of, resolution);
  verdict.known = true;
  verdict.effectivity = result.estimate.total / error;
  verdict.over = error / *result.estimate.requested;
  *text += fmt::format("; error {:.2e}{}", error,
                       accuracy::compare_changes(found, exact, resolution).same ? "" : " (other changes)");
  return verdict;
}

// `hard`: scenes of one of the kinds, with requests that its meshes can keep; else viscous ones with obstacles below.
void random_scenes(int count, unsigned seed, double tightest, std::optional<Kind> hard) {
  std::vector<double> effectivities, over;
  std::map<Goal, std::vector<double>> of_goals;
  int kept = 0, above = 0, far_above = 0, warned = 0, failed = 0;
  double seconds = 0.0, own = 0.0;
  for (int k = 0; k < count; ++k) {
    std::mt19937_64 random(seed * 100003u + static_cast<unsigned>(k));
    const Kind kind = hard.value_or(Kind::viscous);
    const std::string scene = random_scene(random, kind, hard.has_value());
    AccuracyStudy study;
    std::string text;
    try {
      const SceneFile file = parse_scene(scene + "[accuracy]\nerror=1\n", "random");
      study.scene = file.run;
      const Goal goals[] = {Goal::displacement, Goal::displacement, Goal::end_traces, Goal::contact_times,
                            Goal::impulse};
      study.request = {std::pow(10.0, std::uniform_real_distribution<double>(-tightest, -2.0)(random)), true,
                       goals[std::uniform_int_distribution<int>(0, 4)(random)], file.accuracy->given};
      if (hard) study.most_seconds = 5.0;
      if (has_span(kind)) study.request.of = Goal::displacement;
      study.most_elements = hard ? 1024 : 2048;
      const Verdict verdict = judged(study, &text);
      seconds += verdict.seconds;
      own += verdict.own_seconds;
      kept += verdict.kept;
      warned += !verdict.kept;
      if (verdict.known && std::isfinite(verdict.effectivity)) {
        effectivities.push_back(verdict.effectivity);
        of_goals[study.request.of].push_back(verdict.effectivity);
      }
      if (verdict.known && verdict.kept) {
        over.push_back(verdict.over);
        above += verdict.over > 1.0;
        far_above += verdict.over > 2.0;
      }
      const bool odd = verdict.kept ? verdict.over > 1.0 : true;
      if (odd || std::getenv("VERBOSE"))
        fmt::print("{} {}{}: {:.2f} s ({:.2f}, truth {:.2f}), eff {:.2g}, {}\n", k, verdict.kept ? "" : "NOT KEPT ",
                   verdict.over > 1.0 ? "ABOVE " : "", verdict.seconds, verdict.own_seconds, verdict.truth_seconds,
                   verdict.effectivity, text);
      if (odd && std::getenv("SCENES")) fmt::print("{}\n", scene);
    } catch (const std::exception& error) {
      ++failed;
      fmt::print("{} FAILED: {}\n{}\n", k, error.what(), scene);
    }
    std::fflush(stdout);
  }
  std::sort(effectivities.begin(), effectivities.end());
  const auto quantile = [&](double q) {
    return effectivities.empty()
               ? 0.0
               : effectivities[static_cast<std::size_t>(q * static_cast<double>(effectivities.size() - 1))];
  };
  for (auto& [of, all] : of_goals) {
    std::sort(all.begin(), all.end());
    fmt::print("{}: {} scenes, estimate / error: median {:.2g}, below 1 {}\n", name(of), all.size(),
               all[all.size() / 2], std::count_if(all.begin(), all.end(), [](double e) { return e < 1.0; }));
  }
  constexpr double edges[] = {0.0, 0.5, 1.0, 2.0, 3.0, 10.0, 100.0, 1e300};
  fmt::print("\n| estimate / error | scenes |\n|---|---|\n");
  for (std::size_t k = 0; k + 1 < std::size(edges); ++k)
    fmt::print("| {:g} to {:g} | {} |\n", edges[k], edges[k + 1],
               std::count_if(effectivities.begin(), effectivities.end(),
                             [&](double e) { return e >= edges[k] && e < edges[k + 1]; }));
  fmt::print(
      "\n{} scenes: kept {}, warned {}, failed {}; above the request {}, by more than 2 {}; effectivity 1 % {:.2g}, 10 % {:.2g}, median "
      "{:.2g}, 90 % {:.2g}, 99 % {:.2g}; seconds {:.1f}, of the solutions {:.1f}\n",
      count, kept, warned, failed, above, far_above, quantile(0.01), quantile(0.1), quantile(0.5), quantile(0.9),
      quantile(0.99), seconds, own);
}

/// The least of several measurements, in milliseconds: on the clock, and of the processor, all threads together.
struct Cost {
  double wall = 1e300, processor = 1e300;
};
Cost least_cost(int measurements, const std::function<void()>& work) {
  Cost least;
  for (int k = 0; k < measurements; ++k) {
    const auto began = std::chrono::steady_clock::now();
    const double processor = seconds_of(work);
    const double wall = std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count();
    least = {std::min(least.wall, 1e3 * wall), std::min(least.processor, 1e3 * processor)};
  }
  return least;
}

// By hand: the fastest of a grid of meshes and tolerances of rigid on fourth_order whose error, against a run far
// finer, is below the request. Both are runs in memory with all accounts, as record() makes them.
void gallery() {
  constexpr int measurements = 15;
  fmt::print(
      "| scene | request, of the largest value | setting | estimate / request | error / request | all runs: ms on the clock, of the processor | all others / the solution | those of the estimate / the solution | those of the search alone / all | by hand | ms | ratio on the clock, of the processor |\n");
  fmt::print("|---|---|---|---|---|---|---|---|---|---|---|---|\n");
  for (const char* file : {"rebound", "bouncing", "nonsmooth-mode", "impacting-bar", "period-3", "steel-impact",
                           "unit-both-ends", "unit-left-end-loaded"})
    for (const double share : {1e-3, 1e-6, 1e-9}) {
      AccuracyStudy study;
      // The scene as its file has it, without what it says of mesh, contact and method.
      std::vector<std::string> settings;
      for (const char* key : {"mesh.elements", "mesh.mass", "contact.epsilon", "contact.restitution", "method.name",
                              "method.step", "method.relative_tolerance", "method.absolute_tolerance", "method.start"})
        settings.push_back(fmt::format("{}=", key));
      const SceneFile scene = read_scene(fmt::format(VISCOBAR_SOURCE_DIR "/examples/scenes/{}.toml", file), settings);
      study.scene = scene.run;
      study.request.error = share;
      study.request.relative = true;
      AccuracyResult result;
      const Cost all = least_cost(measurements, [&] { result = solve(study); });
      const auto sample = [&](const Case& run) { return accuracy::sample_of(run, run.output_times()); };
      double error = result.estimate.total;
      Case hand = result.run;
      if (hand.method != MethodName::characteristics) {
        Case truth = result.run;
        truth.elements = std::min<std::size_t>(4 * truth.elements, 4096);
        truth.tolerance = Tolerance{std::max(1e-13, truth.tolerance.relative / 30.0)};
        const accuracy::Sample exact = sample(truth);
        const auto error_of = [&](const Case& run) {
          return accuracy::difference(sample(run), exact, Goal::displacement);
        };
        error = error_of(result.run);
        double best = 1e300;
        for (std::size_t elements = 8; elements <= 2 * result.run.elements; elements *= 2)
          for (double tolerance = 1e-2; tolerance >= 1e-11; tolerance /= 10.0) {
            Case run = result.run;
            run.elements = elements;
            run.tolerance = Tolerance{tolerance};
            if (error_of(run) > *result.estimate.requested) continue;
            const double time = least_cost(3, [&] { record(run); }).processor;
            if (time >= best) continue;
            best = time;
            hand = run;
          }
      }
      const double alone = least_cost(measurements, [&] { record(result.run); }).processor;
      double of_estimate = 0.0, of_search = 0.0;
      for (const ErrorEstimate::Run& made : result.estimate.runs) {
        Case run = result.run;
        run.elements = made.elements;
        if (made.setting) run.tolerance = run.tolerance.with_relative(*made.setting);
        (made.search ? of_search : of_estimate) += least_cost(measurements, [&] { sample(run); }).processor;
      }
      const Cost by_hand = least_cost(measurements, [&] { record(hand); });
      fmt::print(
          "| {} | {:.0e} | {} | {:.2g}{} | {:.2g} | {:.2f}, {:.2f} | {:.1f} | {:.1f} | {:.2f} | {} | {:.2f} | {:.1f}, {:.1f} |\n",
          file, share, setting(result.run), result.estimate.total / *result.estimate.requested,
          result.estimate.kept ? "" : " not kept", error / *result.estimate.requested, all.wall, all.processor,
          all.processor / alone - 1.0, of_estimate / alone, of_search / all.processor, setting(hand), by_hand.processor,
          all.wall / by_hand.wall, all.processor / by_hand.processor);
      std::fflush(stdout);
    }
}

}  // namespace

int main(int count, char** words) {
  const std::string what = count > 1 ? words[1] : "gallery";
  if (what == "gallery") gallery();
  const int scenes = count > 2 ? std::atoi(words[2]) : 100;
  const auto seed = count > 3 ? static_cast<unsigned>(std::atoi(words[3])) : 1u;
  if (what == "random") random_scenes(scenes, seed, count > 4 ? std::atof(words[4]) : 9.0, std::nullopt);
  for (const Kind kind : all_kinds) {
    const auto k = static_cast<std::size_t>(kind);
    if (what != "hard" && what != fmt::format("hard{}", k)) continue;
    fmt::print("\n{}\n", words_of_kinds[k]);
    constexpr double tightest[] = {8.0, 7.0, 3.5, 3.0, 3.5};
    random_scenes(scenes, seed, tightest[k], kind);
  }
}

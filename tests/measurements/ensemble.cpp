// Prints the tables of docs/ensembles.md. Run:
// build/release/tests/measure_ensemble [speed [J T] | memory BARS | errors SCENES SEED [KIND] | bars COUNT OUTPUT]
// KIND: mass, restitution, events or touching. OUTPUT: events:8, final, impulse_left, peak_left, ...; the instructions
// of a bar are counted by job_instructions.py --bars.
#include "viscobar/studies/ensemble/ensemble.hpp"

#include <fmt/format.h>
#include <sys/resource.h>

#include <algorithm>
#include <array>
#include <boost/numeric/odeint.hpp>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <random>
#include <string>
#include <vector>

#include "ensemble/random_ensemble.hpp"
#include "support/processor_seconds.hpp"
#include "viscobar/sweep/sweep.hpp"

namespace {

using namespace viscobar;

const std::vector<std::string> told = {"u_left@0.1", "impulse_left"};

double median(auto values) {
  std::ranges::nth_element(values, values.begin() + std::ssize(values) / 2);
  return static_cast<double>(values[values.size() / 2]);
}

struct Timed {
  EnsembleResult result;
  double rate = 0.0;  // bars a second of the processor
};

Timed timed(EnsembleStudy study, std::size_t bars) {
  Timed run;
  study.outputs = told;
  study.threads = 1;
  for (auto& list : study.values) list = list.first(bars);
  std::array<double, 3> rates;
  for (double& rate : rates) rate = static_cast<double>(bars) / seconds_of([&] { run.result = ensemble(study); });
  run.rate = median(rates);
  return run;
}

// By a method of its own, once: no estimate.
Timed by(const TextEnsemble& made, const std::string& method, std::size_t bars, bool lanes = false) {
  const TextEnsemble other = by_method(made, method);
  EnsembleStudy study = other.study();
  study.lanes = lanes;
  return timed(study, bars);
}

// Sixteen bars in one vector of Boost.Odeint, node by node: lumped mass, penalty, Dormand's and Prince's formulas, and
// no contact change located. Bars a second of the processor.
double by_odeint(const TextEnsemble& made, double error, std::size_t bars) {
  constexpr std::size_t side = 16;
  using State = std::vector<double>;
  const Case run = made.run(made.of(0));
  const std::size_t n = run.elements + 1;
  const double h = 1.0 / static_cast<double>(run.elements), stiffness = 10.0 / error;
  const std::vector<double> times = ensemble_output(told[0], run).times;
  const auto pack = [&](std::size_t begin) {
    const double *viscosity = &made.values[0][begin], *gap = &made.values[1][begin];
    const auto rates = [&](const State& x, State& rate, double) {
      const double *u = x.data(), *v = u + n * side;
      std::copy_n(v, n * side, rate.begin());
      double *a = &rate[n * side], *impulse = &rate[2 * n * side];
      std::array<double, side> before{};
      for (std::size_t i = 0; i < n; ++i) {
        const double of_mass = 1.0 / (h * (i == 0 || i + 1 == n ? 0.5 : 1.0));
        for (std::size_t b = 0; b < side; ++b) {
          const std::size_t k = i * side + b;
          const double stress = i + 1 < n ? (u[k + side] - u[k] + viscosity[b] * (v[k + side] - v[k])) / h : 0.0;
          a[k] = of_mass * (stress - before[b]);
          before[b] = stress;
        }
      }
      for (std::size_t b = 0; b < side; ++b) {
        const std::size_t last = (n - 1) * side + b;
        impulse[b] = stiffness * std::max(-(u[b] + gap[b]), 0.0);
        a[b] += impulse[b] * 2.0 / h;
        a[last] -= stiffness * std::max(u[last] - 0.1, 0.0) * 2.0 / h;
      }
    };
    State x((2 * n + 1) * side, 0.0);
    std::fill_n(x.begin() + static_cast<std::ptrdiff_t>(n * side), n * side, -1.0);
    namespace ode = boost::numeric::odeint;
    ode::integrate_times(ode::make_controlled<ode::runge_kutta_dopri5<State>>(error / 10.0, error / 10.0), rates, x,
                         times.begin(), times.end(), 1e-3, [](const State&, double) {});
  };
  return static_cast<double>(bars) / seconds_of([&] {
           for (std::size_t begin = 0; begin + side <= bars; begin += side) pack(begin);
         });
}

// Bars a second and core: of the ensemble, with estimates; of (2.8) in lanes with as many steps, once; of a loop over
// the library's (2.8) with as many steps, and over rigid at a tenth of the error, each with what the ensemble tells; of
// the cases of a sweep by rigid, without their files; and of Boost.Odeint at a tenth of the error. The first ratio is
// of both by (2.8), the others are to the ensemble.
void speed(std::size_t only_elements, double only_end) {
  fmt::print(
      "| J | T | error | ensemble | in lanes | steps, median | lanes once | (2.8) | ratio | rigid | ratio | sweep | ratio "
      "| odeint | ratio |\n|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|\n");
  for (const double end : {2.0, 6.0})
    for (const std::size_t elements : {10, 16, 24, 32, 50})
      for (const double error : {1e-2, 1e-3, 1e-4, 1e-6}) {
        if (only_elements > 0 && (elements != only_elements || end != only_end)) continue;
        const std::size_t bars = error < 1e-5 ? 512 : 8192, few = 128, fewest = 16;
        const TextEnsemble made = thrown_bars(elements, end, bars);
        EnsembleStudy study = made.study();
        study.error = error;
        const Timed mine = timed(study, bars);
        const double steps = median(mine.result.steps);
        const auto lanes = static_cast<double>(std::ranges::count(mine.result.ways, BarWay::lanes));
        const std::string scheme =
            fmt::format("name=\"fully_discrete\"\nstart=\"second_order\"\nstep={}\n", end / steps);
        const std::string rigid = fmt::format("name=\"rigid\"\nrelative_tolerance={}\n", error / 10.0);
        const std::string swept = by_method(made, rigid).scene;
        const double sweep = static_cast<double>(few) / seconds_of([&] {
                               for (std::size_t i = 0; i < few; ++i) {
                                 SweepCase one{i, {}};
                                 for (std::size_t k = 0; k < made.keys.size(); ++k)
                                   one.settings.push_back(std::pair(made.keys[k], SceneValue(made.values[k][i])));
                                 run_case(swept, one, {});
                               }
                             });
        const bool by_scheme = lanes > 0.5 * static_cast<double>(bars);
        const auto ratio = [&](double other) { return fmt::format("{:.0f} | {:.1f}", other, mine.rate / other); };
        std::string of_scheme = "| | ";
        if (by_scheme) {
          const double once = by(made, scheme, bars, true).rate, loop = by(made, scheme, few).rate;
          of_scheme = fmt::format("{:.0f} | {:.0f} | {:.1f}", once, loop, once / loop);
        }
        fmt::print("| {} | {} | {:.0e} | {:.0f} | {:.2f} | {} | {} | {} | {} | {} |\n", elements, end, error, mine.rate,
                   lanes / static_cast<double>(bars), steps, of_scheme, ratio(by(made, rigid, few).rate), ratio(sweep),
                   ratio(by_odeint(made, error, fewest)));
        std::fflush(stdout);
      }
}

// Bars that stay in memory, on all cores.
void memory(std::size_t bars) {
  const TextEnsemble made = thrown_bars(24, 6.0, bars);
  EnsembleStudy study = made.study();
  study.outputs = told;
  study.error = 1e-2;
  const auto began = std::chrono::steady_clock::now();
  const double seconds = seconds_of([&] { ensemble(study); });
  const std::chrono::duration<double> passed = std::chrono::steady_clock::now() - began;
  rusage use{};
  getrusage(RUSAGE_SELF, &use);
  fmt::print("{} bars, J = 24, T = 6, 1e-2: {:.1f} s, {:.0f} bars a second and core, {:.2f} GB at most\n", bars,
             passed.count(), static_cast<double>(bars) / seconds, static_cast<double>(use.ru_maxrss) / 1e6);
}

// Bars by `rigid`, one after the other, once each: the difference of two counts of bars is what the bars between take.
void by_rigid(std::size_t bars, const std::string& output) {
  const TextEnsemble made = by_method(thrown_bars(24, 6.0, bars), "name=\"rigid\"\nrelative_tolerance=1e-3\n");
  EnsembleStudy study = made.study();
  study.outputs = {output};
  study.threads = 1;
  ensemble(study);
}

// Estimates beside the errors of the same system by rigid at 1e-10: of all scenes, or of a kind of them.
void errors(std::size_t scenes, unsigned seed, const std::string& kind) {
  std::mt19937_64 random(seed);
  const auto pick = [&](int low, int high) { return std::uniform_int_distribution<int>(low, high)(random); };
  constexpr std::size_t bars = 100;
  std::size_t all = 0, above = 0, far_above = 0, lanes = 0, kept = 0, wrong = 0, not_told = 0;
  std::vector<double> ratios;
  for (std::size_t scene = 0; scene < scenes; ++scene) {
    TextEnsemble made = random_ensemble(random, bars);
    // Each bar has its first closing on the way.
    if (kind == "touching")
      std::ranges::fill(made.values[1], 0.0);
    else
      for (double& gap : made.values[1]) gap = std::max(gap, 0.02);
    if (kind == "mass" && made.scene.find("redistributed") != std::string::npos) continue;
    if (kind == "mass" && made.scene.find("mass=0.3") == std::string::npos)
      made.scene.insert(made.scene.find("[right]"), fmt::format("mass={}\n", 0.05 * pick(1, 20)));
    if (kind == "restitution") made.scene += fmt::format("[contact]\nrestitution={}\n", 0.1 * pick(1, 10));
    EnsembleStudy study = made.study();
    const double end = made.run(made.of(0)).end;
    study.outputs = {fmt::format("u_left@{}", end / 128), fmt::format("u_right@{}", end / 128)};
    const bool impulse = pick(0, 1) == 1;
    if (impulse) study.outputs.push_back("impulse_left");
    const std::size_t events = study.outputs.size();
    if (kind == "events") study.outputs.push_back("events:8");
    study.error = std::pow(10.0, -pick(1, 4));
    const EnsembleResult found = ensemble(study);
    const EnsembleResult truth = truth_of(made, study.outputs);
    for (std::size_t i = 0; i < bars; ++i) {
      if (found.status[i] > BarStatus::not_kept || truth.status[i] != BarStatus::kept) {
        ++not_told;
        continue;
      }
      double error = error_of(found, truth, i, 2);
      if (impulse && truth.values[2][i] != 0.0)
        error = std::max(error, std::abs(found.values[2][i] / truth.values[2][i] - 1.0));
      for (std::size_t k = 8 * i; kind == "events" && k < 8 * i + 8; ++k) {
        const auto change = [&](const EnsembleResult& of) {
          return std::isnan(of.values[events][k]) ? end : of.values[events][k];
        };
        error = std::max(error, std::abs(change(found) - change(truth)) / end);
      }
      if (std::isnan(error)) continue;  // it stays at 0
      ++all;
      lanes += found.ways[i] == BarWay::lanes;
      kept += found.status[i] == BarStatus::kept;
      const double ratio = found.error[i] / error;
      ratios.push_back(ratio);
      above += ratio < 1.0;
      far_above += ratio < 1.0 / 3.0;
      wrong += found.status[i] == BarStatus::kept && error > *study.error;
      if (ratio < 1.0 / 3.0 && std::getenv("VERBOSE"))
        fmt::print(
            "{}\nbar.viscosity={}\nleft.gap={}\nbar.density={}\nrequest {} estimate {} error {} by {} steps {}\n\n",
            made.scene, made.values[0][i], made.values[1][i], made.values[2][i], *study.error, found.error[i], error,
            name(found.ways[i]), found.steps[i]);
    }
  }
  std::ranges::sort(ratios);
  const auto at = [&](double share) { return ratios[static_cast<std::size_t>(share * static_cast<double>(all - 1))]; };
  fmt::print(
      "{} bars of {} scenes: {} in lanes, {} kept, of which {} are not, {} failed; the error is above its estimate in {}, above three "
      "times it in {}; estimate / error: least {:.2g}, 1 % {:.2g}, 10 % {:.2g}, median {:.2g}, 90 % {:.2g}\n",
      all, scenes, lanes, kept, wrong, not_told, above, far_above, at(0.0), at(0.01), at(0.1), at(0.5), at(0.9));
}

}  // namespace

int main(int argc, char** argv) {
  const std::string what = argc > 1 ? argv[1] : "speed";
  const auto number = [&](int k, unsigned long otherwise) {
    return argc > k ? std::strtoul(argv[k], nullptr, 10) : otherwise;
  };
  if (what == "speed") speed(number(2, 0), static_cast<double>(number(3, 6)));
  if (what == "memory") memory(number(2, 1'000'000));
  if (what == "bars") by_rigid(number(2, 64), argc > 3 ? argv[3] : "events:8");
  if (what == "errors") errors(number(2, 100), static_cast<unsigned>(number(3, 1)), argc > 4 ? argv[4] : "");
  return EXIT_SUCCESS;
}

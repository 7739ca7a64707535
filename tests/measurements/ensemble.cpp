// Prints the tables of docs/ensembles.md. Run: build/release/tests/measure_ensemble [speed | errors COUNT SEED]
#include "viscobar/studies/ensemble/ensemble.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "ensemble/random_ensemble.hpp"
#include "input/described_scene.hpp"
#include "viscobar/input/scene_file.hpp"
#include "viscobar/sweep/sweep.hpp"

namespace {

using namespace viscobar;

double seconds_of(auto&& work) {
  const std::clock_t began = std::clock();
  work();
  return static_cast<double>(std::clock() - began) / CLOCKS_PER_SEC;
}

EnsembleStudy study_of(const std::string& scene, std::vector<std::string> keys,
                       const std::vector<std::vector<double>>& values) {
  EnsembleStudy study;
  study.model = [scene, keys](std::span<const double> at) {
    std::vector<Setting> settings;
    for (std::size_t k = 0; k < keys.size(); ++k) settings.push_back(std::pair(keys[k], SceneValue(at[k])));
    return parse_scene_with(scene, "scene", settings).run;
  };
  study.keys = std::move(keys);
  for (const auto& list : values) study.values.emplace_back(list);
  return study;
}

// A viscous bar thrown at a wall, with another one behind it.
std::string thrown(std::size_t elements, double end) {
  return fmt::format(
      "[bar]\nlength=1\nviscosity=0.1\n[left]\nkind=\"obstacle\"\ngap=0.1\n[right]\nkind=\"obstacle\"\n"
      "gap=0.1\nside=\"above\"\n[initial]\nvelocity=-1\n[mesh]\nelements={}\nmass=\"fourth_order\"\n[time]\nend={}\n",
      elements, end);
}

// Bars a second and core: of the ensemble; of a loop over the library's (2.8) with as many steps, and over rigid at a
// tenth of the error, each with what the ensemble tells; and of the cases of a sweep by rigid, without their files.
void speed() {
  std::mt19937_64 random(7);
  const auto real = [&](double low, double high) { return std::uniform_real_distribution<double>(low, high)(random); };
  fmt::print(
      "| J | T | error | ensemble | in lanes | steps, median | (2.8) | rigid | sweep | to (2.8) | to sweep |\n"
      "|---|---|---|---|---|---|---|---|---|---|---|\n");
  for (const double end : {2.0, 6.0})
    for (const std::size_t elements : {10, 16, 24, 32, 50})
      for (const double error : {1e-2, 1e-3, 1e-4, 1e-6}) {
        const std::size_t bars = error < 1e-5 ? 1024 : 8192, few = 256;
        std::vector<std::vector<double>> values(2, std::vector<double>(bars));
        for (std::size_t i = 0; i < bars; ++i)
          values[0][i] = std::pow(10.0, real(-2.0, 0.0)), values[1][i] = real(0.05, 0.3);
        const std::vector<std::string> keys = {"bar.viscosity", "left.gap"};
        const std::string scene = thrown(elements, end);
        const auto rate = [&](EnsembleStudy study, std::size_t count, EnsembleResult& result) {
          study.outputs = {"u_left@0.1", "impulse_left"};
          study.threads = 1;
          for (auto& list : study.values) list = list.first(count);
          return static_cast<double>(count) / seconds_of([&] { result = ensemble(study); });
        };
        EnsembleResult result, other;
        EnsembleStudy study = study_of(scene, keys, values);
        study.error = error;
        const double mine = rate(study, bars, result);
        std::vector<std::size_t> steps = result.steps;
        std::ranges::nth_element(steps, steps.begin() + static_cast<std::ptrdiff_t>(bars / 2));
        const auto lanes = std::ranges::count(result.ways, BarWay::lanes);
        const auto alone = [&](const std::string& method) {
          EnsembleStudy loop = study_of(scene + "[method]\n" + method, keys, values);
          loop.lanes = false;
          return rate(loop, few, other);
        };
        const double scheme = alone(fmt::format("name=\"fully_discrete\"\nstart=\"second_order\"\nstep={}\n",
                                                end / static_cast<double>(std::max<std::size_t>(steps[bars / 2], 16))));
        const std::string by_rigid = fmt::format("name=\"rigid\"\nrelative_tolerance={}\n", error / 10.0);
        const double rigid = alone(by_rigid);
        const double sweep =
            static_cast<double>(few) / seconds_of([&] {
              for (std::size_t i = 0; i < few; ++i) {
                SweepCase one{
                    i, {std::pair(keys[0], SceneValue(values[0][i])), std::pair(keys[1], SceneValue(values[1][i]))}};
                run_case(scene + "[method]\n" + by_rigid, one, {});
              }
            });
        fmt::print("| {} | {} | {:.0e} | {:.0f} | {:.2f} | {} | {:.0f} | {:.0f} | {:.0f} | {:.1f} | {:.1f} |\n",
                   elements, end, error, mine, static_cast<double>(lanes) / static_cast<double>(bars), steps[bars / 2],
                   scheme, rigid, sweep, mine / scheme, mine / sweep);
        std::fflush(stdout);
      }
}

// The error of (2.8) by its steps, beside rigid at 1e-10.
void orders(std::size_t bars) {
  std::mt19937_64 random(7);
  const auto real = [&](double low, double high) { return std::uniform_real_distribution<double>(low, high)(random); };
  std::vector<double> viscosity(bars), gap(bars);
  for (std::size_t i = 0; i < bars; ++i) viscosity[i] = std::pow(10.0, real(-2.0, 0.0)), gap[i] = real(0.05, 0.3);
  const std::vector<std::vector<double>> values = {viscosity, gap};
  const double end = 6.0;
  const auto run = [&](const std::string& method, double& seconds) {
    EnsembleStudy study = study_of(thrown(24, end) + "[method]\n" + method, {"bar.viscosity", "left.gap"}, values);
    study.outputs = {"u_left@0.1", "impulse_left"};
    study.threads = 1;
    EnsembleResult result;
    seconds = seconds_of([&] { result = ensemble(study); });
    return result;
  };
  double seconds = 0.0;
  const EnsembleResult truth = run("name=\"rigid\"\nrelative_tolerance=1e-10\n", seconds);
  fmt::print("rigid at 1e-10: {:.0f} bars a second\n", static_cast<double>(bars) / seconds);
  std::vector<double> before;
  for (int level = 4; level < 14; ++level) {
    const EnsembleResult found =
        run(fmt::format("name=\"fully_discrete\"\nstart=\"second_order\"\nstep={}\n", end / (1 << level)), seconds);
    std::vector<double> errors, of_impulse, extrapolated;
    const std::size_t width = found.outputs[0].width();
    for (std::size_t i = 0; i < bars; ++i) {
      double error = 0.0, size = 0.0, better = 0.0;
      for (std::size_t k = 0; k < width; ++k) {
        error = std::max(error, std::abs(found.values[0][i * width + k] - truth.values[0][i * width + k]));
        size = std::max(size, std::abs(truth.values[0][i * width + k]));
        if (!before.empty())
          better = std::max(better, std::abs((4.0 * found.values[0][i * width + k] - before[i * width + k]) / 3.0 -
                                             truth.values[0][i * width + k]));
      }
      errors.push_back(error / size);
      extrapolated.push_back(better / size);
      of_impulse.push_back(std::abs(found.values[1][i] / truth.values[1][i] - 1.0));
    }
    before = found.values[0];
    std::ranges::sort(errors);
    std::ranges::sort(extrapolated);
    std::ranges::sort(of_impulse);
    fmt::print(
        "{} steps: u median {:.1e}, 90 % {:.1e}; extrapolated {:.1e}, {:.1e}; impulse {:.1e}, {:.1e}; {:.0f} bars a second, {:.2f} in lanes\n",
        1 << level, errors[bars / 2], errors[bars * 9 / 10], extrapolated[bars / 2], extrapolated[bars * 9 / 10],
        of_impulse[bars / 2], of_impulse[bars * 9 / 10], static_cast<double>(bars) / seconds,
        static_cast<double>(std::ranges::count(found.ways, BarWay::lanes)) / static_cast<double>(bars));
    std::fflush(stdout);
  }
}

// Estimates beside the errors of the same system by rigid at 1e-10.
void errors(std::size_t scenes, unsigned seed) {
  std::mt19937_64 random(seed);
  const auto pick = [&](int low, int high) { return std::uniform_int_distribution<int>(low, high)(random); };
  constexpr std::size_t bars = 100;
  std::size_t all = 0, above = 0, far_above = 0, lanes = 0, kept = 0, not_told = 0;
  std::vector<double> ratios;
  for (std::size_t scene = 0; scene < scenes; ++scene) {
    TextEnsemble made = random_ensemble(random, bars);
    // Each bar has its first closing on the way.
    for (double& gap : made.values[1]) gap = std::max(gap, 0.02);
    EnsembleStudy study = made.study();
    const double end = made.run(made.of(0)).end;
    study.outputs = {fmt::format("u_left@{}", end / 128), fmt::format("u_right@{}", end / 128)};
    const bool impulse = pick(0, 1) == 1;
    if (impulse) study.outputs.push_back("impulse_left");
    study.error = std::pow(10.0, -pick(1, 4));
    const EnsembleResult found = ensemble(study);
    TextEnsemble by_rigid = made;
    by_rigid.scene += "[method]\nname=\"rigid\"\nrelative_tolerance=1e-10\n";
    EnsembleStudy exact = by_rigid.study();
    exact.outputs = study.outputs;
    const EnsembleResult truth = ensemble(exact);
    const std::size_t width = found.outputs[0].width();
    for (std::size_t i = 0; i < bars; ++i) {
      if (found.status[i] > BarStatus::not_kept || truth.status[i] != BarStatus::kept) {
        ++not_told;
        continue;
      }
      double error = 0.0, size = 0.0;
      for (std::size_t o = 0; o < 2; ++o)
        for (std::size_t k = i * width; k < (i + 1) * width; ++k) {
          error = std::max(error, std::abs(found.values[o][k] - truth.values[o][k]));
          size = std::max(size, std::abs(truth.values[o][k]));
        }
      error /= size;
      if (impulse && truth.values[2][i] != 0.0)
        error = std::max(error, std::abs(found.values[2][i] / truth.values[2][i] - 1.0));
      ++all;
      lanes += found.ways[i] == BarWay::lanes;
      kept += found.status[i] == BarStatus::kept;
      const double ratio = found.error[i] / error;
      ratios.push_back(ratio);
      above += ratio < 1.0;
      far_above += ratio < 1.0 / 3.0;
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
      "{} bars of {} scenes: {} in lanes, {} kept, {} failed; the error is above its estimate in {}, above three "
      "times it in {}; estimate / error: least {:.2g}, 1 % {:.2g}, 10 % {:.2g}, median {:.2g}, 90 % {:.2g}\n",
      all, scenes, lanes, kept, not_told, above, far_above, at(0.0), at(0.01), at(0.1), at(0.5), at(0.9));
}

}  // namespace

int main(int argc, char** argv) {
  const std::string what = argc > 1 ? argv[1] : "speed";
  if (what == "speed") speed();
  if (what == "orders") orders(512);
  if (what == "errors")
    errors(argc > 2 ? std::strtoul(argv[2], nullptr, 10) : 100,
           argc > 3 ? static_cast<unsigned>(std::strtoul(argv[3], nullptr, 10)) : 1);
  return EXIT_SUCCESS;
}

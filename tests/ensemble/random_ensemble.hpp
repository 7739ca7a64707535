#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "input/described_scene.hpp"
#include "viscobar/studies/ensemble/ensemble.hpp"

namespace viscobar {

/// An ensemble of a scene file and values of its keys.
struct TextEnsemble {
  std::string scene;
  std::vector<std::string> keys;
  std::vector<std::vector<double>> values;

  std::vector<double> of(std::size_t bar) const {
    std::vector<double> all;
    for (const auto& list : values) all.push_back(list.size() == 1 ? list[0] : list[bar]);
    return all;
  }
  Case run(std::span<const double> at) const {
    std::vector<Setting> settings;
    for (std::size_t k = 0; k < keys.size(); ++k) settings.push_back(std::pair(keys[k], SceneValue(at[k])));
    return parse_scene_with(scene, "scene", settings).run;
  }
  /// Refers to this, which outlives it.
  EnsembleStudy study() const {
    EnsembleStudy made;
    made.model = [this](std::span<const double> at) { return run(at); };
    made.keys = keys;
    for (const auto& list : values) made.values.emplace_back(list);
    return made;
  }
};

/// A viscous bar thrown at a wall, with another one behind it.
inline std::string thrown_between_walls(std::size_t elements, double end) {
  return fmt::format(
      "[bar]\nlength=1\nviscosity=0.1\n[left]\nkind=\"obstacle\"\ngap=0.1\n[right]\nkind=\"obstacle\"\n"
      "gap=0.1\nside=\"above\"\n[initial]\nvelocity=-1\n[mesh]\nelements={}\nmass=\"fourth_order\"\n[time]\nend={}\n",
      elements, end);
}

/// Bars of it that differ in viscosity, 0.01 to 1, and gap, 0.05 to 0.3.
inline TextEnsemble thrown_bars(std::size_t elements, double end, std::size_t bars) {
  std::mt19937_64 random(7);
  TextEnsemble made{thrown_between_walls(elements, end), {"bar.viscosity", "left.gap"}, {{}, {}}};
  for (std::size_t i = 0; i < bars; ++i) {
    made.values[0].push_back(std::pow(10.0, std::uniform_real_distribution<double>(-2.0, 0.0)(random)));
    made.values[1].push_back(std::uniform_real_distribution<double>(0.05, 0.3)(random));
  }
  return made;
}

/// The same bars by another method, alone: `method` are lines of its table.
inline TextEnsemble by_method(TextEnsemble made, const std::string& method) {
  made.scene += "[method]\n" + method;
  return made;
}

/// Those outputs of the same bars by `rigid` at 1e-10.
inline EnsembleResult truth_of(const TextEnsemble& made, const std::vector<std::string>& outputs) {
  const TextEnsemble rigid = by_method(made, "name=\"rigid\"\nrelative_tolerance=1e-10\n");
  EnsembleStudy exact = rigid.study();
  exact.outputs = outputs;
  return ensemble(exact);
}

/// The largest error of the first outputs of a bar, as a share of the largest value of the truth's.
inline double error_of(const EnsembleResult& found, const EnsembleResult& truth, std::size_t bar, std::size_t outputs) {
  double error = 0.0, size = 0.0;
  for (std::size_t o = 0; o < outputs; ++o) {
    const std::size_t width = truth.outputs[o].width();
    for (std::size_t k = bar * width; k < (bar + 1) * width; ++k) {
      error = std::max(error, std::abs(found.values[o][k] - truth.values[o][k]));
      size = std::max(size, std::abs(truth.values[o][k]));
    }
  }
  return error / size;
}

/// Bars of any section and mesh with obstacles, walls, springs and loads, thrown at the left one.
inline TextEnsemble random_ensemble(std::mt19937_64& random, std::size_t bars) {
  const auto real = [&](double low, double high) { return std::uniform_real_distribution<double>(low, high)(random); };
  const auto pick = [&](int low, int high) { return std::uniform_int_distribution<int>(low, high)(random); };
  TextEnsemble made;
  const char* masses[] = {"fourth_order", "fourth_order", "consistent", "redistributed"};
  const char* mass = masses[pick(0, 3)];
  const bool mounts = mass != masses[3];
  const char* sections[] = {"", "", "section=\"1+0.5*x\"\n", "section=\"exp(-x)+max(0,x-0.4)\"\n"};
  made.scene = fmt::format("[bar]\nlength=1\nviscosity=0.1\n{}[mesh]\nelements={}\nmass=\"{}\"\n{}",
                           sections[pick(0, 3)], pick(8, 40), mass, pick(0, 3) == 0 ? "grading=4\n" : "");
  const int ends = pick(0, 4);
  made.scene += fmt::format("[left]\nkind=\"obstacle\"\ngap=0.1\n{}", mounts && pick(0, 3) == 0 ? "mass=0.3\n" : "");
  made.scene += ends == 0   ? "[right]\nkind=\"free\"\n"
                : ends == 1 ? "[right]\nkind=\"obstacle\"\ngap=0.2\nside=\"above\"\n"
                : ends == 2 ? "[right]\nkind=\"fixed\"\n"
                : ends == 3 ? "[right]\nkind=\"free\"\nstiffness=2\ndashpot=0.1\n"
                            : "[right]\nkind=\"free\"\nforce=\"0.3*sin(2*t)\"\n";
  const char* shapes[] = {"-1", "-x/2-0.5", "-cos(pi*x)", "-1+0.5*sin(3*x)"};
  made.scene += fmt::format("[initial]\nvelocity=\"{}\"\n", ends == 2 ? "-cos(pi*x/2)" : shapes[pick(0, 3)]);
  const int load = pick(0, 4);
  if (load == 0) made.scene += "[load]\ndensity=-0.5\n";
  if (load == 1) made.scene += "[load]\nprofile=\"1+x\"\nhistory=\"sin(3*t)\"\n";
  made.scene += fmt::format("[time]\nend={}\n", real(1.0, 6.0));
  made.keys = {"bar.viscosity", "left.gap", "bar.density"};
  made.values.assign(3, std::vector<double>(bars));
  for (std::size_t i = 0; i < bars; ++i) {
    made.values[0][i] = std::pow(10.0, real(-2.5, 0.0));
    made.values[1][i] = pick(0, 5) == 0 ? 0.0 : real(0.0, 0.4);
    made.values[2][i] = real(0.5, 2.0);
  }
  return made;
}

}  // namespace viscobar

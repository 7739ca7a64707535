// The method `characteristics` on thousands of random bars: against a difference scheme at Courant number 1 and in a
// mirror, energy, how well the data are represented, and what it takes; and how long bars in closed form take. Run:
//     cmake --build --preset release --target measure_characteristics && build/release/tests/measure_characteristics
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "characteristics/cell_waves.hpp"
#include "characteristics/followed.hpp"
#include "characteristics/random_bar.hpp"

namespace {

using namespace viscobar;
using oracle::CellWaves;
using oracle::RandomBar;

struct Worst {
  double value = 0.0;
  std::uint32_t seed = 0;
  void see(double candidate, std::uint32_t of) {
    if (candidate > value) value = candidate, seed = of;
  }
};

void random_bars(RandomBar::Loads loads, std::uint32_t count, std::size_t cells) {
  Worst off, balance, mirrored, represented, seconds;
  std::size_t events = 0, passages = 0, failures = 0;
  double all_seconds = 0.0;
  for (std::uint32_t seed = 0; seed < count; ++seed) {
    RandomBar random(seed + 10'000);
    const Scene scene = random.scene(loads);
    const std::size_t way = static_cast<std::size_t>(1 + random.one_of(12)), every = cells / 20, steps = cells * way;
    try {
      const CellWaves scheme(scene, cells, steps);
      std::vector<double> times;
      for (std::size_t k = 0; k <= steps; k += every) times.push_back(scheme.step * static_cast<double>(k));
      const Followed run = followed(scene, times, 20);
      const double size = largest(run);
      for (std::size_t k = 0; k < times.size(); ++k) {
        off.see(std::abs(run.u[k].front() - scheme.left[k * every]) / size, seed);
        off.see(std::abs(run.u[k].back() - scheme.right[k * every]) / size, seed);
      }
      for (std::size_t j = 0; j <= 20; ++j) off.see(std::abs(run.u.back()[j] - scheme.nodes[j * every]) / size, seed);
      const EnergyAccount& energy = *run.statistics.energy;
      balance.see(std::abs(energy.balance_error()) / largest_energy(energy), seed);
      represented.see(run.statistics.representation->error / run.statistics.representation->rounding, seed);
      seconds.see(run.statistics.integration_seconds, seed);
      all_seconds += run.statistics.integration_seconds;
      events += run.events.size();
      passages += way;
      if (loads != RandomBar::Loads::none) continue;
      Scene mirror = scene;
      std::swap(mirror.left, mirror.right);
      mirror.displacement = [&](double x) { return scene.displacement(scene.bar.length - x); };
      mirror.velocity = [&](double x) { return scene.velocity(scene.bar.length - x); };
      const Followed other = followed(mirror, times, 20);
      for (std::size_t k = 0; k < times.size(); ++k)
        for (std::size_t j = 0; j <= 20; ++j) mirrored.see(std::abs(run.u[k][j] - other.u[k][20 - j]) / size, seed);
    } catch (const std::exception& error) {
      ++failures;
      fmt::print("seed {}: {}\n", seed, error.what());
    }
  }
  fmt::print("{} bars {}, {} passages, {} contact changes, {} failures, {:.2g} s in all\n", count,
             loads == RandomBar::Loads::none ? "without load" : "with any load", passages, events, failures,
             all_seconds);
  const auto row = [](const char* what, const Worst& worst) {
    fmt::print("  {:<52} {:.3g} (seed {})\n", what, worst.value, worst.seed);
  };
  row(fmt::format("off the difference scheme, times its {} cells", cells).c_str(),
      {off.value * static_cast<double>(cells), off.seed});
  row("energy balance", balance);
  if (loads == RandomBar::Loads::none) row("off the mirror image", mirrored);
  row("error of representation, in roundings", represented);
  row("seconds", seconds);
}

void bouncing(double periods, std::size_t outputs) {
  Scene scene;
  scene.bar = {10.0, 1.0, 900.0, 0.0};
  scene.left = Obstacle{5.0};
  scene.displacement = scene.velocity = [](double) { return 0.0; };
  scene.load = SteadyLoad{[](double) { return -10.0; }};
  const Followed run = followed(scene, equal_times(periods * 16.0 / 3.0, outputs), 100);
  double off = 0.0;
  for (std::size_t k = 0; k < run.events.size(); ++k) {
    constexpr double changes[] = {1.0, 5.0 / 3.0, 11.0 / 3.0, 13.0 / 3.0};
    off = std::max(off, std::abs(run.events[k].time - 16.0 / 3.0 * static_cast<double>(k / 4) - changes[k % 4]));
  }
  fmt::print("bouncing bar, {} periods: {} changes, times off by {:.2g}, at most {} coefficients, {:.3g} s\n", periods,
             run.events.size(), off, run.statistics.unknowns, run.statistics.integration_seconds);
}

// Bars that are thrown down again and again, and break their waves at each contact.
void many_contacts(double end) {
  Scene scene;
  scene.left = scene.right = Obstacle{0.5};
  scene.displacement = [](double x) { return 0.3 * x; };
  scene.velocity = [](double x) { return std::cos(3.0 * x); };
  scene.load = SteadyLoad{[](double) { return -1.0; }};
  const Followed run = followed(scene, {0.0, end}, 10);
  fmt::print(
      "bar between two obstacles, {} passages: {} changes, at most {} coefficients, balance {:.2g}, error {:.2g} in "
      "roundings, {:.3g} s\n",
      end, run.events.size(), run.statistics.unknowns,
      run.statistics.energy->balance_error() / largest_energy(*run.statistics.energy),
      run.statistics.representation->error / run.statistics.representation->rounding,
      run.statistics.integration_seconds);
}

// How a bar that is thrown at its obstacle breaks its waves, one row for each set of ends and load.
void growth() {
  const SteadyLoad weight{[](double) { return -1.0; }}, skew{[](double x) { return -1.0 - x * x; }};
  struct Row {
    const char* words;
    EndCondition right;
    std::optional<Load> load;
  };
  for (const Row& row :
       {Row{"obstacle and free", Free{}, std::nullopt}, Row{"obstacle and free, -1", Free{}, weight},
        Row{"obstacle and fixed", Fixed{}, std::nullopt}, Row{"obstacle and free, -1 - x^2", Free{}, skew},
        Row{"two obstacles, -1", Obstacle{0.1}, weight}}) {
    Scene scene;
    scene.left = Obstacle{0.1};
    scene.right = row.right;
    scene.load = row.load;
    const bool fixed = is_fixed(row.right);
    scene.displacement = [](double x) { return 0.4 * x * (1 - x); };
    scene.velocity = [fixed](double x) { return (fixed ? 1 - x : 1.0) * (-0.5 - x); };
    std::string cells;
    for (const double end : {10.0, 100.0, 1000.0, 3000.0}) try {
        const Statistics done = followed(scene, {0.0, end}, 1).statistics;
        cells += fmt::format(" {} ({} coefficients), {:.2g} s |", done.events, done.unknowns, done.integration_seconds);
      } catch (const IntegrationError& error) {
        cells += fmt::format(" stops at {:.4g}, {:.2g} s |", error.statistics.reached_time,
                             error.statistics.integration_seconds);
      }
    fmt::print("| {} |{}\n", row.words, cells);
  }
}

}  // namespace

int main() {
  std::setvbuf(stdout, nullptr, _IOLBF, 0);
  bouncing(10.0, 1600);
  bouncing(10.0, 1);
  bouncing(3000.0, 1);
  for (const double end : {50.0, 100.0, 110.0}) many_contacts(end);
  growth();
  random_bars(RandomBar::Loads::none, 3000, 2000);
  random_bars(RandomBar::Loads::any, 1000, 400);
}

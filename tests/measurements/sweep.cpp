// The tables of docs/internals/sweep-balance.md: how well costs of cases are foreseen, how long a row takes to write,
// and how the measured costs spread over parts of a sweep. Run in the project's folder:
//
//     build/release/tests/measure_sweep examples/sweeps/cost.toml
#include "viscobar/sweep/sweep.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <numeric>
#include <random>
#include <vector>

#include "input/described_scene.hpp"
#include "support/processor_seconds.hpp"
#include "sweep/sweep_table.hpp"

namespace {

using namespace viscobar;

double sum(const std::vector<double>& values) { return std::accumulate(values.begin(), values.end(), 0.0); }

std::vector<double> ranks(const std::vector<double>& values) {
  std::vector<std::size_t> order(values.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return values[a] < values[b]; });
  std::vector<double> rank(values.size());
  for (std::size_t k = 0; k < order.size(); ++k) rank[order[k]] = static_cast<double>(k);
  return rank;
}

/// Correlation of the ranks [Spearman]: 1 when the order is right.
double rank_correlation(const std::vector<double>& a, const std::vector<double>& b) {
  const std::vector<double> x = ranks(a), y = ranks(b);
  const double mean = 0.5 * static_cast<double>(a.size() - 1);
  double xy = 0.0, xx = 0.0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    xy += (x[i] - mean) * (y[i] - mean);
    xx += (x[i] - mean) * (x[i] - mean);
  }
  return xy / xx;
}

double quantile(std::vector<double> values, double share) {
  std::sort(values.begin(), values.end());
  return values[static_cast<std::size_t>(share * static_cast<double>(values.size() - 1))];
}

void print_foresight(const char* what, const std::vector<double>& estimated, const std::vector<double>& measured) {
  std::vector<double> ratio;
  for (std::size_t i = 0; i < measured.size(); ++i) ratio.push_back(estimated[i] / measured[i]);
  const auto [smallest, largest] = std::minmax_element(measured.begin(), measured.end());
  fmt::print("| {} | {} | {:.2g} to {:.2g} s | {:.2f} | {:.2f} | {:.2f} | {:.2f} |\n", what, measured.size(), *smallest,
             *largest, quantile(ratio, 0.1), quantile(ratio, 0.5), quantile(ratio, 0.9),
             rank_correlation(estimated, measured));
}

/// Shares of the time of parts on as many machines that the dearest of them leaves to the others: cases drawn from
/// those measured, like ones side by side, as a grid has them.
void print_parts(const std::vector<double>& measured, std::size_t cases) {
  std::mt19937_64 random(1);
  std::uniform_int_distribution<std::size_t> draw(0, measured.size() - 1);
  std::vector<double> costs(cases);
  for (double& cost : costs) cost = measured[draw(random)];
  std::ranges::sort(costs);
  fmt::print("\n{} cases\n\n| parts | mean time / longest, shuffled | one behind the other |\n|---|---|---|\n", cases);
  for (const std::size_t parts : {4, 16, 64, 256}) {
    std::vector<double> shuffled(parts, 0.0), in_order(parts, 0.0);
    for (std::size_t k = 0; k < parts; ++k) {
      const std::vector<bool> own = SweepPart{k + 1, parts}.own(cases);
      for (std::size_t i = 0; i < cases; ++i)
        if (own[i]) shuffled[k] += costs[i];
    }
    for (std::size_t i = 0; i < cases; ++i) in_order[i * parts / cases] += costs[i];
    const auto share = [&](const std::vector<double>& load) {
      return sum(costs) / (static_cast<double>(parts) * std::ranges::max(load));
    };
    fmt::print("| {} | {:.2f} | {:.2f} |\n", parts, share(shuffled), share(in_order));
  }
}

/// Seconds for a row: unpacked, in the table, safe.
double time_to_write(const SweepFile& sweep, const SweepRow& row) {
  const auto file = std::filesystem::temp_directory_path() / "viscobar-measure-sweep.h5";
  std::filesystem::remove(file);
  constexpr std::size_t repeat = 5000;
  SweepTable table(file, sweep.plan, sweep.identity());
  const double start = processor_seconds();
  SweepRow one = row;
  for (std::size_t k = 0; k < repeat; ++k) {
    one.index = k % sweep.plan.size();
    table.write(one);
  }
  const double seconds = (processor_seconds() - start) / repeat;
  table.close();
  std::filesystem::remove(file);
  return seconds;
}

}  // namespace

int main(int argc, char** argv) {
  const SweepFile sweep = read_sweep(argc > 1 ? argv[1] : "examples/sweeps/cost.toml");
  const std::vector<double> costs = plan_cases(sweep, 1);
  std::vector<double> estimated, measured;
  std::vector<MethodName> methods;
  SweepRow last;
  for (std::size_t i = 0; i < sweep.plan.size(); ++i) {
    const SweepCase one = case_of(sweep, i);
    const MethodName method = parse_scene_with(sweep.scene_text, "scene", one.settings).run.method;
    const double before = processor_seconds();
    last = run_case(sweep.scene_text, one).value();
    measured.push_back(processor_seconds() - before);
    if (!last.completed) fmt::print(stderr, "case {}: {}\n", i, last.error);
    estimated.push_back(costs[i]);
    methods.push_back(method);
  }
  fmt::print("| cases | number | measured | estimate / measured: 10 % | median | 90 % | rank correlation |\n");
  fmt::print("|---|---|---|---|---|---|---|\n");
  for (const MethodName method : all_methods) {
    std::vector<double> e, m;
    for (std::size_t i = 0; i < methods.size(); ++i)
      if (methods[i] == method) e.push_back(estimated[i]), m.push_back(measured[i]);
    if (!e.empty()) print_foresight(std::string(name(method)).c_str(), e, m);
  }
  print_foresight("all", estimated, measured);

  fmt::print("\na row takes {:.2g} s to write\n", time_to_write(sweep, last));
  print_parts(measured, 20'000);
}

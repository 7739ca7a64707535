// The tables of docs/internals/sweep-balance.md: how well costs of cases are foreseen, what the manager needs for a
// row, and, by simulation with the measured costs, how a sweep spreads over up to 10,000 workers. Run in the project's
// folder: build/release/tests/measure_sweep examples/sweeps/cost.toml
#include "viscobar/sweep/sweep.hpp"

#include <fmt/format.h>
#include <time.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <functional>
#include <numeric>
#include <queue>
#include <random>
#include <vector>

#include "input/described_scene.hpp"
#include "sweep/sweep_table.hpp"

namespace {

using namespace viscobar;

/// Processor time of this process: other load of the machine counts less than in wall-clock time.
double processor_seconds() {
  timespec now{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

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

/// Seconds of a manager for a case: to plan it, which the workers do before all begins, to send it, and to write its
/// row.
struct Manager {
  double plan, dispatch, write, latency;
};

/// Seconds until the last case is done, as src/sweep/ranks.cpp works: a worker reports to the manager, which serves one
/// after another, sends the next case first and then writes the row.
double makespan(const std::vector<double>& costs, const std::vector<std::size_t>& order, std::size_t workers,
                const Manager& manager) {
  std::priority_queue<double, std::vector<double>, std::greater<>> reports;  // their arrivals
  for (std::size_t k = 0; k < workers; ++k) reports.push(0.0);
  // The workers plan together.
  double manager_free =
      (manager.plan / static_cast<double>(workers) + manager.dispatch) * static_cast<double>(costs.size());
  double end = 0.0;
  std::size_t served = 0;
  for (const std::size_t i : order) {
    const double begin = std::max(reports.top(), manager_free);
    reports.pop();
    const bool has_row = served++ >= workers;  // the first time a worker has none
    manager_free = begin + manager.dispatch + (has_row ? manager.write : 0.0);
    const double done = begin + manager.dispatch + manager.latency + costs[i];
    reports.push(done + manager.latency);
    end = std::max(end, done);
  }
  return end;
}

/// The cases dealt out beforehand, the same number to each.
double static_makespan(const std::vector<double>& costs, std::size_t workers) {
  std::vector<double> load(workers, 0.0);
  for (std::size_t i = 0; i < costs.size(); ++i) load[i * workers / costs.size()] += costs[i];
  return *std::max_element(load.begin(), load.end());
}

void print_scaling(const std::vector<double>& estimated, const std::vector<double>& measured, double scale,
                   std::size_t cases, const Manager& manager) {
  std::mt19937_64 random(1);
  std::uniform_int_distribution<std::size_t> draw(0, measured.size() - 1);
  std::vector<std::size_t> drawn(cases), in_order(cases);
  for (std::size_t& from : drawn) from = draw(random);
  // A grid has like cases side by side.
  std::sort(drawn.begin(), drawn.end(), [&](std::size_t a, std::size_t b) { return measured[a] < measured[b]; });
  std::iota(in_order.begin(), in_order.end(), std::size_t{0});
  std::vector<double> costs, guesses;
  for (const std::size_t from : drawn) {
    costs.push_back(scale * measured[from]);
    guesses.push_back(scale * estimated[from]);
  }
  const std::vector<std::size_t> by_estimate = dispatch_order(guesses), by_cost = dispatch_order(costs);
  const double total = sum(costs), longest = costs.back();
  fmt::print("\n{} cases, {:.3g} s on average, {:.3g} s the longest, {:.3g} s together\n\n", cases,
             total / static_cast<double>(cases), longest, total);
  fmt::print("| workers | most that can be | by estimate | by exact cost | cheapest first | dealt out beforehand |\n");
  fmt::print("|---|---|---|---|---|---|\n");
  for (const std::size_t workers : {1, 2, 10, 63, 100, 1000, 3000, 10000}) {
    const double m = static_cast<double>(workers);
    const auto efficiency = [&](double span) { return fmt::format("{:.1f} %", 100.0 * total / (m * span)); };
    fmt::print("| {} | {} | {} | {} | {} | {} |\n", workers, efficiency(std::max(total / m, longest)),
               efficiency(makespan(costs, by_estimate, workers, manager)),
               efficiency(makespan(costs, by_cost, workers, manager)),
               efficiency(makespan(costs, in_order, workers, manager)), efficiency(static_makespan(costs, workers)));
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

double time_to_dispatch(const SweepFile& sweep) {
  constexpr std::size_t repeat = 20000;
  std::size_t bytes = 0;
  const double start = processor_seconds();
  for (std::size_t k = 0; k < repeat; ++k) bytes += case_of(sweep, k % sweep.plan.size()).settings.size();
  return (processor_seconds() - start) / repeat + (bytes == 0 ? 1.0 : 0.0);
}

}  // namespace

int main(int argc, char** argv) {
  const SweepFile sweep = read_sweep(argc > 1 ? argv[1] : "examples/sweeps/cost.toml");
  const double before_planning = processor_seconds();
  const std::vector<double> costs = plan_cases(sweep, 1);
  const double plan_seconds = (processor_seconds() - before_planning) / static_cast<double>(sweep.plan.size());
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

  const Manager manager{plan_seconds, time_to_dispatch(sweep), time_to_write(sweep, last), 5e-6};
  fmt::print(
      "\nmanager, each case: {:.2g} s to plan, {:.2g} s to send, {:.2g} s to write; a message takes {:.2g} s "
      "(assumed)\n",
      manager.plan, manager.dispatch, manager.write, manager.latency);
  print_scaling(estimated, measured, 1.0, 200000, manager);
  print_scaling(estimated, measured, 100.0, 200000, manager);
}

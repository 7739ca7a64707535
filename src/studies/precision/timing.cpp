#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <ctime>
#include <utility>
#include <vector>

#include "run/stopwatch.hpp"
#include "studies/precision/references.hpp"

namespace viscobar::precision {

namespace {

/// Enough runs for a median that interruptions do not move; a long run averages over them by itself.
std::size_t runs_for(const PrecisionStudy& study, double seconds) {
  if (study.repeat > 0) return study.repeat;
  if (seconds > 0.05) return 3;
  return seconds > 0.01 ? 5 : 11;
}

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// The first run, which warms the caches, is watched by a clock and not counted.
void time_row(const PrecisionStudy& study, Timed& timed, Spent& spent) {
  Case run = timed.run;
  run.output_every = run.end;  // output times do not change the trajectory
  const Setup setup = resolve(std::move(run));
  const BarSystem system = setup.system();
  const Statistics first = simulate_within({study.stop, 1.5 * study.seconds}, setup, system, {});
  if (first.integration_seconds > study.seconds) throw TooLong();
  timed.row.steps = first.steps;
  timed.row.runs = runs_for(study, first.integration_seconds);
  std::vector<double> seconds;
  const WallClock clock;
  const std::clock_t used = std::clock();
  for (std::size_t k = 0; k < timed.row.runs; ++k)
    seconds.push_back(simulate_within({.stop = study.stop}, setup, system, {}).integration_seconds);
  spent.processor += static_cast<double>(std::clock() - used) / CLOCKS_PER_SEC;
  spent.wall += clock.seconds();
  timed.row.seconds = median(std::move(seconds));
}

/// Expected time of the next row, by those of the last two.
double expected(const std::vector<double>& seconds) {
  constexpr double least_growth = 1.2;
  if (seconds.size() < 2) return 0.0;
  const double last = seconds.back(), before = seconds[seconds.size() - 2];
  return last * std::max(least_growth, before > 0.0 ? last / before : 1.0);
}

}  // namespace

std::vector<Timed> settings_of(const PrecisionStudy& study, const Case& run) {
  std::vector<Timed> all;
  const auto add = [&](const Case& set, double setting, const std::string& label) {
    const std::string mesh = study.elements.size() > 1 ? fmt::format("{} elements, ", run.elements) : "";
    PrecisionRow row;
    row.method = run.method;
    row.elements = run.elements;
    row.mass = resolve(run).mass;
    row.setting = setting;
    row.label = mesh + label;
    all.push_back({set, std::move(row)});
  };
  if (is_scheme(run.method)) {
    const double transit = run.mesh().spacing() / run.scene.bar.wave_speed();
    for (std::size_t k = 0; k <= study.halvings; ++k) {
      Case set = run;
      set.step = std::ldexp(transit, -static_cast<int>(k));
      add(set, *set.step, fmt::format("step {:.3g}", *set.step));
    }
  } else if (is_adaptive(run.method)) {
    for (const double tolerance : study.tolerances) {
      Case set = run;
      set.tolerance = run.tolerance.with_relative(tolerance);
      add(set, tolerance, fmt::format("tolerance {:.3g}", tolerance));
    }
  } else {
    add(run, 0.0, "exact in time");
  }
  return all;
}

void time_rows(const PrecisionStudy& study, std::vector<Timed>& rows, std::vector<PrecisionResult::LeftOut>& left_out,
               Spent& spent) {
  std::vector<double> seconds;
  for (auto timed = rows.begin(); timed != rows.end(); ++timed) {
    PrecisionRow& row = timed->row;
    if (study.progress) study.progress(fmt::format("{}, {} elements, {}", name(row.method), row.elements, row.label));
    try {
      if (expected(seconds) > study.seconds) throw TooLong();
      time_row(study, *timed, spent);
      seconds.push_back(row.seconds);
    } catch (const TooLong&) {
      left_out.push_back({row.method, row.elements, row.label,
                          fmt::format("takes more than {:.3g} s a run, see --seconds", study.seconds)});
      rows.erase(timed, rows.end());
      break;
    } catch (const std::exception& error) {
      row.failure = error.what();
    }
  }
}

}  // namespace viscobar::precision

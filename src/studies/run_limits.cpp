#include "studies/run_limits.hpp"

#include <fmt/format.h>

#include <cmath>
#include <utility>
#include <vector>

#include "run/stopwatch.hpp"

namespace viscobar {

Statistics simulate_within(const RunLimits& limits, const Setup& setup, const BarSystem& system,
                           std::span<const double> times, Observers observers) {
  const Stopwatch clock;
  const bool bounded = std::isfinite(limits.seconds);
  bool stopped = false, late = false;
  std::size_t steps = 0;
  if (bounded || limits.stop || limits.steps < RunLimits().steps)
    observers.progress = [&](double) {
      stopped = limits.stop && limits.stop();
      late = bounded && clock.seconds() > limits.seconds;
      return stopped || late || ++steps > limits.steps ? RunControl::stop : RunControl::go_on;
    };
  const Statistics statistics = simulate(setup, system, times, observers);
  if (stopped) throw StudyStopped();
  if (late) throw TooLong();
  if (!statistics.completed) throw TooLong(fmt::format("the run takes more than {} steps", limits.steps));
  return statistics;
}

Statistics simulate_within(const RunLimits& limits, const Setup& setup, const BarSystem& system, Observers observers) {
  return simulate_within(limits, setup, system, setup.run.output_times(), std::move(observers));
}

std::optional<std::string> fault_in_words(const Setup& setup) {
  const std::vector<Finding> found = faults(setup);
  return found.empty() ? std::nullopt : std::optional(found.front().key + ": " + found.front().problem);
}

}  // namespace viscobar

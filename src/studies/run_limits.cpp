#include "studies/run_limits.hpp"

#include <fmt/format.h>

#include <algorithm>
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
  // A clock, which `stop` may read as well, costs as much as a step on few elements: it is asked twice a millisecond.
  constexpr double often = 5e-4;
  constexpr std::size_t most_apart = 256;
  std::size_t steps = 0, apart = 1, next = 0;
  double asked = 0.0;
  if (bounded || limits.stop || limits.steps < RunLimits().steps)
    observers.progress = [&](double) {
      if (steps++ >= next) {
        const double now = clock.seconds();
        apart = now - asked < often ? std::min(2 * apart, most_apart) : std::max<std::size_t>(apart / 2, 1);
        asked = now, next = steps + apart;
        stopped = limits.stop && limits.stop();
        late = bounded && now > limits.seconds;
      }
      return stopped || late || steps > limits.steps ? RunControl::stop : RunControl::go_on;
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

#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <optional>
#include <span>
#include <string>

#include "viscobar/case/case.hpp"
#include "viscobar/results/outcome.hpp"

namespace viscobar {

/// The first failure is what the user needs to know; those that follow from it are not.
void fail(Outcome& outcome, Ending ending, const std::string& error);

/// Runs a sound setup, from a checkpoint if there is one. What ends it early, an exception of any kind, is in the
/// outcome. `times`: of snapshots of a run from the start, in place of its output times.
void simulate_into(Outcome& outcome, const Setup& setup, const BarSystem& system, const std::optional<Checkpoint>& from,
                   const Observers& observers, std::span<const double> times = {});

/// Judges a run by its own account: each warning goes to `warn`, a ruinous alarm fails the outcome. The result is kept
/// either way.
void judge(Outcome& outcome, const Setup& setup, const BarSystem& system,
           const std::function<void(const std::string& warning)>& warn);

/// Notices a run that will take very long: every `look` steps, the time they advanced tells how many the rest would
/// take at that pace. More than a hundred times as many are many. Counted in steps, so that it says the same on every
/// machine.
class PaceWatch {
 public:
  PaceWatch(double begin, double end, std::size_t look) : end_(end), look_(look), since_(begin) {}
  /// Steps of so many nodes that take some seconds.
  static std::size_t some_seconds(std::size_t nodes) {
    return std::clamp<std::size_t>(100'000'000 / nodes, 1000, 1'000'000);
  }

  /// To be told the time that each step led to; what it has to say, once.
  std::optional<std::string> heard(double t) {
    if (++steps_ < look_) return std::nullopt;
    const double before = since_, rest = static_cast<double>(look_) * ((end_ - t) / (t - before));
    steps_ = 0;
    since_ = t;
    if (told_ || !(rest > 100.0 * static_cast<double>(look_))) return std::nullopt;
    told_ = true;
    return fmt::format(
        "slow: the last {} steps led from t = {:.6g} to {:.6g}, at that pace the end is {:.1e} steps away; remedies: "
        "an earlier time.end, a larger method.relative_tolerance, a load.history or load.density that varies more "
        "slowly, a larger contact.epsilon",
        look_, before, t, rest);
  }

  static void members(auto& self, auto&& each) { each(self.steps_, self.since_, self.told_); }

 private:
  double end_;
  std::size_t look_;
  std::size_t steps_ = 0;
  double since_;
  bool told_ = false;
};

}  // namespace viscobar

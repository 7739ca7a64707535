#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <optional>
#include <span>
#include <stdexcept>
#include <utility>
#include <variant>

#include "discretisation/not_positive.hpp"
#include "run/archive.hpp"
#include "run/step_failure.hpp"
#include "scene/times.hpp"
#include "viscobar/dynamics/load_error.hpp"
#include "viscobar/run/run.hpp"

namespace viscobar {

/// How a part of a run ends: at a checkpoint, from which the next part begins, or for good.
using PartEnd = std::variant<Statistics, Checkpoint>;

/// @throws std::invalid_argument unless there are two at least, finite and strictly increasing
inline void require_times(std::span<const double> times) {
  if (times.size() < 2 || !std::ranges::is_sorted(times, std::less_equal<>()) || !std::isfinite(times.front()) ||
      !std::isfinite(times.back()))
    throw std::invalid_argument("two output times at least, finite and strictly increasing, are needed");
}

/// A run in parts, `part(start)` being one. Since nothing but the checkpoint passes from one part to the next, a run
/// that begins from it later cannot differ from this one.
template <class Part>
Statistics run_in_parts(const StartingPoint& start, std::span<const double> times, const Observers& observers,
                        Part&& part) {
  require_times(times);
  PartEnd end = part(start);
  while (std::holds_alternative<Checkpoint>(end)) {
    const StartingPoint next = std::get<Checkpoint>(std::move(end));
    const Checkpoint& reached = std::get<Checkpoint>(next);
    if (reached.frame != Checkpoint::Frame::entered && observers.checkpoints->take(reached) == RunControl::stop)
      return reached.statistics;
    end = part(next);
  }
  return std::get<Statistics>(std::move(end));
}

/// part() of a run by a method. What stops it becomes an IntegrationError that says how far it came, with the
/// statistics that reached() gives.
template <class Part>
PartEnd part_or_failure(const char* method, auto&& reached, Part&& part) {
  const auto failure = [&](Failure why, const std::exception& cause) {
    const Statistics statistics = reached();
    return IntegrationError(why, fmt::format("{} stopped at t = {}: {}", method, statistics.reached_time, cause.what()),
                            statistics);
  };
  try {
    return part();
  } catch (const StepFailure& error) {
    throw failure(error.why, error);
  } catch (const LoadError& error) {
    throw failure(Failure::load, error);
  } catch (const NotPositive& error) {  // of the inertia alone: a step that loses it beside another matrix says so
    throw failure(error.finite ? Failure::defect : Failure::overflow, error);
  } catch (const std::domain_error& error) {
    throw failure(Failure::defect, error);
  }
}

/// Why a method that integrates u' = v, v' = M^{-1} F does not take massless contact nodes without viscosity.
inline Finding algebraic_rows(std::string_view method) {
  return {"method.name", std::string(method) +
                             " cannot take massless contact nodes without viscosity: their equations are algebraic; "
                             "use arkode or ida, or a positive bar.viscosity"};
}

/// @throws Unfit where directions are asked for, by a method that has no derivatives
inline void refuse_directions(const char* method, const Observers& observers) {
  if (!observers.directions.empty())
    throw Unfit(method, {"sensitivity.of", "there are no derivatives; cvode, ida, arkode and rigid have them"});
}

/// @throws Unfit where an end has a stop with a law of its own, by a method that knows none
inline void refuse_laws(const char* method, const std::array<EndInput, 2>& inputs) {
  if (const auto why = law_refusal(method, inputs[0], inputs[1])) throw Unfit(method, *why);
}

inline Statistics statistics_before(const StartingPoint& start) {
  const auto* checkpoint = std::get_if<Checkpoint>(&start);
  return checkpoint ? checkpoint->statistics : Statistics{};
}

inline double begin_of(const StartingPoint& start, std::span<const double> times) {
  const auto* checkpoint = std::get_if<Checkpoint>(&start);
  return checkpoint ? checkpoint->time : times.front();
}

/// Counts a contact change, and gives it the impulse so far, and the peak of what ends, where an account is kept.
inline void count_change(Statistics& statistics, Event& event) {
  ++statistics.events;
  if (!statistics.account) return;
  statistics.account->count(event);
  const ContactAccount& account = statistics.account->of(event);
  if (event.where != Where::span) event.impulse = account.impulse;
  if (event.change == Change::opening && !account.contact.closed_since) event.peak = account.latest;
}

/// The state of a method, archived by its members(), put into a checkpoint or taken from one.
template <class Method>
std::string archived(const Method& method) {
  ArchiveWriter archive;
  archive(method);
  return archive.take();
}

/// @throws std::invalid_argument when the checkpoint is not one of such a run
template <class Method>
void restore(Method& method, const Checkpoint& checkpoint, std::span<const double> times, const Observers& observers) {
  const auto refuse = [] {
    throw std::invalid_argument("the checkpoint is of another run than the one to go on with");
  };
  try {
    ArchiveReader archive(checkpoint.state);
    archive(method);
    if (!archive.finished()) refuse();
  } catch (const ArchiveError&) {
    refuse();
  }
  const bool within = checkpoint.time >= times.front() && checkpoint.time < times.back();
  const bool accounts = observers.energy == checkpoint.statistics.energy.has_value() &&
                        observers.account == checkpoint.statistics.account.has_value();
  if (!accounts || !within || checkpoint.outputs == 0 || checkpoint.outputs >= times.size()) refuse();
}

/// When the next checkpoint is due in a part of a run that begins at `now`.
class CheckpointSchedule {
 public:
  /// @throws std::invalid_argument for an interval that is not positive, or lost in the rounding of the times
  CheckpointSchedule(const Observers& observers, std::span<const double> times, double now)
      : checkpoints_(observers.checkpoints ? &*observers.checkpoints : nullptr) {
    if (!checkpoints_ || !checkpoints_->every) return;
    const double every = *checkpoints_->every, start = times.front(), end = times.back();
    const double rounding = rounding_of_times(start, end);
    if (!(every > rounding))
      throw std::invalid_argument("the time between checkpoints must be positive and not lost in rounding");
    // k every, never a sum; what is left after a checkpoint at the very end would be no leg.
    double k = std::floor((now - start) / every);
    while (start + k * every <= now) ++k;
    if (start + k * every < end - rounding) next_ = start + k * every;
  }

  /// The next one in simulated time.
  std::optional<double> next() const { return next_; }
  /// True if one is due at the end of a step at t.
  bool due(double t) const {
    return checkpoints_ && ((next_ && t >= *next_) || (checkpoints_->asked && checkpoints_->asked()));
  }

 private:
  const Checkpoints* checkpoints_;
  std::optional<double> next_;
};

}  // namespace viscobar

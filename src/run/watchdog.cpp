#include "run/watchdog.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "run/step_failure.hpp"

namespace viscobar {

namespace {

constexpr double rounding = std::numeric_limits<double>::epsilon();
constexpr std::size_t most_stalled = 100, most_toggles = 20;

}  // namespace

void Watchdog::attempt(double before, double reached) {
  stalled_ = reached > before ? 0 : stalled_ + 1;
  if (stalled_ > most_stalled)
    throw StepFailure(
        Failure::accuracy,
        fmt::format("no step longer than the rounding of the time keeps the tolerance at t = {}", before));
}

void Watchdog::step(double t, std::size_t changes) {
  const std::size_t changed = changes - changes_;
  if (++steps_ < look_ && changed < look_ / 50) return;
  const double rest = static_cast<double>(steps_) * ((end_ - t) / (t - since_));
  // Not a number where no time has passed at all.
  if (t < end_ && !(rest <= most_ || rest < 0.5 * rest_))
    throw StepFailure(
        changed > look_ / 1000 ? Failure::chatter : Failure::length,
        fmt::format("the last {} steps led from t = {} to {}, with {} contact changes: at that pace the end is {:.1e} "
                    "steps away",
                    steps_, since_, t, changed, rest));
  rest_ = rest;
  steps_ = 0;
  changes_ = changes;
  since_ = t;
}

void Watchdog::change(double t, std::size_t contact) {
  const bool same = contact == last_contact_ && t - last_change_ <= 4.0 * rounding * std::max(std::abs(t), 1e-300);
  toggles_ = same ? toggles_ + 1 : 0;
  last_contact_ = contact;
  last_change_ = t;
  if (toggles_ > most_toggles)
    throw StepFailure(Failure::toggling,
                      fmt::format("a contact opens and closes for ever at t = {}: its clearance is below the rounding "
                                  "of the displacement",
                                  t));
}

void Watchdog::close(double t, std::size_t node, double rate) {
  const double least = 64.0 * rounding * std::abs(t);
  if (rate * least <= std::numbers::pi) return;
  const double duration = std::numbers::pi / rate, share = least / duration;
  throw StepFailure(Failure::brief_contact,
                    fmt::format("a contact of node {} lasts {:.2g}, a few roundings of t = {}: its spring is {:.2g} "
                                "times too stiff",
                                node, duration, t, share * share));
}

}  // namespace viscobar

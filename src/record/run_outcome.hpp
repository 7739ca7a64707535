#pragma once

#include <functional>
#include <optional>
#include <string>

#include "viscobar/case/case.hpp"
#include "viscobar/results/outcome.hpp"

namespace viscobar {

/// The first failure is what the user needs to know; those that follow from it are not.
void fail(Outcome& outcome, Ending ending, const std::string& error);

/// Runs a sound case, from a checkpoint if there is one. What ends it early, an exception of any kind, is in the
/// outcome.
void simulate_into(Outcome& outcome, const Case& run, const BarSystem& system, const std::optional<Checkpoint>& from,
                   const Observers& observers);

/// What a run with an energy account tells against itself: each warning goes to `warn`, a ruinous alarm fails the
/// outcome. The result is kept either way.
void judge(Outcome& outcome, const Case& run, const BarSystem& system,
           const std::function<void(const std::string& warning)>& warn);

}  // namespace viscobar

#pragma once

#include <span>
#include <string>

#include "viscobar/sweep/sweep.hpp"

namespace viscobar {

/// sweep.csv: index, varied keys, completed (1 or 0), error, quantities; numbers in the shortest form that reads back
/// as the same double, nothing where there is none.
std::string sweep_csv(const SweepPlan& plan, std::span<const SweepRow* const> rows);

/// timings.csv: index, seconds, integration_seconds. Apart, so that the rows do not depend on the machine's load.
std::string timings_csv(std::span<const SweepRow* const> rows);

}  // namespace viscobar

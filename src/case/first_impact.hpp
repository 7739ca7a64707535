#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "viscobar/case/case.hpp"

namespace viscobar {

/// The first contact at a place of the bar, before which no penalty has acted there.
struct FirstImpact {
  Where where = Where::left;  ///< of the obstacle
  double time = 0.0;          ///< of the closing
  double speed = 0.0;         ///< towards the obstacle
};

/// First contacts at the left end, the right end and under the span, as far as they come before the end, by the fully
/// discrete scheme with a step in which a wave crosses an element (or the end / 500). Absent when that were more
/// than 10^8 nodal steps.
std::optional<std::vector<FirstImpact>> first_impacts(const Case& run);

}  // namespace viscobar

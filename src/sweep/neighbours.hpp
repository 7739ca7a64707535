#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "viscobar/sweep/sweep.hpp"

namespace viscobar {

/// Neighbour of each case of a sweep that asks for an error: the search for a mesh begins with the neighbour's
/// settings. Absent where the case searches by itself. Cases that differ in numbers alone, and ask for the same error,
/// are taken eight by eight in the order of the plan, and the middle one is the neighbour of the seven others. So
/// nobody waits for more than one case, and no case is far from its neighbour. Of a small sweep fewer are taken
/// together, so that sixteen at least search by themselves, as many cores being busy from the beginning.
///
/// The plan alone decides: a row does not depend on the order in which cases end.
std::vector<std::optional<std::size_t>> neighbours(const SweepPlan& plan);

}  // namespace viscobar

#pragma once

#include <functional>
#include <optional>
#include <string>

#include "studies/accuracy/sample.hpp"

namespace viscobar::accuracy {

/// The estimate for a run as it is, nothing chosen:
///
///     space     runs on half and a quarter as many elements, see space_error()
///     penalty   the largest penetration
///     time      twice what the tolerances promise of the displacement; of a scheme, the difference that twice the step
///               makes on the mesh of a quarter as many elements
///
/// and of `characteristics` what it tells of itself, without a run. There is none where the mesh is too coarse to be
/// halved twice, where the coarser runs fail or would take longer than `seconds`, or `stop` says so.
struct QuickEstimate {
  std::optional<ErrorEstimate> estimate;
  std::string why_not;  ///< in half a sentence, where there is none
};
QuickEstimate quick_estimate(const Case& run, const Sample& solution, double seconds,
                             const std::function<bool()>& stop = {});

/// The same before the run, from coarser meshes alone, half, a quarter and an eighth of it: their order is taken to go
/// on, but not above that of theory, and as 1 where they show none.
QuickEstimate forecast(const Case& run, double seconds);

}  // namespace viscobar::accuracy

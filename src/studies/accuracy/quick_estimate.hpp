#pragma once

#include <functional>
#include <optional>
#include <string>

#include "studies/accuracy/sample.hpp"

namespace viscobar::accuracy {

/// The estimate for a run as it is, nothing chosen: that of a request whose scene has all settings, see Plan. There is
/// none where the mesh is too coarse to be halved twice, where its runs fail or would take longer than `seconds`, or
/// `stop` says so.
struct QuickEstimate {
  std::optional<ErrorEstimate> estimate;
  std::string why_not;       ///< in half a sentence, where there is none
  std::size_t elements = 0;  ///< of the mesh that it is of
};
/// `solution`: what is known of the run, at times_of_errors(); absent: it is made, too.
QuickEstimate quick_estimate(const Case& run, std::optional<Sample> solution, double seconds,
                             const std::function<bool()>& stop = {});

/// The same before the run. Where that takes longer, the estimate of a mesh of a quarter as many elements, and so on.
QuickEstimate forecast(const Case& run, double seconds, const std::function<bool()>& stop = {});

/// The estimate of what a request leads to, whose settings `run` gets. There is none where the search takes longer.
QuickEstimate forecast(Case& run, const AccuracyRequest& request, double seconds,
                       const std::function<bool()>& stop = {});

}  // namespace viscobar::accuracy

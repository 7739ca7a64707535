#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "studies/fit/search.hpp"

namespace viscobar::fitting {

/// Estimates, deviations and covariance of a minimum. Returns values that meet the data better, if it has come upon
/// some; `others` gets minima that may meet them as well.
std::optional<Eigen::VectorXd> judge(Search& search, const FitStudy& study, const Minimum& best,
                                     std::vector<Minimum>& others, FitResult& result);
/// Warns of what makes the best of the minima found unreliable, such as samples that are not met as they are; then
/// `converged` is false.
void add_warnings(const FitStudy& study, const std::vector<Minimum>& found, const Minimum& best, bool met,
                  FitResult& result);

}  // namespace viscobar::fitting

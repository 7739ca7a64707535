#pragma once

#include <string>

#include "viscobar/analysis/penalty_limit.hpp"

namespace viscobar {

/// The pictures of a limit study, each a <figure> with its caption, epsilon on a logarithmic axis.
std::string penetration_picture(const LimitStudy& study, const LimitResult& result);
std::string difference_picture(const LimitStudy& study, const LimitResult& result);
std::string events_picture(const LimitResult& result);
std::string cost_picture(const LimitResult& result);

}  // namespace viscobar

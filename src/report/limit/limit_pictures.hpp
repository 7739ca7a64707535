#pragma once

#include "report/page.hpp"
#include "viscobar/studies/limit/limit.hpp"

namespace viscobar {

/// The pictures of a limit study, epsilon on a logarithmic axis.
Picture penetration_picture(const LimitStudy& study, const LimitResult& result);
Picture difference_picture(const LimitStudy& study, const LimitResult& result);
Picture events_picture(const LimitResult& result);
Picture cost_picture(const LimitResult& result);

}  // namespace viscobar

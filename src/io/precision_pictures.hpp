#pragma once

#include <string>

#include "viscobar/analysis/work_precision.hpp"

namespace viscobar {

/// The pictures of a work-precision study, each a <figure> with its caption, on logarithmic axes; empty where there is
/// nothing to draw.
std::string error_picture(const PrecisionResult& result);
std::string time_error_picture(const PrecisionResult& result);
std::string parts_picture(const PrecisionResult& result);

}  // namespace viscobar

#pragma once

#include "report/page.hpp"
#include "viscobar/studies/precision/precision.hpp"

namespace viscobar {

/// The pictures of a precision study, each a <figure> with its caption, on logarithmic axes; empty where there is
/// nothing to draw.
Picture error_picture(const PrecisionResult& result);
Picture time_error_picture(const PrecisionResult& result);
Picture parts_picture(const PrecisionResult& result);

}  // namespace viscobar

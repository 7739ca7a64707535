#pragma once

#include <span>

#include "viscobar/scene/scene.hpp"

namespace viscobar::characteristics {

/// A function of time as what moves an end.
struct FunctionOfTime {
  double start;      ///< f(0)
  EndMotion motion;  ///< f - f(0), with its two derivatives
};

/// f on [0, end], which a caller has as values alone.
///
/// It is represented by polynomial pieces to rounding (see PiecewiseFit), made window by window, and these are
/// differentiated: n^2 roundings of f over the length of a piece, n <= 32, are lost at the first derivative and n^4 at
/// the second. Where value or slope jumps from piece to piece it breaks. A feature that is far shorter than a sixtieth
/// of a window is missed. @throws what f throws, and std::invalid_argument where f is not finite.
FunctionOfTime function_through(const TimeFunction& f, double end, double window);

/// A cubic spline through values at increasing times, four at least; its slopes at both ends are those of the cubic
/// through four values. Between samples h apart it differs from a smooth f by h^4 |f''''|, its second derivative by
/// h^2 |f''''|, each times a constant of about 0.01 and 0.1. It is twice differentiable but beside jumps and kinks of
/// the samples: there its slopes are limited, so that it rises, falls and stays where the samples do.
/// @throws std::invalid_argument for other times or values that are not finite
FunctionOfTime spline_through(std::span<const double> times, std::span<const double> values);

}  // namespace viscobar::characteristics

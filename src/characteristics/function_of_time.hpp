#pragma once

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

}  // namespace viscobar::characteristics

#pragma once

#include <cmath>

namespace viscobar {

/// A number as messages show it: not a number is "nan", whatever sign the processor gives it.
inline double printable(double value) { return std::isnan(value) ? std::abs(value) : value; }

}  // namespace viscobar

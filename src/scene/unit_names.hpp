#pragma once

#include <string>
#include <string_view>

#include "viscobar/scene/scene.hpp"

namespace viscobar {

/// What the numbers of a run measure. A force is one on the bar's cross-section, and an energy one of its length: a
/// stress, and a stress times a length.
enum class Dimension { length, time, velocity, stress, impulse, energy };

/// The name of its unit, such as "m/s" or "kg/(m s^2)"; empty where the scene names too few units for it.
std::string unit_name(const Units& units, Dimension quantity);

/// "time t [s]", with ² for ^2; without a unit the words alone.
std::string with_unit(std::string_view words, const Units& units, Dimension quantity);

/// The units that are named, as "length: m, time: s"; empty where none is.
std::string named_units(const Units& units);

}  // namespace viscobar

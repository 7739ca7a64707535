#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>

#include "viscobar/scene/scene.hpp"

namespace viscobar {

/// Dimensions of the numbers of a run. A force is one on the bar's cross-section, an energy one of its length.
enum class Dimension { length, time, velocity, stress, force, impulse, energy };

/// A unit by its powers of length, time, stress and area, which are fractions in norms over the bar. A force is a
/// stress times an area: the square of a length where the scene has a section, 1 where forces are per area.
using UnitPowers = std::array<double, 4>;
UnitPowers unit_powers(Dimension quantity);
/// Powers of a unit in words, such as "stress x time / length", each "/" before what it divides by, or "density";
/// absent: of none.
std::optional<UnitPowers> unit_powers(std::string_view words);

/// The name of its unit, such as "m/s" or "kg/(m s^2)", the shortest that the units named have; empty where the scene
/// names too few units for it, and where all powers are 0.
std::string unit_name(const Units& units, const UnitPowers& powers);
inline std::string unit_name(const Units& units, Dimension quantity) { return unit_name(units, unit_powers(quantity)); }

/// The unit of a derivative, "1" of a number where the scene names units; empty where that by which it is has none.
std::string unit_name(const Units& units, Dimension quantity, const std::optional<UnitPowers>& per);

/// A unit as pages write it, with ² for ^2 and ³ for ^3.
std::string squares(std::string unit);

/// "time t [s]"; without a unit the words alone.
std::string with_unit(std::string_view words, const std::string& unit);

/// The units that are named, as "length: m, time: s"; empty where none is.
std::string named_units(const Units& units);

}  // namespace viscobar

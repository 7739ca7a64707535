#pragma once

#include <optional>
#include <string>

#include "viscobar/dynamics/bar_system.hpp"

namespace viscobar {

/// Reference scales of a scene.
struct NaturalScales {
  double time = 0.0;          ///< L / c, c = sqrt(E / rho)
  double displacement = 0.0;  ///< U
  double velocity() const { return displacement / time; }
};

/// Scales of the initial data and the load, with tau = min(L / c, end):
///
///     U = max( max |u_0 - its mean|, tau max |u_1|, tau^2 max_x |f| / rho, tau |F| / (rho c A), |d| ),
///
/// |f|, |F| of forces on the ends and |d| of their motion being means over time, and L where all vanish. A gap is no
/// scale: a far obstacle says nothing about the motion. Of a load that varies, the mean is that of 64 times up to
/// `end`; where it is not finite it counts for nothing here.
NaturalScales natural_scales(const BarSystem& system, double end);
/// A of the element at that end; behind a rigid body, of the bar next to it.
double area_at(const BarSystem& system, bool right);
/// U without that L: 0 where all vanish.
double displacement_of_data(const BarSystem& system, double end);
/// The fault, in words, of data that move the bar from this state, but by less than has squares; else absent.
std::optional<std::string> too_small(const State& start, const BarSystem& system, double end);

}  // namespace viscobar

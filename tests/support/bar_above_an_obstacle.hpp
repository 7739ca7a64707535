#pragma once

namespace viscobar {

/// The beginning of a scene file: a Kelvin-Voigt bar above an obstacle on the left, as yet without data and mesh.
inline constexpr const char* bar_above_an_obstacle = R"(
[bar]
length = 1.0
viscosity = 0.08
[left]
kind = "obstacle"
gap = 0.1
[time]
end = 3.0
[mesh]
elements = 20
)";

}  // namespace viscobar

#pragma once

#include <string_view>
#include <vector>

#include "viscobar/discretisation/mass.hpp"
#include "viscobar/dynamics/elements.hpp"
#include "viscobar/scene/scene.hpp"

namespace viscobar {

/// Functions of x that have moments: a load, an initial velocity, of which they are momenta, or k and c of a side.
enum class Moments { of_load, of_velocity, of_side };
/// int phi_i f dx of all nodes; empty where values at the nodes do. `what` names f in messages. @throws LoadError
std::vector<double> nodal_moments(const Elements& elements, Mass mass, std::string_view what, const SpaceFunction& f,
                                  const Places& places, Moments of);
/// k(x), or c(x), of a side for its nodes: their values there, or means over phi_i where k jumps or is too narrow for
/// the mesh. Empty without f.
std::vector<double> side_values(const Elements& elements, Mass mass, const SpaceFunction& f, const Places& places);

}  // namespace viscobar

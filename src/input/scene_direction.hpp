#pragma once

#include <string>

#include "input/scene_entries.hpp"
#include "viscobar/case/case.hpp"

namespace viscobar {

/// What scale f(t) + offset, or its derivative with respect to a parameter, is to an end.
EndMotion motion_of(const Formula& f, const std::string& by, double scale, double offset);
/// What moves an obstacle with that gap, or the derivative of it; the obstacle has the gap at the start.
EndMotion motion_of_gap(const Formula& gap, const std::string& by, const Obstacle& obstacle);

/// The direction of a key of a scene file, or of parameters.NAME: formulas are differentiated, not differenced. `run`
/// is the case of the entries but for its method, where that is chosen for it.
/// @throws std::invalid_argument where there is none
Direction direction_of(const SceneEntries& entries, const Case& run, const std::string& key);

}  // namespace viscobar

#pragma once

#include <string>

#include "input/scene_entries.hpp"
#include "viscobar/case/case.hpp"

namespace viscobar {

/// The direction of a key of a scene file, or of parameters.NAME: formulas are differentiated, not differenced. `run`
/// is the case of the entries but for its method, where that is chosen for it.
/// @throws std::invalid_argument where there is none
Direction direction_of(const SceneEntries& entries, const Case& run, const std::string& key);

}  // namespace viscobar

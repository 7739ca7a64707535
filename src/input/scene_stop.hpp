#pragma once

#include <optional>
#include <string>

#include "input/scene_entries.hpp"
#include "viscobar/scene/stop.hpp"

namespace viscobar {

/// The stop of the obstacle at that end, "left" or "right": by the end's own `contact`, which is whole, or by
/// [contact]; absent: the penalty.
std::optional<Stop> stop_of(const SceneEntries& entries, const std::string& side);

/// Reports numbers that a law lacks, and such as do not belong to it, in [contact] and in both ends.
void check_laws(SceneEntries& entries);

}  // namespace viscobar

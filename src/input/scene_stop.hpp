#pragma once

#include <optional>
#include <string>
#include <utility>

#include "input/scene_entries.hpp"
#include "viscobar/scene/stop.hpp"

namespace viscobar {

/// The stop of the obstacle at that end, "left" or "right", or of a contact "joint.1": by the end's own `contact`,
/// which is whole, or by [contact]; absent: the penalty.
std::optional<Stop> stop_of(const SceneEntries& entries, const std::string& side);

/// The damping of hunt_crossley where a restitution at a speed gives it: its key, and its derivative by `key`; absent:
/// `key` is neither of the two. @throws std::invalid_argument where it is that damping, which the scene does not have
std::optional<std::pair<std::string, double>> damping_by(const SceneEntries& entries, const std::string& key);

/// Reports numbers that a law lacks, and such as do not belong to it, in [contact], in both ends and at joints.
void check_laws(SceneEntries& entries);

}  // namespace viscobar

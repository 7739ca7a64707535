#pragma once

#include <optional>

#include "viscobar/scene/scene.hpp"

namespace viscobar {

/// Why a scene has no penalty limit: nothing to touch, or a stop with a law of its own, whose key it names. Absent: it
/// has one.
std::optional<Finding> limit_fault(const Scene& scene);

}  // namespace viscobar

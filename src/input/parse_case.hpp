#pragma once

#include <span>
#include <string>

#include "viscobar/input/scene_file.hpp"

namespace viscobar {

/// The case of parse_scene() without its description, which nobody reads of the thousands of a sweep.
/// @throws SceneError
Case parse_case(const std::string& text, const std::string& source, std::span<const std::string> overrides,
                const Adaptation& adapt = {});

}  // namespace viscobar

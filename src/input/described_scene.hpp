#pragma once

#include <string>

#include "viscobar/input/scene_file.hpp"

namespace viscobar {

/// The scene whose SceneFile::description this is; `source` names it in diagnostics. @throws SceneError
SceneFile described_scene(const std::string& description, const std::string& source);

}  // namespace viscobar

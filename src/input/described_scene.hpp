#pragma once

#include <string>

#include "viscobar/input/scene_file.hpp"

namespace viscobar {

/// A scene file that says what SceneFile::description does.
std::string scene_text(const std::string& description);

/// The scene whose SceneFile::description this is; `source` names it in diagnostics. @throws SceneError
SceneFile described_scene(const std::string& description, const std::string& source);

}  // namespace viscobar

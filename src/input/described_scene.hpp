#pragma once

#include <span>
#include <string>

#include "viscobar/input/scene_file.hpp"

namespace viscobar {

/// parse_scene() without the description, which nobody reads of the thousands of a sweep. @throws SceneError
SceneFile parse_case(const std::string& text, const std::string& source, std::span<const std::string> overrides,
                     const Adaptation& adapt = {});

/// A scene file that says what SceneFile::description does.
std::string scene_text(const std::string& description);

/// The scene that a summary of viscobar tells (summary.json, limit.json, ...), as a scene file; other text as it is.
/// TOML never begins with a brace. @throws TextError where the text begins with one and is no such summary
std::string told_scene(const std::string& text);

/// The scene whose SceneFile::description this is; `source` names it in diagnostics. @throws SceneError
SceneFile described_scene(const std::string& description, const std::string& source);

/// The same scene with the settings of another case of it: elements, mass, epsilon, restitution, method, tolerances and
/// step. They count as chosen where the scene does not have them.
SceneFile with_settings(const SceneFile& scene, const Case& chosen);

}  // namespace viscobar

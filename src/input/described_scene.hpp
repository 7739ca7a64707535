#pragma once

#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <string_view>
#include <utility>

#include "input/toml_text.hpp"
#include "viscobar/input/scene_file.hpp"

namespace viscobar {

/// A case of a sweep is run and not told: SceneFile::values and SceneFile::chosen stay empty.
enum class Telling { values, nothing };

/// parse_scene() with typed settings. @throws SceneError
SceneFile parse_scene_with(const std::string& text, const std::string& source, std::span<const Setting> settings,
                           const Adaptation& adapt = {}, Telling telling = Telling::values);

const SceneValue* value_of(const SceneValues& values, std::string_view key);

/// Lays values over those of an object with an object for each table.
void put(nlohmann::ordered_json& tables, const SceneValues& values);
/// All that was run: the values of the scene, and those that were chosen.
nlohmann::ordered_json complete(const SceneFile& scene);

/// Tables of the problem in which two scenes differ, as complete() has them: "[bar], [left]". How it is solved does not
/// count.
std::string differing_tables(const nlohmann::ordered_json& one, const nlohmann::ordered_json& other);
/// "table.key=value" as --set takes it; numbers read back to the last bit.
std::string text_of(const Setting& setting);

std::string scene_text(const SceneValues& values);

/// @throws TextError that says "`otherwise`: " and why
nlohmann::ordered_json parsed_json(std::string_view text, std::string_view otherwise);

/// A scene file, or the scene that a summary of viscobar tells (summary.json, limit.json, ...). TOML never begins with
/// a brace. @throws TextError where the text is neither
TomlNode scene_tree(const std::string& text);

/// The scene whose SceneFile::description() this is; `source` names it in diagnostics. @throws SceneError
SceneFile described_scene(const std::string& description, const std::string& source);

/// Settings that a scene with an error may give or leave to choose.
inline constexpr std::pair<std::string_view, bool AccuracyRequest::Given::*> given_keys[] = {
    {"mesh.elements", &AccuracyRequest::Given::elements},
    {"mesh.mass", &AccuracyRequest::Given::mass},
    {"method.name", &AccuracyRequest::Given::method},
    {"contact.epsilon", &AccuracyRequest::Given::epsilon},
    {"contact.restitution", &AccuracyRequest::Given::restitution},
    {"method.relative_tolerance", &AccuracyRequest::Given::tolerance},
    {"method.step", &AccuracyRequest::Given::step}};

/// The same scene with the settings of another case of it: elements, mass, epsilon, restitution, method, tolerances and
/// step. They count as chosen where the scene does not have them.
SceneFile with_settings(SceneFile scene, const Case& chosen);
/// Its settings that were read back as values of the scene count as chosen again.
void count_as_chosen(SceneFile& scene, std::span<const std::string> keys);

}  // namespace viscobar

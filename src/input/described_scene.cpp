#include "input/described_scene.hpp"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "input/toml_text.hpp"
#include "text/printable_text.hpp"

namespace viscobar {

namespace {

using Json = nlohmann::ordered_json;

// A string of JSON is one of TOML but for the one control character that JSON does not escape.
std::string line(const std::string& key, const Json& value) {
  std::string text = value.dump();
  for (std::size_t at = 0; (at = text.find('\x7f', at)) != text.npos;) text.replace(at, 1, "\\u007F");
  return fmt::format("{} = {}\n", key, text);
}

}  // namespace

std::string scene_text(const std::string& description) {
  std::string top, tables;
  const Json scene = Json::parse(description);
  for (const auto& [name, value] : scene.items()) {
    if (!value.is_object()) {
      top += line(name, value);
      continue;
    }
    tables += fmt::format("[{}]\n", name);
    for (const auto& [key, entry] : value.items()) tables += line(key, entry);
  }
  return top + tables;
}

std::string told_scene(const std::string& text) {
  if (const auto first = text.find_first_not_of(" \t\r\n"); first == std::string::npos || text[first] != '{')
    return text;
  try {
    const Json summary = Json::parse(text);
    if (summary.contains("scene") && summary["scene"].is_object()) return scene_text(summary["scene"].dump());
  } catch (const Json::parse_error& error) {
    throw TextError(position_in(text, error.byte > 0 ? error.byte - 1 : 0),
                    fmt::format("this is no TOML, and no JSON either: {}", error.what()));
  }
  throw TextError(
      {},
      "this is JSON without a scene; a file consists of [tables] and lines key = value, or is a summary of viscobar");
}

SceneFile described_scene(const std::string& description, const std::string& source) {
  return parse_scene(scene_text(description), source);
}

SceneFile with_settings(const SceneFile& scene, const Case& chosen) {
  const Json before = Json::parse(scene.description);
  Json after = before, new_keys = Json::object();
  const auto set = [&](const char* table, const char* key, const Json& value) {
    after[table][key] = value;
    if (!before.contains(table) || !before[table].contains(key) || before[table][key] != value)
      new_keys[table][key] = value;
  };
  const Setup setup = resolve(chosen);
  set("mesh", "elements", chosen.elements);
  if (chosen.method != MethodName::characteristics) set("mesh", "mass", name(setup.mass));
  if (is_penalised(chosen.method) && chosen.epsilon) set("contact", "epsilon", *chosen.epsilon);
  if (chosen.restitution) set("contact", "restitution", *chosen.restitution);
  set("method", "name", name(chosen.method));
  if (is_adaptive(chosen.method)) {
    set("method", "relative_tolerance", chosen.tolerance.relative);
    if (chosen.tolerance.absolute) set("method", "absolute_tolerance", *chosen.tolerance.absolute);
  }
  if (is_scheme(chosen.method)) set("method", "step", setup.step);
  SceneFile result = described_scene(after.dump(), "the chosen settings");
  Json all = Json::parse(result.chosen);
  all.merge_patch(new_keys);
  result.chosen = all.dump(2);
  result.run = chosen;
  return result;
}

}  // namespace viscobar

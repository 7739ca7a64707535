#include "input/described_scene.hpp"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

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

SceneFile described_scene(const std::string& description, const std::string& source) {
  return parse_scene(scene_text(description), source);
}

}  // namespace viscobar

#include "input/described_scene.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "input/scene_entries.hpp"
#include "input/scene_keys.hpp"
#include "input/seal.hpp"
#include "text/printable_text.hpp"

namespace viscobar {

namespace {

using Json = nlohmann::ordered_json;

Json json_of(const SceneTable& table) {
  Json json = Json::object();
  for (const auto& [name, entry] : table)
    std::visit([&, &key = name](const auto& one) { json.emplace(key, one); }, entry);
  return json;
}

Json json_of(const SceneValue& value) {
  return std::visit(
      [](const auto& one) {
        if constexpr (std::is_same_v<std::decay_t<decltype(one)>, SceneTable>)
          return json_of(one);
        else
          return Json(one);
      },
      value);
}

// A string of JSON is one of TOML but for the one control character that JSON does not escape.
std::string toml_of(const Json& value) {
  if (value.is_object()) {
    std::string table;
    for (const auto& [name, entry] : value.items())
      table += fmt::format("{}{} = {}", table.empty() ? "" : ", ", name, toml_of(entry));
    return "{ " + table + " }";
  }
  std::string text = value.dump();
  for (std::size_t at = 0; (at = text.find('\x7f', at)) != text.npos;) text.replace(at, 1, "\\u007F");
  return text;
}

// The tree that toml++ makes of the same values.
TomlNode tree_of(const Json& json, const std::string& key = "") {
  TomlNode node;
  node.key = key;
  node.value = OtherValue{"null"};
  if (json.is_string()) node.value = json.get<std::string>();
  if (json.is_boolean()) node.value = json.get<bool>();
  if (json.is_number_float()) node.value = json.get<double>();
  if (json.is_number_integer()) node.value = json.get<std::int64_t>();
  if (json.is_object()) {
    node.kind = TomlNode::Kind::table;
    node.value = OtherValue{"a table"};
    SceneTable series;
    for (const auto& [name, inside] : json.items()) {
      node.inside.push_back(tree_of(inside, name));
      if (inside.is_number()) series.emplace(name, inside.get<double>());
      if (inside.is_string()) series.emplace(name, inside.get<std::string>());
      if (const auto* numbers = std::get_if<std::vector<double>>(&node.inside.back().value))
        series.emplace(name, *numbers);
    }
    if (!series.empty() && series.size() == json.size()) node.value = std::move(series);
  }
  if (json.is_array()) {
    node.kind = TomlNode::Kind::array;
    node.value = OtherValue{"an array"};
    for (const Json& inside : json) node.inside.push_back(tree_of(inside));
    if (std::ranges::all_of(json, [](const Json& one) { return one.is_string(); }))
      node.value = json.get<std::vector<std::string>>();
    else if (std::ranges::all_of(json, [](const Json& one) { return one.is_number(); }))
      node.value = json.get<std::vector<double>>();
  }
  return node;
}

// Where describe() tells a key.
std::ptrdiff_t rank(std::string_view key) {
  if (is_parameter(key)) return -1;
  return (is_member_key(key) ? find_scene_key("bar.length") : find_scene_key(key)) - scene_keys().data();
}

}  // namespace

const SceneValue* value_of(const SceneValues& values, std::string_view key) {
  const auto found = std::ranges::find(values, key, [](const auto& one) { return std::string_view(one.first); });
  return found == values.end() ? nullptr : &found->second;
}

void put(Json& tables, const SceneValues& values) {
  for (const auto& [key, value] : values) {
    const std::size_t dot = key.find('.');
    if (dot == key.npos) {
      tables[key] = json_of(value);
      continue;
    }
    if (is_member_key(key)) {
      const std::string_view table = table_of(key);
      const auto number = static_cast<std::size_t>(std::stoul(std::string(table.substr(dot + 1))));
      Json& list = *tables.emplace(key.substr(0, dot), Json::array()).first;
      while (list.size() < number) list.push_back(Json::object());
      list[number - 1][std::string(key.substr(table.size() + 1))] = json_of(value);
      continue;
    }
    // Not by [] on nothing: nlohmann's 3.11.2 ends by a signal where it finds no memory for a table made so.
    Json& table = *tables.emplace(key.substr(0, dot), Json::object()).first;
    if (!is_parameter(key) && key.find('.', dot + 1) != key.npos)
      put(table, {{key.substr(dot + 1), value}});
    else
      table[key.substr(dot + 1)] = json_of(value);
  }
}

Json complete(const SceneFile& scene) {
  Json json = Json::object();
  put(json, scene.values);
  put(json, scene.chosen);
  return json;
}

std::string differing_tables(const Json& one, const Json& other) {
  const auto problem = [](const Json& scene, const char* table) {
    nlohmann::json values = scene.value(table, Json::object());
    if (values.is_object()) values.erase("epsilon");
    for (nlohmann::json& member : values)
      for (const char* key : {"elements", "grading", "nodes"})
        if (member.is_object()) member.erase(key);
    return values;
  };
  std::string found;
  for (const char* table :
       {"parameters", "bar", "joint", "left", "right", "span", "side", "initial", "load", "contact"})
    if (problem(one, table) != problem(other, table)) found += fmt::format("{}[{}]", found.empty() ? "" : ", ", table);
  return found;
}

std::string SceneFile::description() const {
  Json json = Json::object();
  put(json, values);
  return json.dump(2);
}

std::string text_of(const Setting& setting) {
  if (const auto* text = std::get_if<std::string>(&setting)) return *text;
  const auto& [key, value] = std::get<1>(setting);
  return key + "=" + toml_of(json_of(value));
}

std::string scene_text(const SceneValues& values) {
  Json scene = Json::object();
  put(scene, values);
  std::string top, tables;
  for (const auto& [name, value] : scene.items()) {
    if (value.is_array() && !value.empty() && value.front().is_object()) {
      for (const Json& member : value) {
        tables += fmt::format("[[{}]]\n", name);
        for (const auto& [key, entry] : member.items()) tables += fmt::format("{} = {}\n", key, toml_of(entry));
      }
      continue;
    }
    if (!value.is_object()) {
      top += fmt::format("{} = {}\n", name, toml_of(value));
      continue;
    }
    tables += fmt::format("[{}]\n", name);
    for (const auto& [key, entry] : value.items()) tables += fmt::format("{} = {}\n", key, toml_of(entry));
  }
  return top + tables;
}

Json parsed_json(std::string_view text, std::string_view otherwise) try {
  return Json::parse(text);
} catch (const Json::parse_error& error) {
  // The parser counts the bytes that it has read, the wrong one included, and one more at the end.
  const std::size_t at = std::min(error.byte > 0 ? error.byte - 1 : 0, text.size());
  const std::size_t length = std::max<std::size_t>(1, character_length(text, at));
  const bool ended = text.find_first_not_of(" \t\r\n", at) == text.npos;
  throw TextError(position_in(text, at),
                  fmt::format("{}: {}", otherwise,
                              ended ? "it ends before its last bracket closes"
                                    : fmt::format("{} cannot stand here", one_line(text.substr(at, length)))));
}

TomlNode scene_tree(const std::string& text) {
  if (const auto first = text.find_first_not_of(" \t\r\n"); first == std::string::npos || text[first] != '{')
    return parse_toml(text);
  const Json summary = parsed_json(text, "this is no TOML, and no JSON either");
  if (summary.contains("crc64") && seal_of(text) == Seal::broken)
    throw TextError(
        {},
        "this summary is damaged: its checksum is not the one that was written; from one that was changed on "
        "purpose take out \"crc64\"");
  if (summary.contains("scene") && summary["scene"].is_object()) {
    Json scene = summary["scene"];
    // Each method of a comparison, or of a study of errors, chooses anew what it chose for itself.
    const Json chosen = summary.contains("pairs") || summary.contains("parts") ? summary.value("chosen", Json::object())
                                                                               : Json::object();
    for (const auto& [table, keys] : chosen.items())
      for (const auto& [key, value] : keys.items())
        if (scene.contains(table) && scene[table].is_object()) scene[table].erase(key);
    return tree_of(scene);
  }
  throw TextError(
      {},
      "this is JSON without a scene; a file consists of [tables] and lines key = value, or is a summary of viscobar");
}

SceneFile described_scene(const std::string& description, const std::string& source) {
  return parse_scene(fmt::format("{{\"scene\": {}}}", description), source);
}

SceneFile with_settings(SceneFile scene, const Case& chosen) {
  const Setup setup = resolve(chosen);
  SceneValues& values = scene.values;
  scene.chosen.clear();
  if (is_penalised(chosen.method) && has_penalty(chosen.scene) && !chosen.epsilon)
    scene.chosen.emplace_back("contact.epsilon", setup.epsilon);
  const auto set = [&](const char* key, SceneValue value) {
    auto at = std::ranges::find(values, key, &SceneValues::value_type::first);
    const auto* row =
        std::ranges::find(given_keys, key, &std::pair<std::string_view, bool AccuracyRequest::Given::*>::first);
    const bool given = !scene.accuracy || row == std::end(given_keys) || scene.accuracy->given.*row->second;
    if (given && at != values.end() && at->second == value) return;
    scene.chosen.emplace_back(key, value);
    at == values.end() ? void(values.emplace_back(key, value)) : void(at->second = value);
  };
  set("mesh.elements", static_cast<std::int64_t>(chosen.elements));
  if (chosen.method != MethodName::characteristics) set("mesh.mass", std::string(name(setup.mass)));
  if (is_penalised(chosen.method) && chosen.epsilon) set("contact.epsilon", *chosen.epsilon);
  if (chosen.restitution) set("contact.restitution", *chosen.restitution);
  set("method.name", std::string(name(chosen.method)));
  if (is_adaptive(chosen.method)) {
    set("method.relative_tolerance", chosen.tolerance.relative);
    if (chosen.tolerance.absolute) set("method.absolute_tolerance", *chosen.tolerance.absolute);
  }
  if (is_scheme(chosen.method)) set("method.step", setup.step);
  std::ranges::stable_sort(values, {}, [](const auto& one) { return rank(one.first); });
  scene.run = chosen;
  return scene;
}

void count_as_chosen(SceneFile& scene, std::span<const std::string> keys) {
  for (const std::string& key : keys) {
    if (const SceneValue* value = value_of(scene.values, key)) scene.chosen.emplace_back(key, *value);
    scene.run.automatic = scene.run.automatic || key == "method.name";
    for (const auto& [name, given] : given_keys)
      if (scene.accuracy && key == name) scene.accuracy->given.*given = false;
  }
}

}  // namespace viscobar

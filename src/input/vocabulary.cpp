#include "input/vocabulary.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "input/scene_keys.hpp"
#include "viscobar/case/case.hpp"

namespace viscobar {

namespace {

using Json = nlohmann::ordered_json;

std::string code(std::string_view word) { return fmt::format("`{}`", word); }

MethodName method_named(std::string_view word) {
  return *std::find_if(std::begin(all_methods), std::end(all_methods),
                       [&](MethodName method) { return name(method) == word; });
}

std::string_view obstacle_words(MethodName method) { return is_penalised(method) ? "penalty" : "exact"; }

std::string_view accuracy_words(MethodName method) {
  if (is_scheme(method)) return "`method.step`";
  return is_adaptive(method) ? "tolerances" : "rounding";
}

std::string_view name(KeyType type) {
  switch (type) {
    case KeyType::text: return "text";
    case KeyType::choice: return "choice";
    case KeyType::number: return "number";
    case KeyType::count: return "count";
    case KeyType::formula: return "formula";
    case KeyType::amount: return "amount";
    case KeyType::list: return "list";
  }
  return {};
}

std::string_view name(Presence presence) {
  switch (presence) {
    case Presence::required: return "always";
    case Presence::required_in_table: return "in its table";
    case Presence::optional: return "never";
  }
  return {};
}

/// A fallback is written as TOML: a text in quotes, or a number.
Json fallback_value(const SceneKey& key) { return key.fallback.empty() ? Json(nullptr) : Json::parse(key.fallback); }

Json to_json(const SceneKey& key) {
  Json json = {
      {"key", key.name},  {"type", name(key.type)}, {"required", name(key.presence)}, {"default", fallback_value(key)},
      {"unit", key.unit}, {"meaning", key.meaning}};
  if (key.type == KeyType::number || key.type == KeyType::count || key.type == KeyType::amount)
    json["limits"] = {{"low", key.range.low}, {"high", key.range.high}};
  if (!key.choices.empty()) json["choices"] = key.choice_names();
  if (key.type == KeyType::formula) json["variables"] = key.variables;
  return json;
}

}  // namespace

std::string_view name(Vocabulary vocabulary) {
  switch (vocabulary) {
    case Vocabulary::methods: return "methods";
    case Vocabulary::masses: return "masses";
    case Vocabulary::keys: return "keys";
  }
  return {};
}

Table vocabulary_table(Vocabulary vocabulary) {
  Table table;
  switch (vocabulary) {
    case Vocabulary::methods:
      table.header = {"method", "obstacle", "accuracy by", "meaning"};
      for (const auto& [word, meaning] : find_scene_key("method.name")->choices) {
        if (word == automatic) {
          table.rows.push_back({code(word), "as the method chosen", "tolerances", std::string(meaning)});
          continue;
        }
        const MethodName method = method_named(word);
        table.rows.push_back({code(word), std::string(obstacle_words(method)), std::string(accuracy_words(method)),
                              std::string(meaning)});
      }
      break;
    case Vocabulary::masses:
      table.header = {"mass", "meaning"};
      for (const auto& [word, meaning] : find_scene_key("mesh.mass")->choices)
        table.rows.push_back({code(word), std::string(meaning)});
      break;
    case Vocabulary::keys:
      table.header = {"key", "type", "default", "unit", "meaning"};
      for (const SceneKey& key : scene_keys())
        table.rows.push_back(
            {code(key.name), type_words(key), default_words(key), std::string(key.unit), std::string(key.meaning)});
      break;
  }
  table.words = table.header.size();
  return table;
}

std::string vocabulary_json(Vocabulary vocabulary) {
  Json json = Json::array();
  switch (vocabulary) {
    case Vocabulary::methods:
      for (const auto& [word, meaning] : find_scene_key("method.name")->choices) {
        if (word == automatic) {
          json.push_back({{"method", word}, {"meaning", meaning}});
          continue;
        }
        const MethodName method = method_named(word);
        json.push_back({{"method", word},
                        {"penalised", is_penalised(method)},
                        {"uses_tolerances", is_adaptive(method)},
                        {"needs_step", is_scheme(method)},
                        {"meaning", meaning}});
      }
      break;
    case Vocabulary::masses:
      for (const auto& [word, meaning] : find_scene_key("mesh.mass")->choices)
        json.push_back({{"mass", word}, {"meaning", meaning}});
      break;
    case Vocabulary::keys:
      for (const SceneKey& key : scene_keys()) json.push_back(to_json(key));
      break;
  }
  return json.dump();
}

}  // namespace viscobar

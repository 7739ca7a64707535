#include "input/vocabulary.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <nlohmann/json.hpp>
#include <span>
#include <vector>

#include "case/method_table.hpp"

namespace viscobar {

namespace {

using Json = nlohmann::ordered_json;

std::string code(std::string_view word) { return fmt::format("`{}`", word); }

std::string type_words(const SceneKey& key) {
  const std::string_view range = key.range.words;
  const std::string names = fmt::format("`{}`", fmt::join(key.choice_names(), "`, `"));
  switch (key.type) {
    case KeyType::text: return "text";
    case KeyType::choice: return names;
    case KeyType::number: return range.empty() ? "number" : fmt::format("number {}", range);
    case KeyType::count: return fmt::format("whole number {}", range);
    case KeyType::amount: return fmt::format("number {}, or percentage in quotes", range);
    case KeyType::formula:
      return key.variables.size() == 1
                 ? fmt::format("number{}{}, formula in {}, or series", range.empty() ? "" : " ", range, key.variables)
                 : fmt::format("number{}{}, or formula in x and t", range.empty() ? "" : " ", range);
    case KeyType::numbers: return fmt::format("list of numbers {}", range);
    case KeyType::list: return key.choices.empty() ? "list of keys" : "list of " + names;
  }
  return {};
}

std::string default_words(const SceneKey& key) {
  if (key.presence == Presence::required) return "required";
  const std::string value = key.fallback.empty() ? "none" : code(key.fallback);
  if (key.presence == Presence::optional) return value;
  const bool of_joint = key.table() == "joint";
  return fmt::format("required in `{}{}{}`{}", of_joint ? "[[" : "[", key.table(), of_joint ? "]]" : "]",
                     key.fallback.empty() ? "" : ", else " + value);
}

std::string_view accuracy_words(Accuracy accuracy) {
  constexpr std::string_view words[] = {"tolerances", "`method.step`", "rounding"};
  return words[static_cast<std::size_t>(accuracy)];
}

/// A fallback is written as TOML: a text in quotes, or a number.
Json fallback_value(const SceneKey& key) { return key.fallback.empty() ? Json(nullptr) : Json::parse(key.fallback); }

Json to_json(const SceneKey& key) {
  constexpr std::string_view types[] = {"text", "choice", "number", "count", "formula", "list", "amount", "numbers"};
  constexpr std::string_view presences[] = {"always", "in its table", "never"};
  Json json = {{"key", listed_name(key)},
               {"type", types[static_cast<std::size_t>(key.type)]},
               {"required", presences[static_cast<std::size_t>(key.presence)]},
               {"default", fallback_value(key)},
               {"unit", key.unit},
               {"meaning", key.meaning}};
  if (key.type == KeyType::number || key.type == KeyType::count || key.type == KeyType::amount)
    json["limits"] = {{"low", key.range.low}, {"high", key.range.high}};
  if (!key.choices.empty()) json["choices"] = key.choice_names();
  if (key.type == KeyType::formula) json["variables"] = key.variables;
  return json;
}

std::span<const Choice> choices_of(std::string_view key) { return find_scene_key(key)->choices; }

/// True if the scene of the template has the key; the other keys are commented out.
bool is_given(const SceneKey& key) {
  constexpr std::string_view given[] = {"title",         "bar.length",           "bar.viscosity",    "left.kind",
                                        "left.gap",      "right.kind",           "right.gap",        "time.end",
                                        "mesh.elements", "initial.displacement", "initial.velocity", "method.name",
                                        "output.every"};
  return std::ranges::find(given, key.name) != std::end(given);
}

/// Lines of at most 100 characters that begin with "# ".
std::string comment(std::string_view text) {
  constexpr std::size_t width = 98;
  std::string lines;
  while (!text.empty()) {
    std::size_t end = text.size();
    if (end > width && (end = text.rfind(' ', width)) == text.npos) end = std::min(text.find(' '), text.size());
    lines += fmt::format("# {}\n", text.substr(0, end));
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  return lines;
}

}  // namespace

std::string listed_name(const SceneKey& key) {
  const bool of_member = std::ranges::any_of(member_keys(), [&](const SceneKey& one) { return &one == &key; });
  return of_member ? fmt::format("{}.K.{}", key.table(), key.leaf()) : std::string(key.name);
}

std::vector<const SceneKey*> listed_keys() {
  std::vector<const SceneKey*> all;
  for (const auto keys : {scene_keys(), member_keys()})
    for (const SceneKey& key : keys) all.push_back(&key);
  return all;
}

std::string_view name(Vocabulary vocabulary) {
  constexpr std::string_view names[] = {"methods", "masses", "keys"};
  return names[static_cast<std::size_t>(vocabulary)];
}

Table vocabulary_table(Vocabulary vocabulary) {
  Table table;
  const auto add = [&](std::string_view word, std::initializer_list<std::string_view> cells) {
    auto& row = table.rows.emplace_back(std::vector{code(word)});
    row.insert(row.end(), cells.begin(), cells.end());
  };
  switch (vocabulary) {
    case Vocabulary::methods:
      table.header = {"method", "obstacle", "accuracy by", "meaning"};
      add(automatic, {"as the method chosen", "tolerances", choices_of("method.name").front().meaning});
      for (const MethodRow& method : method_table())
        add(method.name, {method.penalised ? "penalty" : "exact", accuracy_words(method.accuracy), method.meaning});
      break;
    case Vocabulary::masses:
      table.header = {"mass", "meaning"};
      for (const auto& [word, meaning] : choices_of("mesh.mass")) add(word, {meaning});
      break;
    case Vocabulary::keys:
      table.header = {"key", "type", "default", "unit", "meaning"};
      // Keys of which the same is said have one row: those of the two ends, of [bar] and each [[bar]].
      for (const SceneKey* key : listed_keys()) {
        const std::string cells[] = {type_words(*key), default_words(*key), std::string(key->unit),
                                     std::string(key->meaning)};
        const auto same = std::ranges::find_if(
            table.rows, [&](const auto& row) { return std::equal(row.begin() + 1, row.end(), std::begin(cells)); });
        if (same != table.rows.end())
          same->front() += ", " + code(listed_name(*key));
        else
          add(listed_name(*key), {cells[0], cells[1], cells[2], cells[3]});
      }
      break;
  }
  table.words = table.header.size();
  return table;
}

std::string vocabulary_json(Vocabulary vocabulary) {
  Json json = Json::array();
  switch (vocabulary) {
    case Vocabulary::methods:
      json.push_back({{"method", automatic}, {"meaning", choices_of("method.name").front().meaning}});
      for (const MethodRow& method : method_table())
        json.push_back({{"method", method.name},
                        {"penalised", method.penalised},
                        {"uses_tolerances", method.accuracy == Accuracy::tolerances},
                        {"needs_step", method.accuracy == Accuracy::step},
                        {"meaning", method.meaning}});
      break;
    case Vocabulary::masses:
      for (const auto& [word, meaning] : choices_of("mesh.mass"))
        json.push_back({{"mass", word}, {"meaning", meaning}});
      break;
    case Vocabulary::keys:
      for (const SceneKey* key : listed_keys()) json.push_back(to_json(*key));
      break;
  }
  return json.dump();
}

std::string facts(const SceneKey& key) {
  const std::string fallback = default_words(key);
  std::string words = type_words(key);
  words += fallback == "none" ? "; no default" : (fallback.starts_with("required") ? "; " : "; default ") + fallback;
  if (!key.unit.empty() && key.unit != "1") words += fmt::format("; unit: {}", key.unit);
  std::erase(words, '`');
  return words;
}

std::string scene_template() {
  std::string text =
      "# A scene of viscobar. Keys that are commented out are optional. `viscobar check FILE` describes the scene,\n"
      "# `viscobar run FILE` computes it, docs/scene-file.md explains every key. Several bars in line have tables\n"
      "# [[bar]] and [[joint]]: docs/bars-in-line.md.\n\n";
  std::string_view table;
  const auto given_there = [&](const SceneKey& key) { return key.table() == table && is_given(key); };
  for (const SceneKey& key : scene_keys()) {
    if (key.table() != table) {
      table = key.table();
      text += fmt::format("\n{}[{}]\n", std::ranges::any_of(scene_keys(), given_there) ? "" : "#", table);
    }
    text += comment(fmt::format("{} ({})", key.meaning, facts(key)));
    text += fmt::format("{}{} = {}\n", is_given(key) ? "" : "#", key.leaf(),
                        key.example.empty() ? key.fallback : key.example);
  }
  return text;
}

}  // namespace viscobar

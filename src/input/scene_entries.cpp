#include "input/scene_entries.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <tuple>
#include <utility>

#include "input/input_text.hpp"
#include "input/scene_values.hpp"
#include "input/synonyms.hpp"
#include "scene/end_kinds.hpp"
#include "text/printable_text.hpp"
#include "text/utf8.hpp"

namespace viscobar {

namespace {

constexpr std::string_view override_source = "--set";

// The text of a sweep's scene is read again and again.
const TomlDocument& document_of(const std::string& text) {
  thread_local std::optional<std::pair<std::string, TomlDocument>> last;
  if (!last || last->first != text) {
    last.reset();  // of a text that is none nothing is kept
    last.emplace(text, parse_toml(text));
  }
  return last->second;
}

// The values of keys that are absent, in the order of scene_keys().
const TomlValue& fallback_of(const SceneKey& key) {
  static const std::vector<TomlValue> values = [] {
    std::vector<TomlValue> all;
    for (const SceneKey& one : scene_keys()) all.push_back(value_of(one.fallback));
    return all;
  }();
  return values[static_cast<std::size_t>(&key - scene_keys().data())];
}

// Not by fmt::join, where gcc 12 warns of an overflow that does not happen.
std::string listed(std::span<const std::string_view> names) {
  std::string all;
  for (const std::string_view name : names) all.append(all.empty() ? "" : ", ").append(name);
  return all;
}

std::string suggestion(const SceneKey* nearest, std::string_view table) {
  if (nearest) return fmt::format("; nearest is \"{}\"", nearest->table() == table ? nearest->leaf() : nearest->name);
  std::vector<std::string_view> siblings;
  for (const SceneKey& key : scene_keys())
    if (key.table() == table) siblings.push_back(key.leaf());
  return fmt::format("; known here: {}", listed(siblings));
}

}  // namespace

std::string unknown_key(std::string_view table, std::string_view leaf) {
  if (!table.empty() && !is_scene_table(table)) {
    const auto nearest = meant_name(table, scene_tables());
    return nearest ? fmt::format("unknown table; nearest is [{}]", *nearest)
                   : fmt::format("unknown table; known are {}", listed(scene_tables()));
  }
  return "unknown key" + suggestion(nearest_scene_key(table, leaf), table);
}

SceneEntries::SceneEntries(const std::string& text, const std::string& source, std::span<const std::string> overrides)
    : end_{source, {}} {
  add_text(text);
  for (const std::string& override_text : overrides) add_override(override_text);
  drop_what_no_longer_belongs();
  check_values();
  if (readable_) fill_in();
}

void SceneEntries::add_text(const std::string& text) {
  const TomlDocument* read = nullptr;
  try {
    read = &document_of(text);
  } catch (const TextError& error) {
    readable_ = false;
    report_at({end_.source, error.at}, "", error.what());
    return;
  }
  const TomlDocument& document = *read;
  end_.at = position_in(text, text.size());

  // A misspelt table or key stands for the one it resembles, unless that one is there, too: so its values are checked,
  // and nothing counts as missing.
  std::map<std::string, std::string> meant{{"", ""}};
  for (const TomlTable& table : document.tables)
    if (is_scene_table(table.name)) tables_[meant[table.name] = table.name] = {end_.source, table.at};
  for (const TomlTable& table : document.tables) {
    if (is_scene_table(table.name)) continue;
    const auto nearest = meant_name(table.name, scene_tables());
    report_unknown_table({end_.source, table.at}, table.name, nearest);
    if (nearest && tables_.try_emplace(std::string(*nearest), Place{end_.source, table.at}).second)
      meant[table.name] = *nearest;
  }
  for (const bool known : {true, false})
    for (const TomlEntry& entry : document.entries)
      if (const auto table = meant.find(entry.table); table != meant.end())
        if (known == (find_scene_key(table->second, entry.key) != nullptr)) add(entry, table->second, end_.source);
}

void SceneEntries::add_override(const std::string& text) {
  const std::string source(override_source);
  if (!is_utf8(text)) return report_at({source, {}}, "", "is not UTF-8 text");
  const std::size_t equals = text.find('=');
  const std::string_view name = trimmed(std::string_view(text).substr(0, equals));
  if (equals == text.npos || name.empty())
    return report_at({source, {}}, "", fmt::format("\"{}\" does not have the form table.key=value", text));
  const std::string_view value = trimmed(std::string_view(text).substr(equals + 1));
  if (value.empty() && find_scene_key(name)) return unset(name);
  if (value.empty()) return report_at({source, position_in(text, equals + 1)}, std::string(name), "is given no value");
  const auto position = [&](std::string_view part) {
    return position_in(text, static_cast<std::size_t>(part.data() - text.data()));
  };
  const std::size_t dot = name.find('.');
  const std::string table(dot == name.npos ? "" : name.substr(0, dot));
  const Place place{source, position(name)};
  if (!table.empty()) {
    if (!is_scene_table(table))
      return report_unknown_table(place, std::string(name), meant_name(table, scene_tables()));
    tables_.try_emplace(table, place);
  }
  add({table, std::string(name.substr(dot + 1)), value_of(value), place.at, position(value)}, table, source);
}

// As if the scene did not have the key, nor a table that is empty then.
void SceneEntries::unset(std::string_view name) {
  if (const auto entry = entries_.find(name); entry != entries_.end()) entries_.erase(entry);
  const std::string_view table = find_scene_key(name)->table();
  const auto of_table = [&](const auto& entry) { return find_scene_key(entry.first)->table() == table; };
  if (std::none_of(entries_.begin(), entries_.end(), of_table))
    if (const auto empty = tables_.find(table); empty != tables_.end()) tables_.erase(empty);
}

// An end that an override makes another kind leaves behind what the text says of the old one.
void SceneEntries::drop_what_no_longer_belongs() {
  const auto overridden = [](const Entry& entry) { return entry.place.source == override_source; };
  for (const std::string_view end : {"left", "right"}) {
    const auto kind = entries_.find(fmt::format("{}.kind", end));
    if (kind == entries_.end() || !overridden(kind->second)) continue;
    const auto* word = std::get_if<std::string>(&kind->second.value);
    if (!word || std::ranges::none_of(end_kinds, [&](const EndKind& known) { return known.name == *word; })) continue;
    std::erase_if(entries_, [&](const auto& entry) {
      const SceneKey& key = *find_scene_key(entry.first);
      return key.table() == end && !overridden(entry.second) && key.leaf() != "kind" &&
             !belongs_to_end(*word, key.leaf());
    });
  }
}

void SceneEntries::add(const TomlEntry& entry, std::string_view table, const std::string& source) {
  const Place key_place{source, entry.key_at};
  Entry value{entry.value, {source, entry.value_at}};
  if (const SceneKey* key = find_scene_key(table, entry.key)) {
    const std::string name = table == "parameters" ? fmt::format("parameters.{}", entry.key) : std::string(key->name);
    entries_.insert_or_assign(name, std::move(value));
  } else if (table.empty() && is_scene_table(entry.key)) {
    report_at(key_place, entry.key,
              source == override_source
                  ? fmt::format("is a table; its keys are set one by one, like {}.key=value", entry.key)
                  : fmt::format("must be a table, written [{}]; is {}", entry.key, kind_of(entry.value)));
    for (const SceneKey& own : scene_keys())
      if (own.table() == entry.key) faulty_.emplace(own.name);
  } else {
    const SceneKey* nearest = nearest_scene_key(table, entry.key);
    report_at(key_place, entry.table.empty() ? entry.key : entry.table + "." + entry.key,
              nearest && nearest->name == entry.key
                  ? fmt::format("unknown key; write {} below [{}], or {} without quotes", nearest->leaf(),
                                nearest->table(), nearest->name)
                  : "unknown key" + suggestion(nearest, table));
    if (nearest) entries_.try_emplace(std::string(nearest->name), std::move(value));
  }
}

void SceneEntries::check_values() {
  for (const auto& [name, entry] : entries_)
    if (is_parameter(name)) {
      const std::string of_name = parameter_name_problem(std::string_view(name).substr(name.find('.') + 1));
      const std::string problem = of_name.empty() ? problem_with(*find_scene_key(name), entry.value) : of_name;
      if (!problem.empty()) report(name, problem);
    }
  const Parameters known = parameters();
  for (const auto& [name, entry] : entries_) {
    if (is_parameter(name)) continue;
    const std::string problem = problem_with(*find_scene_key(name), entry.value, known);
    if (!problem.empty()) report(name, problem);
  }
}

void SceneEntries::fill_in() {
  for (const SceneKey& key : scene_keys()) {
    if (present(key.name) || faulty(key.name)) continue;
    const bool table_is_there = tables_.contains(key.table());
    if (key.presence == Presence::required || (key.presence == Presence::required_in_table && table_is_there))
      report(key.name, fmt::format("is missing: {}", key.meaning));
    else if (!key.fallback.empty())
      filled_in_.emplace(key.name), entries_.emplace(key.name, Entry{fallback_of(key), place_of(key.name)});
  }
}

std::optional<double> SceneEntries::number(std::string_view key) const {
  const TomlValue* value = sound_value(key);
  return value ? number_of(*value) : std::nullopt;
}

std::optional<std::string> SceneEntries::text(std::string_view key) const {
  const TomlValue* value = sound_value(key);
  return value ? std::optional(std::get<std::string>(*value)) : std::nullopt;
}

std::optional<Formula> SceneEntries::formula(std::string_view key) const {
  const TomlValue* value = sound_value(key);
  if (!value) return std::nullopt;
  if (const auto number = number_of(*value)) return Formula(*number);
  return Formula(std::get<std::string>(*value), find_scene_key(key)->variables, parameters());
}

std::vector<std::string> SceneEntries::list(std::string_view key) const {
  const TomlValue* value = sound_value(key);
  return value ? std::get<std::vector<std::string>>(*value) : std::vector<std::string>{};
}

Parameters SceneEntries::parameters() const {
  Parameters known;
  for (const auto& [name, entry] : entries_)
    if (is_parameter(name) && !faulty(name)) known[name.substr(name.find('.') + 1)] = *number(name);
  return known;
}

const TomlValue* SceneEntries::sound_value(std::string_view key) const {
  const auto entry = entries_.find(key);
  return entry == entries_.end() || faulty(key) ? nullptr : &entry->second.value;
}

SceneEntries::Place SceneEntries::place_of(std::string_view key) const {
  if (const auto entry = entries_.find(key); entry != entries_.end()) return entry->second.place;
  const auto table = tables_.find(key.substr(0, key.find('.')));
  return table == tables_.end() ? end_ : table->second;
}

void SceneEntries::report(std::string_view key, const std::string& message) {
  faulty_.emplace(key);
  report_at(place_of(key), std::string(key), message);
}

void SceneEntries::report_unknown_table(const Place& place, const std::string& key,
                                        std::optional<std::string_view> nearest) {
  report_at(place, key,
            nearest ? fmt::format("unknown table; nearest is [{}]", *nearest)
                    : fmt::format("unknown table; known are {}", listed(scene_tables())));
}

void SceneEntries::report_at(const Place& place, const std::string& key, const std::string& message) {
  found_.push_back({place.source, place.at.line, place.at.column, one_line(key), one_line(message)});
}

std::vector<Diagnostic> SceneEntries::diagnostics() const {
  std::vector<Diagnostic> sorted = found_;
  std::stable_sort(sorted.begin(), sorted.end(), [](const Diagnostic& a, const Diagnostic& b) {
    const auto rank = [](const Diagnostic& found) {
      const bool from_override = found.source == override_source;
      return from_override ? std::tuple(true, std::size_t{0}, std::size_t{0})
                           : std::tuple(false, found.line, found.column);
    };
    return rank(a) < rank(b);
  });
  return sorted;
}

}  // namespace viscobar

#include "input/scene_values.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <tuple>
#include <utility>

#include "input/input_text.hpp"
#include "input/synonyms.hpp"
#include "scene/end_kinds.hpp"
#include "text/printable_text.hpp"
#include "text/utf8.hpp"

namespace viscobar {

namespace {

constexpr std::string_view override_source = "--set";

// A number as TOML writes it, without underscores: most values of a sweep are.
std::optional<TomlValue> plain_number(std::string_view text) {
  const std::size_t digits = text.starts_with('-') ? 1 : 0;
  if (text.size() > 20 || text.find_first_not_of("0123456789.e-", digits) != text.npos) return std::nullopt;
  const std::size_t point = text.find('.'), exponent = text.find('e');
  const std::string_view whole = text.substr(digits, std::min({point, exponent, text.size()}) - digits);
  if (whole.empty() || (whole.size() > 1 && whole.front() == '0') || whole.find('-') != whole.npos) return std::nullopt;
  if (point != text.npos && (point + 1 == text.size() || text[point + 1] == 'e')) return std::nullopt;
  const char* const end = text.data() + text.size();
  if (point == text.npos && exponent == text.npos) {
    std::int64_t value = 0;
    const auto [at, error] = std::from_chars(text.data(), end, value);
    return error == std::errc() && at == end ? std::optional<TomlValue>(value) : std::nullopt;
  }
  double value = 0.0;
  const auto [at, error] = std::from_chars(text.data(), end, value);
  return error == std::errc() && at == end ? std::optional<TomlValue>(value) : std::nullopt;
}

// The text of a sweep's scene is read again and again.
const TomlDocument& document_of(const std::string& text) {
  thread_local std::optional<std::pair<std::string, TomlDocument>> last;
  if (!last || last->first != text) {
    last.reset();  // of a text that is none nothing is kept
    last.emplace(text, parse_toml(text));
  }
  return last->second;
}

// A TOML value, or else the text itself.
TomlValue value_of(std::string_view text) {
  if (auto number = plain_number(text)) return *std::move(number);
  try {
    const TomlDocument document = parse_toml("value = " + std::string(text));
    if (document.tables.empty() && document.entries.size() == 1) return document.entries.front().value;
  } catch (const TextError&) {  // a bare string
  }
  return std::string(text);
}

}  // namespace

std::string_view kind_of(const TomlValue& value) {
  constexpr std::string_view kinds[] = {"a string", "a whole number", "a number", "a boolean", "", "an array"};
  const auto* other = std::get_if<OtherValue>(&value);
  return other ? other->what : kinds[value.index()];
}

namespace {

std::optional<double> number_of(const TomlValue& value) {
  if (const auto* integer = std::get_if<std::int64_t>(&value)) return static_cast<double>(*integer);
  if (const auto* number = std::get_if<double>(&value)) return *number;
  return std::nullopt;
}

std::string suggestion(const SceneKey* nearest, std::string_view table) {
  if (nearest) return fmt::format("; nearest is \"{}\"", nearest->table() == table ? nearest->leaf() : nearest->name);
  std::vector<std::string_view> siblings;
  for (const SceneKey& key : scene_keys())
    if (key.table() == table) siblings.push_back(key.leaf());
  return fmt::format("; known here: {}", fmt::join(siblings, ", "));
}

std::string range_problem(const Range& range, double value) {
  if (!std::isfinite(value)) return fmt::format("must be finite, is {}", value);
  if (value < range.low) {
    if (range.low == 0.0) return fmt::format("must not be negative, is {}", value);
    if (value <= 0.0 && range.low < 1.0) return fmt::format("must be positive, is {}", value);
    return fmt::format("must be at least {}, is {}", range.low, value);
  }
  if (value > range.high) return fmt::format("must be at most {}, is {}", range.high, value);
  return {};
}

// What to do about a text where a number belongs.
std::string number_advice(const std::string& text) {
  const TomlValue inside = value_of(text);
  if (std::holds_alternative<std::int64_t>(inside) || std::holds_alternative<double>(inside))
    return "; leave the quotes out";
  if (std::count(text.begin(), text.end(), ',') == 1 && text.find_first_not_of("0123456789+-,eE") == text.npos)
    return "; write it without quotes, with a decimal point";
  if (text.find_first_of("*/^()") != text.npos)
    return "; formulas are for initial data, loads, and what moves the ends";
  const std::size_t after = text.find_first_not_of("0123456789+-.eE");
  if (after == text.npos && text.size() > 18) return "; it is too large";
  const auto begins_unit = [](char c) { return c == ' ' || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'); };
  const bool with_unit = after != text.npos && after > 0 && begins_unit(text[after]);
  return with_unit ? "; units are not written: any consistent ones will do" : "";
}

std::string advice_on(const TomlValue& value) {
  const auto* text = std::get_if<std::string>(&value);
  return text ? number_advice(*text) : "";
}

std::string choice_problem(const SceneKey& key, const std::string& value) {
  const std::vector<std::string_view> names = key.choice_names();
  if (std::find(names.begin(), names.end(), value) != names.end()) return {};
  const std::string known = fmt::format("\"{}\"", fmt::join(names, "\", \""));
  const auto nearest = meant_name(value, names);
  return fmt::format("cannot be \"{}\"; {}", value,
                     nearest ? fmt::format("nearest is \"{}\"", *nearest) : "there are " + known);
}

std::string formula_problem(const SceneKey& key, const TomlValue& value, const Parameters& parameters) {
  const auto number_problem = [&key](double number) {
    if (!key.range.words.empty()) return range_problem(key.range, number);
    return std::isfinite(number) ? "" : fmt::format("must be finite, is {}", number);
  };
  if (const auto number = number_of(value)) return number_problem(*number);
  const auto* text = std::get_if<std::string>(&value);
  if (!text) return fmt::format("must be a number or a formula in quotes, is {}", kind_of(value));
  try {
    const Formula formula(*text, key.variables, parameters);
    if (formula.is_constant()) return number_problem(formula.constant());
  } catch (const FormulaError& error) {
    return error.what();
  }
  return {};
}

std::string list_problem(const SceneKey& key, const TomlValue& value) {
  const auto* words = std::get_if<std::vector<std::string>>(&value);
  if (!words)
    return fmt::format(
        "must be a list of strings, such as {}, is {}",
        key.choices.empty() ? "[\"bar.viscosity\", \"left.gap\"]" : fmt::format("[\"{}\"]", key.choices.front().name),
        kind_of(value));
  if (key.choices.empty()) return {};
  for (const std::string& word : *words)
    if (const std::string problem = choice_problem(key, word); !problem.empty()) return "an entry " + problem;
  return {};
}

}  // namespace

std::optional<double> percentage(std::string_view text) {
  if (!text.ends_with('%')) return std::nullopt;
  text = trimmed(text.substr(0, text.size() - 1));
  double value = 0.0;
  const auto [rest, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || rest != text.data() + text.size() || !std::isfinite(value)) return std::nullopt;
  return value / 100.0;
}

std::string problem_with(const SceneKey& key, const TomlValue& value, const Parameters& parameters) {
  switch (key.type) {
    case KeyType::text:
    case KeyType::choice:
      if (const auto* text = std::get_if<std::string>(&value))
        return key.type == KeyType::text ? "" : choice_problem(key, *text);
      return fmt::format("must be a string, is {}", kind_of(value));
    case KeyType::count:
      if (std::holds_alternative<double>(value)) return "must be a whole number, written without point or exponent";
      [[fallthrough]];
    case KeyType::number:
      if (const auto number = number_of(value)) return range_problem(key.range, *number);
      return fmt::format("must be a {}, is {}{}", key.type == KeyType::count ? "whole number" : "number",
                         kind_of(value), advice_on(value));
    case KeyType::amount: {
      if (const auto number = number_of(value)) return range_problem(key.range, *number);
      const auto* text = std::get_if<std::string>(&value);
      const auto share = text ? percentage(*text) : std::nullopt;
      if (!share)
        return fmt::format("must be a number, or a percentage such as \"0.01 %\", is {}",
                           text ? fmt::format("\"{}\"", *text) : std::string(kind_of(value)));
      return *share > 0.0 && *share <= 1.0 ? ""
                                           : fmt::format("must be more than 0 and at most 100 %, is \"{}\"", *text);
    }
    case KeyType::formula: return formula_problem(key, value, parameters);
    case KeyType::list: return list_problem(key, value);
  }
  return {};
}

std::string unknown_key(std::string_view table, std::string_view leaf) {
  if (!table.empty() && !is_scene_table(table)) {
    const auto nearest = meant_name(table, scene_tables());
    return nearest ? fmt::format("unknown table; nearest is [{}]", *nearest)
                   : fmt::format("unknown table; known are {}", fmt::join(scene_tables(), ", "));
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
      filled_in_.emplace(key.name), entries_.emplace(key.name, Entry{value_of(key.fallback), place_of(key.name)});
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
                    : fmt::format("unknown table; known are {}", fmt::join(scene_tables(), ", ")));
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

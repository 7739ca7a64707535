#include "input/scene_entries.hpp"

#include <algorithm>
#include <mutex>
#include <optional>
#include <tuple>
#include <utility>

#include "input/described_scene.hpp"
#include "input/input_text.hpp"
#include "input/scene_chain.hpp"
#include "input/scene_values.hpp"
#include "scene/end_kinds.hpp"
#include "scene/unit_names.hpp"
#include "text/number.hpp"
#include "text/printable_text.hpp"

namespace viscobar {

namespace {

constexpr std::string_view override_source = "--set";
// The place of a value that comes as such, and not as the text of an option.
constexpr TextPosition nowhere{0, 0};

std::size_t index_of(const SceneKey& key) { return static_cast<std::size_t>(&key - scene_keys().data()); }

// The values of keys that are absent, in the order of scene_keys().
const TomlValue& fallback_of(const SceneKey& key) {
  static const std::vector<TomlValue> values = [] {
    std::vector<TomlValue> all;
    for (const SceneKey& one : scene_keys()) all.push_back(one.fallback.empty() ? TomlValue() : value_of(one.fallback));
    return all;
  }();
  return values[index_of(key)];
}

// Not by fmt::join, where gcc 12 warns of an overflow that does not happen.
std::string listed(std::span<const std::string_view> names) {
  std::string all;
  for (const std::string_view name : names) all.append(all.empty() ? "" : ", ").append(name);
  return all;
}

std::string suggestion(const SceneKey* nearest, std::string_view table) {
  const bool of_member = is_member_table(table);
  if (of_member) table = table.substr(0, table.find('.'));
  if (nearest) return fmt::format("; nearest is \"{}\"", nearest->table() == table ? nearest->leaf() : nearest->name);
  std::vector<std::string_view> siblings;
  for (const SceneKey& key : of_member ? member_keys() : scene_keys())
    if (key.table() == table) siblings.push_back(key.leaf());
  return fmt::format("; known here: {}", listed(siblings));
}

std::string unknown_table(std::string_view table) {
  const auto nearest = meant_name(table, scene_tables());
  return nearest ? fmt::format("unknown table; nearest is [{}]", *nearest)
                 : fmt::format("unknown table; known are {}", listed(scene_tables()));
}

// Examples of the first two keys of a table within a table.
std::string inner_example(std::string_view inner) {
  std::string all;
  for (const SceneKey& key : scene_keys())
    if (key.name.starts_with(inner) && all.find(',') == all.npos)
      all += fmt::format("{}{} = {}", all.empty() ? "" : ", ", key.name.substr(inner.size() + 1), key.example);
  return all;
}

// Entries of a table, those of a table within it by their keys "inner.leaf".
std::vector<TomlNode> flat(const std::vector<TomlNode>& entries, const std::string& table) {
  std::vector<TomlNode> all;
  for (const TomlNode& entry : entries) {
    if (entry.inside.empty() || !is_inner_table(table + "." + entry.key)) {
      all.push_back(entry);
      continue;
    }
    for (TomlNode inside : entry.inside) {
      inside.key = entry.key + "." + inside.key;
      all.push_back(std::move(inside));
    }
  }
  return all;
}

}  // namespace

std::string unknown_key(std::string_view table, std::string_view leaf) {
  if (!table.empty() && !is_scene_table(table)) return unknown_table(table);
  return "unknown key" + suggestion(nearest_scene_key(table, leaf), table);
}

SceneEntries::SceneEntries(const std::string& text, const std::string& source) : end_{source, {}} { add_text(text); }

// The text of a sweep's scene is read once for all of its threads.
std::shared_ptr<const SceneEntries> SceneEntries::of_text(const std::string& text, const std::string& source) {
  static std::mutex mutex;
  static std::pair<std::string, std::shared_ptr<const SceneEntries>> last;
  const std::lock_guard lock(mutex);
  if (!last.second || last.first != text || last.second->end_.source != source)
    last = {text, std::shared_ptr<const SceneEntries>(new SceneEntries(text, source))};
  return last.second;
}

SceneEntries::SceneEntries(const std::string& text, const std::string& source, std::span<const Setting> settings)
    : SceneEntries(*of_text(text, source)) {
  for (const Setting& setting : settings)
    if (const auto* override_text = std::get_if<std::string>(&setting))
      add_override(*override_text);
    else
      std::visit(
          [&, &name = std::get<1>(setting).first](const auto& value) { lay_over(name, value, nowhere, nowhere); },
          std::get<1>(setting).second);
  drop_what_no_longer_belongs();
  check_values();
  if (readable_) fill_in();
}

void SceneEntries::add_text(const std::string& text) {
  TomlNode read;
  try {
    read = scene_tree(text);
  } catch (const TextError& error) {
    readable_ = false;
    report_at({end_.source, error.at}, "", error.what());
    return;
  }
  end_.at = position_in(text, text.size());
  const auto named = [&](std::string_view key) { return std::ranges::find(read.inside, key, &TomlNode::key); };
  for (const char* key : {"vary", "scene"})
    if (const auto node = named(key); node != read.inside.end() && named("bar") == read.inside.end()) {
      readable_ = false;
      return report_at({end_.source, node->key_at}, "",
                       "this is a sweep, which names a scene: `viscobar sweep` runs it");
    }
  number_members(read);

  // A misspelt table or key stands for the one it resembles, unless that one is there, too: so its values are checked,
  // and nothing counts as missing.
  std::map<std::string, std::string> meant;
  const auto is_table = [](const TomlNode& node) { return node.kind == TomlNode::Kind::table; };
  for (const TomlNode& table : read.inside)
    if (is_table(table) && is_scene_table(table.key))
      tables_[meant[table.key] = table.key] = {end_.source, table.value_at};
  for (const TomlNode& table : read.inside) {
    if (!is_table(table) || is_scene_table(table.key)) continue;
    const Place place{end_.source, table.value_at};
    report_at(place, table.key, unknown_table(table.key));
    if (const auto nearest = meant_name(table.key, scene_tables()))
      if (tables_.try_emplace(std::string(*nearest), place).second) meant[table.key] = *nearest;
  }
  for (const bool known : {true, false}) {
    const auto add_if_known = [&](const TomlNode& entry, const std::string& written, const std::string& table) {
      if (known == (find_scene_key(table, entry.key) != nullptr)) add(entry, written, table, end_.source);
    };
    for (const TomlNode& node : read.inside)
      if (node.is_list_of_tables() && !is_scene_table(node.key)) {
        if (known)
          report_at({end_.source, node.key_at}, node.key,
                    "unknown table; those of which there may be several are [[bar]] and [[joint]]");
      } else if (!is_table(node)) {
        add_if_known(node, "", "");
      } else if (const auto table = meant.find(node.key); table != meant.end()) {
        for (const TomlNode& entry : flat(node.inside, table->second)) add_if_known(entry, node.key, table->second);
      }
  }
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
  lay_over(std::string(name), value_of(value), position(name), position(value));
}

void SceneEntries::lay_over(const std::string& name, TomlValue value, TextPosition key_at, TextPosition value_at) {
  if (const auto* inner = std::get_if<SceneTable>(&value); inner && is_inner_table(name)) {
    for (const auto& [leaf, entry] : *inner)
      std::visit([&, &key = leaf](const auto& one) { lay_over(name + "." + key, one, key_at, value_at); }, entry);
    return;
  }
  const std::string source(override_source);
  const std::string table(table_of(name));
  const Place place{source, key_at};
  if (!table.empty()) {
    if (!is_scene_table(table)) return report_at(place, name, unknown_table(table));
    tables_.try_emplace(table, place);
  }
  TomlNode entry;
  entry.key = name.substr(table.size() + (name.size() > table.size() && name[table.size()] == '.' ? 1 : 0));
  entry.value = std::move(value);
  entry.key_at = key_at;
  entry.value_at = value_at;
  add(entry, table, table, source);
}

// As if the scene did not have the key, nor a table that is empty then.
void SceneEntries::unset(std::string_view name) {
  entries_.erase(std::string(name));
  const std::string_view table = table_of(name);
  const auto of_table = [&](const auto& entry) { return table_of(entry.first) == table; };
  if (std::none_of(entries_.begin(), entries_.end(), of_table)) tables_.erase(std::string(table));
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

void SceneEntries::add(const TomlNode& entry, const std::string& written, std::string_view table,
                       const std::string& source) {
  const Place key_place{source, entry.key_at};
  Entry value{entry.value, {source, entry.value_at}};
  if (const SceneKey* key = find_scene_key(table, entry.key)) {
    const bool named = table == "parameters" || is_member_table(table);
    const std::string name = named ? fmt::format("{}.{}", table, entry.key) : std::string(key->name);
    entries_.insert_or_assign(name, std::move(value));
  } else if (table.empty() && is_scene_table(entry.key)) {
    report_at(key_place, entry.key,
              source == override_source
                  ? fmt::format("is a table; its keys are set one by one, like {}.key=value", entry.key)
                  : fmt::format("must be a table, written [{}]; is {}", entry.key, kind_of(entry.value)));
    for (const SceneKey& own : scene_keys())
      if (own.table() == entry.key) faulty_.emplace(own.name);
  } else if (const std::string inner = fmt::format("{}.{}", table, entry.key); is_inner_table(inner)) {
    report_at(key_place, inner,
              fmt::format("must be a table, such as {{ {} }}; is {}", inner_example(inner), kind_of(entry.value)));
    for (const SceneKey& own : scene_keys())
      if (own.name.starts_with(inner + ".")) faulty_.emplace(own.name);
  } else {
    const SceneKey* nearest =
        nearest_scene_key(table, entry.key, [&](const SceneKey& one) { return takes(one.type, entry.value); });
    report_at(key_place, written.empty() ? entry.key : written + "." + entry.key,
              nearest && nearest->name == entry.key
                  ? fmt::format("unknown key; write {} below [{}], or {} without quotes", nearest->leaf(),
                                nearest->table(), nearest->name)
                  : "unknown key" + suggestion(nearest, table));
    if (!nearest) return;
    if (!is_member_table(table))
      entries_.try_emplace(std::string(nearest->name), std::move(value));
    else if (table.starts_with(nearest->table()))  // no other bar or joint is meant
      entries_.try_emplace(fmt::format("{}.{}", table, nearest->leaf()), std::move(value));
  }
}

void SceneEntries::check_values() {
  const auto check = [&](const std::string& name, const Entry& entry, const Parameters& known) {
    const SceneKey& key = *find_scene_key(name);
    std::string problem = is_parameter(name) ? parameter_name_problem(parameter_name(name)) : "";
    if (problem.empty()) problem = problem_with(key, entry.value, known);
    if (!problem.empty()) return report(name, problem);
    if (const auto* table = std::get_if<SceneTable>(&entry.value)) read_series(name, *table);
  };
  for (const auto& [name, entry] : entries_)
    if (is_parameter(name)) check(name, entry, {});
  const Parameters known = parameters();
  for (const auto& [name, entry] : entries_)
    if (!is_parameter(name)) check(name, entry, known);
}

Units SceneEntries::units() const {
  const auto unit = [&](const char* of) {
    const auto entry = entries_.find(of);
    const auto* text = entry == entries_.end() ? nullptr : std::get_if<std::string>(&entry->second.value);
    return text ? *text : std::string();
  };
  const bool of_section =
      std::ranges::any_of(entries_, [](const auto& entry) { return entry.first.ends_with(".section"); });
  return {unit("units.length"), unit("units.time"),   unit("units.mass"),
          unit("units.force"),  unit("units.stress"), of_section};
}

void SceneEntries::read_series(const std::string& name, const SceneTable& table) {
  const SceneKey& key = *find_scene_key(name);
  const Units units = this->units();
  SeriesRequest request;
  request.variable = key.variables.front();
  request.jumps = key.leaf() != "motion";
  if (const auto powers = unit_powers(key.unit)) request.unit = unit_name(units, *powers);
  if (key.unit == "1") request.unit = key.unit;  // a column with a unit is of another size
  request.place_unit = request.variable == 't' ? units.time : units.length;
  for (const std::string* unit : {&units.length, &units.time, &units.mass, &units.force, &units.stress})
    request.names_units |= !unit->empty();
  request.folder = folder();
  try {
    series_[name] = series_of(table, request);
  } catch (const SceneError& error) {
    for (const Diagnostic& found : error.diagnostics)
      report(name, "{}{}: {}{}{}", found.source, found.line > 0 ? fmt::format(", line {}", found.line) : "", found.key,
             found.key.empty() ? "" : " ", found.message);
  } catch (const std::invalid_argument& error) {
    report(name, error.what());
  }
}

std::shared_ptr<const Series> SceneEntries::series(std::string_view key) const {
  const auto found = series_.find(key);
  return found == series_.end() || faulty(key) ? nullptr : found->second;
}

std::vector<std::string> SceneEntries::series_keys() const {
  std::vector<std::string> keys;
  for (const auto& [key, series] : series_)
    if (!faulty(key)) keys.push_back(key);
  return keys;
}

SceneValue SceneEntries::described(std::string_view key) const {
  if (series(key)) {
    SceneTable table = std::get<SceneTable>(value(key));
    if (const auto file = table.find("file"); file != table.end()) {
      file->second =
          std::filesystem::absolute(folder() / std::get<std::string>(file->second)).lexically_normal().string();
      table["checksum"] = fmt::format("{:016x}", series(key)->checksum());
    }
    return table;
  }
  if (const auto* text = std::get_if<std::string>(&value(key))) return *text;
  const KeyType type = find_scene_key(key)->type;
  if (type == KeyType::list) return list(key);
  if (type == KeyType::numbers) return numbers(key);
  return *number(key);
}

void SceneEntries::fill_in() {
  std::vector<const TomlValue*> in_force(scene_keys().size(), nullptr);
  for (const auto& [name, entry] : entries_)
    if (const SceneKey* key = find_plain_key(name)) in_force[index_of(*key)] = &entry.value;
  for (const SceneKey& key : scene_keys()) {
    const TomlValue*& value = in_force[index_of(key)];
    if (!value && !faulty(key.name)) {
      if ((key.presence == Presence::required && !(key.table() == "bar" && members("bar") > 0)) ||
          (key.presence == Presence::required_in_table && tables_.contains(key.table())))
        report(key.name, "is missing: {}", key.meaning);
      else if (!key.fallback.empty())
        value = &fallback_of(key);
    }
  }
  in_force_ = std::move(in_force);
}

std::size_t SceneEntries::members(std::string_view table) const {
  // A key that is set makes no bar of its own, but for the length or the mass.
  const auto is_there = [&](const std::string& member) {
    const auto found = tables_.find(member);
    return found != tables_.end() && (table != "bar" || found->second.source != override_source ||
                                      given(member + ".length") || given(member + ".mass"));
  };
  std::size_t count = 0;
  while (is_there(fmt::format("{}.{}", table, count + 1))) ++count;
  return count;
}

void SceneEntries::report_members_apart() {
  for (const auto& [name, place] : tables_) {
    if (!is_member_table(name)) continue;
    const std::string_view table = std::string_view(name).substr(0, name.find('.'));
    const std::size_t count = members(table);
    if (std::stoul(name.substr(table.size() + 1)) > count)
      report_at(place, name,
                fmt::format("there {} {} [[{}]]", count == 1 ? "is" : "are", counted(count, "table"), table));
  }
}

const TomlValue* SceneEntries::find(std::string_view key) const {
  if (!in_force_.empty())
    if (const SceneKey* known = find_plain_key(key)) return in_force_[index_of(*known)];
  const auto entry = entries_.find(key);
  return entry == entries_.end() ? nullptr : &entry->second.value;
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
  if (const auto series = this->series(key)) return Formula(series, find_scene_key(key)->variables.front());
  return Formula(std::get<std::string>(*value), find_scene_key(key)->variables, parameters());
}

std::vector<std::string> SceneEntries::list(std::string_view key) const {
  const TomlValue* value = sound_value(key);
  return value ? std::get<std::vector<std::string>>(*value) : std::vector<std::string>{};
}

std::vector<double> SceneEntries::numbers(std::string_view key) const {
  const TomlValue* value = sound_value(key);
  return value ? *numbers_of(*value) : std::vector<double>{};
}

Parameters SceneEntries::parameters() const {
  Parameters known;
  for (const auto& [name, entry] : entries_)
    if (is_parameter(name) && !faulty(name)) known.emplace(parameter_name(name), *number(name));
  return known;
}

const TomlValue* SceneEntries::sound_value(std::string_view key) const { return faulty(key) ? nullptr : find(key); }

SceneEntries::Place SceneEntries::place_of(std::string_view key) const {
  if (const auto entry = entries_.find(key); entry != entries_.end()) return entry->second.place;
  const auto table = tables_.find(table_of(key));
  return table == tables_.end() ? end_ : table->second;
}

void SceneEntries::report(std::string_view key, const std::string& message) {
  faulty_.emplace(key);
  report_at(place_of(key), std::string(key), message);
}

void SceneEntries::report_at(const Place& place, const std::string& key, const std::string& message) {
  found_.push_back({place.source, place.at.line, place.at.column, one_line(key), one_line(message)});
}

std::vector<Diagnostic> SceneEntries::diagnostics() const {
  std::vector<Diagnostic> sorted = found_;
  std::ranges::stable_sort(sorted, {}, [](const Diagnostic& found) {
    const bool from_override = found.source == override_source;
    return from_override ? std::tuple(true, std::size_t{0}, std::size_t{0})
                         : std::tuple(false, found.line, found.column);
  });
  return sorted;
}

LoadFormulas::LoadFormulas(const SceneEntries& entries)
    : density(entries.formula("load.density")),
      profile(entries.formula("load.profile")),
      history(entries.formula("load.history")) {
  const auto factors = density ? density->factors() : std::nullopt;
  if (!factors) return;
  density.reset();
  profile = factors->first, history = factors->second;
}

}  // namespace viscobar

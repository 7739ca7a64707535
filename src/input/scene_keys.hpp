#pragma once

#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace viscobar {

/// An amount is a number, or a percentage as a text.
enum class KeyType { text, choice, number, count, formula, list, amount, numbers };

/// True if a key has to be there: in every scene, where its table is, or nowhere.
enum class Presence { required, required_in_table, optional };

struct KeyRange {
  double low, high;
  std::string_view words;
};

struct Choice {
  std::string_view name, meaning;
};

/// The law of a stop that has none of its own.
inline constexpr std::string_view no_law = "penalty";

/// All that is said about one key of a scene file. Reading, checking, suggesting and documenting go by this table.
struct SceneKey {
  std::string_view name;  ///< "table.key", or a key above the first table
  KeyType type;
  Presence presence;
  std::string_view fallback;  ///< value when the key is absent, as TOML; empty: none
  std::string_view example;   ///< in the scene of `viscobar new`; empty: the fallback
  std::string_view unit;
  std::string_view meaning;
  KeyRange range{};                   ///< of a number or count, or of a formula where it is a number
  std::span<const Choice> choices{};  ///< of a choice, or of the words of a list
  std::string_view variables{};       ///< of a formula: "x", "t" or "xt"

  std::string_view table() const;  ///< empty above the first table
  std::string_view leaf() const;   ///< the key within its table
  std::vector<std::string_view> choice_names() const;
};

std::span<const SceneKey> scene_keys();

/// Those of the tables [[bar]] and [[joint]] of several bars in line, as "bar.length".
std::span<const SceneKey> member_keys();

/// The key as lists name it: "bar.length" of [bar], "bar.K.length" of the K-th table [[bar]].
std::string listed_name(const SceneKey& key);
/// The keys of scene_keys(), then those of member_keys().
std::vector<const SceneKey*> listed_keys();
/// True if that is the name of a key of one of them, "bar.2.length".
bool is_member_key(std::string_view name);
/// True if that names such a table, "bar.2".
bool is_member_table(std::string_view name);
/// The table of a key by its full name: "bar" of "bar.length", "bar.2" of "bar.2.length"; empty above the first one.
std::string_view table_of(std::string_view name);

/// The key of this full name; nullptr when there is none. All of [parameters] are the one row parameters.NAME, those of
/// all tables [[bar]] the rows of one.
const SceneKey* find_scene_key(std::string_view name);
const SceneKey* find_scene_key(std::string_view table, std::string_view leaf);
const SceneKey* find_plain_key(std::string_view name);

/// True if keys stand in a table of that name within another one: "left.contact".
bool is_inner_table(std::string_view name);

/// True if that is the name of a parameter, "parameters.NAME" with any NAME.
bool is_parameter(std::string_view name);
std::string_view parameter_name(std::string_view name);

/// Names of the tables, in the order of scene_keys().
std::span<const std::string_view> scene_tables();
bool is_scene_table(std::string_view name);

/// The candidate that `word` was probably meant to be: what papers and other programs call so, or else the nearest by
/// its letters.
std::optional<std::string_view> meant_name(std::string_view word, std::span<const std::string_view> candidates);

/// The key that an unknown one was probably meant to be: the nearest one of the same table, or the one of that name in
/// another table; above the first table, the nearest one of any. One that takes the value comes before others.
const SceneKey* nearest_scene_key(
    std::string_view table, std::string_view leaf,
    const std::function<bool(const SceneKey&)>& takes = [](const SceneKey&) { return true; });

}  // namespace viscobar

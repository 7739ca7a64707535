#pragma once

#include <string>
#include <string_view>

#include "input/scene_keys.hpp"
#include "text/table.hpp"

namespace viscobar {

/// Vocabulary of scene files, in three tables made of listed_keys(): `viscobar list` shows them, docs/scene-file.md
/// holds them. Words that stand in a scene file are marked with backquotes.
enum class Vocabulary { methods, masses, keys };
inline constexpr Vocabulary all_vocabularies[] = {Vocabulary::methods, Vocabulary::masses, Vocabulary::keys};

std::string_view name(Vocabulary vocabulary);
Table vocabulary_table(Vocabulary vocabulary);

/// The same as a JSON array, with the facts behind the words: limits, choices, variables of formulas.
std::string vocabulary_json(Vocabulary vocabulary);

/// Type, default and unit of a key, such as "number > 0; default 1.0; unit: density".
std::string facts(const SceneKey& key);

/// A scene of one bar to start from, sound as it is: every key with its comment out of scene_keys(), those that need
/// not be there commented out, with the default or an example as value.
std::string scene_template();

}  // namespace viscobar

#pragma once

#include <string>
#include <string_view>

#include "text/table.hpp"

namespace viscobar {

/// What a scene file may say, in three tables made of scene_keys(): `viscobar list` shows them, docs/scene-file.md
/// holds them. Words that stand in a scene file are marked with backquotes.
enum class Vocabulary { methods, masses, keys };

std::string_view name(Vocabulary vocabulary);
Table vocabulary_table(Vocabulary vocabulary);

/// The same as a JSON array, with the facts behind the words: limits, choices, variables of formulas.
std::string vocabulary_json(Vocabulary vocabulary);

}  // namespace viscobar

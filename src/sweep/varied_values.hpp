#pragma once

#include <functional>
#include <span>
#include <string>
#include <string_view>

#include "input/formula.hpp"
#include "input/scene_keys.hpp"
#include "input/toml_text.hpp"
#include "viscobar/sweep/sweep.hpp"

namespace viscobar {

/// Notes what is wrong at a place of the text.
using Report = std::function<void(TextPosition at, const std::string& message)>;

const TomlNode* entry_of(const TomlNode& table, std::string_view key);

/// The one of `known` that a word was probably meant to be, or all.
std::string instead_of(std::string_view word, std::span<const std::string_view> known);

/// The values of a key that a sweep varies: a list, or a range
///
///     { from, to, count }                     evenly spaced
///     { from, to, count, spacing = "log" }    in geometric progression
///     { from, to, per_decade }                so many a decade, whole decades from `from` exact
///
/// of numbers; of a key that takes whole numbers they are rounded, and equal ones are taken once.
/// Formulas may use `parameters`. Empty after a report.
VariedKey varied_key(const SceneKey& key, const TomlNode& node, const Parameters& parameters, const Report& report);

}  // namespace viscobar

#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "input/formula.hpp"
#include "input/scene_keys.hpp"
#include "input/toml_text.hpp"

namespace viscobar {

/// Fault of a value of a key by itself; empty if it has none. Formulas may use the parameters.
std::string problem_with(const SceneKey& key, const TomlValue& value, const Parameters& parameters = {});

bool takes(KeyType type, const TomlValue& value);

/// The share that a text such as "0.01 %" means, 1e-4; absent where it is not of that form.
std::optional<double> percentage(std::string_view text);

/// A TOML value, or else the text itself.
TomlValue value_of(std::string_view text);

/// The value of a number, whole or not; absent for other values.
std::optional<double> number_of(const TomlValue& value);

/// Numbers of a list, which may be empty; absent for other values.
std::optional<std::vector<double>> numbers_of(const TomlValue& value);

/// The article and kind of a value, such as "a whole number".
std::string_view kind_of(const TomlValue& value);

}  // namespace viscobar

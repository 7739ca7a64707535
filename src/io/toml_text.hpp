#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "io/text_check.hpp"

namespace viscobar {

/// A value that no key of a scene has; `what` names it with its article.
struct OtherValue {
  std::string_view what;
};

using TomlValue = std::variant<std::string, std::int64_t, double, bool, OtherValue>;

struct TomlTable {
  std::string name;
  TextPosition at;
};

struct TomlEntry {
  std::string table;  ///< empty above the first table
  std::string key;
  TomlValue value;
  TextPosition key_at, value_at;
};

/// A TOML text, which for a scene is tables of values and no more: anything deeper is an OtherValue.
struct TomlDocument {
  std::vector<TomlTable> tables;
  std::vector<TomlEntry> entries;
};

/// @throws TextError
TomlDocument parse_toml(std::string_view text);

}  // namespace viscobar

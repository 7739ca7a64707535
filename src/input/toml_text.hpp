#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "input/text_check.hpp"

namespace viscobar {

/// A value that no key of a scene has; `what` names it with its article.
struct OtherValue {
  std::string_view what;
};

/// Strings are a list where a table of values has an array of them.
using TomlValue = std::variant<std::string, std::int64_t, double, bool, OtherValue, std::vector<std::string>>;

/// A value with all that is inside of it, in the order of the text: of an array the elements, of a table the entries.
struct TomlNode {
  enum class Kind { plain, array, table };
  std::string key;  ///< empty in an array and at the root
  Kind kind = Kind::plain;
  TomlValue value;  ///< of a table an OtherValue
  std::vector<TomlNode> inside;
  TextPosition key_at, value_at;
};

/// The whole text as one table. @throws TextError
TomlNode parse_toml(std::string_view text);

}  // namespace viscobar

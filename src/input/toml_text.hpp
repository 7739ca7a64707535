#pragma once

#include <algorithm>
#include <cstdint>
#include <stdexcept>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "text/printable_text.hpp"
#include "viscobar/input/scene_file.hpp"

namespace viscobar {

class TextError : public std::runtime_error {
 public:
  TextError(TextPosition position, const std::string& what) : std::runtime_error(what), at(position) {}
  TextPosition at;
};

/// The ASCII that somebody meant who has this character from a word processor or a book: - for a typographic minus, a
/// plain quote for a curved one, pi for the Greek letter. Empty when it is none of them.
std::string_view ascii_for(std::string_view character);

/// Refuses text in UTF-16 and lines that end in a carriage return alone, and what toml++ 3.3 answers with undefined
/// behaviour or unbounded recursion: text that is not UTF-8, letters beyond ASCII outside of strings and comments, in
/// quotes within a bare word, or first after a backslash in a string of several lines, malformed table headers, dotted
/// names of very many parts, strings that do not end. What passes may still be wrong TOML.
/// @throws TextError at the first fault
void check_text(std::string_view text);

/// A value that no key of a scene has; `what` names it with its article.
struct OtherValue {
  std::string_view what;
};

/// Strings are a list where a table of values has an array of them. A table is one of these where it is written in one
/// line, of numbers, strings and arrays of numbers alone.
using TomlValue = std::variant<std::string, std::int64_t, double, bool, OtherValue, std::vector<std::string>,
                               std::vector<double>, SceneTable>;

/// A value with all that is inside of it, in the order of the text: of an array the elements, of a table the entries.
struct TomlNode {
  enum class Kind { plain, array, table };
  std::string key;  ///< empty in an array and at the root
  Kind kind = Kind::plain;
  TomlValue value;  ///< of a table an OtherValue, or a SceneTable
  std::vector<TomlNode> inside;
  TextPosition key_at, value_at;

  bool is_list_of_tables() const {
    return kind == Kind::array && !inside.empty() &&
           std::ranges::all_of(inside, [](const TomlNode& one) { return one.kind == Kind::table; });
  }
};

TomlNode parse_toml(std::string_view text);

}  // namespace viscobar

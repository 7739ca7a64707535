#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace viscobar {

/// A place in a text: lines and characters (code points, not bytes) of the line, from 1.
struct TextPosition {
  std::size_t line = 1, column = 1;
};

TextPosition position_in(std::string_view text, std::size_t offset);

std::size_t characters(std::string_view text);

/// Bytes of the character of UTF-8 at `offset`; 0 when there is none, as for overlong forms and surrogates.
std::size_t character_length(std::string_view text, std::size_t offset);

bool is_utf8(std::string_view text);

/// Offset of the first byte that is not part of UTF-8 text; the length of the text where all are.
std::size_t first_invalid_byte(std::string_view text);

/// A text as a terminal, a log or a page can show it: what would steer them stands as its number, as TOML and JSON
/// write it. These are control characters (\u001b begins the escape sequences of terminals, \u009b too), what reverses
/// the direction of writing (\u202e), and bytes that are not UTF-8 (\x9b). New lines and tabs stay.
std::string printable(std::string_view text);

/// The same on one line: new lines and tabs, too, as numbers.
std::string one_line(std::string_view text);

/// Printable text made safe for HTML and SVG.
std::string escaped(std::string_view text);

}  // namespace viscobar

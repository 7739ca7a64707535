#pragma once

#include <cstddef>
#include <string_view>

namespace viscobar {

/// A place in a text: lines and characters (code points, not bytes) of the line, from 1.
struct TextPosition {
  std::size_t line = 1, column = 1;
};

/// Position of the byte at `offset`.
TextPosition position_in(std::string_view text, std::size_t offset);

/// Bytes of the character of UTF-8 at `offset`; 0 when there is none, as for overlong forms and surrogates.
std::size_t character_length(std::string_view text, std::size_t offset);

/// Whether all of the text is UTF-8.
bool is_utf8(std::string_view text);

/// Offset of the first byte that is not part of UTF-8 text; the length of the text where all are.
std::size_t first_invalid_byte(std::string_view text);

}  // namespace viscobar

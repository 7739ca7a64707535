#include "text/printable_text.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>

namespace viscobar {

namespace {

bool is_continuation(char c) { return (static_cast<unsigned char>(c) & 0xC0u) == 0x80u; }

// The number of the UTF-8 character that is `bytes`.
unsigned code_point(std::string_view bytes) {
  const auto byte = [&](std::size_t k) { return static_cast<unsigned char>(bytes[k]); };
  if (bytes.size() == 1) return byte(0);
  unsigned code = byte(0) & (0x7Fu >> bytes.size());
  for (std::size_t k = 1; k < bytes.size(); ++k) code = code << 6 | (byte(k) & 0x3Fu);
  return code;
}

bool steers(unsigned code) {
  const auto within = [code](unsigned first, unsigned last) { return code >= first && code <= last; };
  return code < 0x20 || within(0x7F, 0x9F) || within(0x2028, 0x202E) || within(0x2066, 0x2069);
}

std::string shown(std::string_view text, bool lines) {
  std::string out;
  for (std::size_t i = 0; i < text.size();) {
    const std::size_t length = character_length(text, i);
    const std::string_view character = text.substr(i, length == 0 ? 1 : length);
    const bool layout = character == "\n" || character == "\t";
    if (length == 0)
      fmt::format_to(std::back_inserter(out), "\\x{:02x}", static_cast<unsigned char>(character.front()));
    else if (layout ? !lines : steers(code_point(character)))
      fmt::format_to(std::back_inserter(out), "\\u{:04x}", code_point(character));
    else
      out += character;
    i += character.size();
  }
  return out;
}

}  // namespace

std::size_t character_length(std::string_view text, std::size_t offset) {
  const auto byte = [&](std::size_t k) { return k < text.size() ? static_cast<unsigned char>(text[k]) : 0u; };
  const unsigned first = byte(offset), second = byte(offset + 1);
  if (first < 0x80) return 1;
  const std::size_t length = first >= 0xF0 ? 4 : first >= 0xE0 ? 3 : 2;
  const unsigned lowest = first == 0xE0 ? 0xA0 : first == 0xF0 ? 0x90 : 0x80;
  const unsigned highest = first == 0xED ? 0x9F : first == 0xF4 ? 0x8F : 0xBF;
  if (first < 0xC2 || first > 0xF4 || second < lowest || second > highest) return 0;
  for (std::size_t k = 2; k < length; ++k)
    if (offset + k >= text.size() || !is_continuation(text[offset + k])) return 0;
  return length;
}

std::size_t first_invalid_byte(std::string_view text) {
  std::size_t i = 0;
  while (i < text.size()) {
    const std::size_t length = character_length(text, i);
    if (length == 0) return i;
    i += length;
  }
  return i;
}

bool is_utf8(std::string_view text) { return first_invalid_byte(text) == text.size(); }

std::size_t characters(std::string_view text) {
  return static_cast<std::size_t>(std::ranges::count_if(text, [](char c) { return !is_continuation(c); }));
}

TextPosition position_in(std::string_view text, std::size_t offset) {
  const std::string_view before = text.substr(0, offset);
  const auto newlines = static_cast<std::size_t>(std::ranges::count(before, '\n'));
  return {1 + newlines, 1 + characters(before.substr(before.rfind('\n') + 1))};  // npos + 1 is 0
}

std::string printable(std::string_view text) { return shown(text, true); }
std::string one_line(std::string_view text) { return shown(text, false); }

std::string escaped(std::string_view text) {
  std::string out;
  for (const char c : printable(text)) {  // XML has no control characters
    switch (c) {
      case '&': out += "&amp;"; break;
      case '<': out += "&lt;"; break;
      case '>': out += "&gt;"; break;
      case '"': out += "&quot;"; break;
      default: out += c;
    }
  }
  return out;
}

}  // namespace viscobar

#include "text/printable_text.hpp"

#include <fmt/format.h>

#include <iterator>

#include "text/utf8.hpp"

namespace viscobar {

namespace {

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

#pragma once

#include <fmt/format.h>

#include <cmath>
#include <string>
#include <string_view>

#include "text/number.hpp"

namespace viscobar::plot {

/// A JSON string that may also stand in a <script>.
inline std::string json_string(std::string_view text) {
  std::string out = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\')
      (out += '\\') += c;
    else if (static_cast<unsigned char>(c) < 0x20 || c == '<')
      out += fmt::format("\\u{:04x}", static_cast<unsigned>(c));
    else
      out += c;
  }
  return out + '"';
}

/// A JSON array of value(item) with so many significant digits; null for what is not finite.
template <class Range, class Value>
std::string json_numbers(const Range& items, Value value, int digits) {
  std::string out = "[";
  for (const auto& item : items) {
    const double number = value(item);
    if (out.size() > 1) out += ',';
    if (std::isfinite(number))
      append_digits(out, number, digits);
    else
      out += "null";
  }
  return out + ']';
}

}  // namespace viscobar::plot

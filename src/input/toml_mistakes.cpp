#include "input/toml_mistakes.hpp"

#include <algorithm>
#include <array>
#include <string>

#include "input/input_text.hpp"

namespace viscobar {

namespace {

bool is_digit(char c) { return c >= '0' && c <= '9'; }
bool is_letter(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_'; }

template <std::size_t N>
bool is_one_of(std::string_view word, const std::array<std::string_view, N>& words) {
  return std::find(words.begin(), words.end(), word) != words.end();
}

template <std::size_t N>
bool begins_with_one_of(std::string_view text, const std::array<std::string_view, N>& words) {
  return std::any_of(words.begin(), words.end(), [&](std::string_view word) { return text.starts_with(word); });
}

constexpr std::array<std::string_view, 3> conflict{"<<<<<<<", "=======", ">>>>>>>"};
constexpr std::array<std::string_view, 5> foreign_comment{";", "//", "%", "!", "--"};
constexpr std::array<std::string_view, 6> capital_boolean{"True", "False", "TRUE", "FALSE", "yes", "no"};
constexpr std::array<std::string_view, 5> nothing{"None", "null", "nil", "NULL", "NA"};
constexpr std::array<std::string_view, 6> not_finite{"NaN", "NAN", "Infinity", "-Infinity", "Inf", "-Inf"};

std::string_view about_line(std::string_view line) {
  if (begins_with_one_of(line, conflict)) return "a merge conflict was left here";
  if (begins_with_one_of(line, foreign_comment)) return "a comment begins with #";
  if (line.starts_with('(')) return "a table begins with its name in brackets, like [bar]";
  if (line.starts_with('<') || line.starts_with('{')) return "a file consists of [tables] and lines key = value";
  if (line.find(':') != line.npos) return "key and value are joined by =";
  return "a line has the form key = value";
}

// What follows the digits, points, signs and exponent that a value begins with.
std::string_view about_number(std::string_view value) {
  const std::size_t end = std::min(value.find_first_not_of("0123456789+-."), value.size());
  const std::string_view rest = value.substr(end);
  const bool open_point = end > 0 && value[end - 1] == '.';
  if (value[0] == '.' || open_point) return "a decimal point has digits on both sides";
  if (end > 1 && value[0] == '0' && is_digit(value[1])) return "a whole number begins with another digit than 0";
  if (rest.empty()) return end > 18 ? "so large a number is written with an exponent, like 1e20" : "";
  if (rest == "e" || rest == "E") return "the exponent lacks its digits";
  if (rest.starts_with(',')) return "decimals are written with a point, and one value is given";
  if (rest.starts_with('x')) return "a number with a fraction is written in decimals";
  const bool exponent = rest.size() > 1 && (is_digit(rest[1]) || rest[1] == '-' || rest[1] == '+');
  if ((rest[0] == 'd' || rest[0] == 'D') && exponent) return "an exponent is written with e, like 1e-4";
  if (rest.find_first_of("*/^()") < rest.size() && trimmed(rest).front() != '/') return "formulas stand in quotes";
  if (rest.starts_with('/')) return "a quotient is a formula, which stands in quotes, or written out as a number";
  if (trimmed(rest).starts_with("//") || trimmed(rest).starts_with('%')) return "a comment begins with #";
  if (rest.starts_with(';')) return "a line ends without ;";
  if (is_letter(rest[0]) && rest[0] != 'e' && rest[0] != 'E')
    return "units are not written: any consistent ones will do";
  if (rest.starts_with(' ')) return "one value is given, and a new key begins on a new line";
  return "";
}

std::string_view about_value(std::string_view value) {
  if (value.empty()) return "the key needs a value";
  if (value.starts_with('=')) return "one = joins key and value";
  if (value.starts_with('$') || value.starts_with("{{")) return "a placeholder was not filled in";
  const std::string_view word = value.substr(0, value.find_first_of(" \t#;,"));
  if (is_one_of(word, capital_boolean)) return "a boolean is true or false";
  if (is_one_of(word, nothing)) return "a key without a value is left out";
  if (is_one_of(word, not_finite)) return "a number is finite";
  if (is_digit(value[0]) || value[0] == '.' ||
      ((value[0] == '-' || value[0] == '+') && value.size() > 1 && (is_digit(value[1]) || value[1] == '.')))
    return about_number(value);
  if (is_letter(value[0]) || value[0] == '-' || value[0] == '(') return "words and formulas stand in quotes";
  return "";
}

}  // namespace

std::string_view toml_advice(std::string_view line) {
  line = trimmed(line);
  if (line.empty() || line.starts_with('#') || line.starts_with('[')) return "";
  const std::size_t equals = line.find('=');
  if (equals == line.npos || equals == 0 || begins_with_one_of(line, conflict) || line.starts_with('<'))
    return about_line(line);
  const std::string_view key = trimmed(line.substr(0, equals));
  if (key.find_first_of(" \t") != key.npos && key.find_first_of("\"'") == key.npos)
    return "a key is one word, and its value follows after =";
  return about_value(trimmed(line.substr(equals + 1)));
}

}  // namespace viscobar

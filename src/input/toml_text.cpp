#include "input/toml_text.hpp"

#include <algorithm>
#include <new>
#include <span>
#include <tuple>

#include "input/input_text.hpp"

namespace {

struct BrokenAssumption {};

constexpr void assume(bool condition) {
  if (!condition) throw BrokenAssumption();
}

}  // namespace

// The parser's assertions guard against texts it does not foresee: here they throw, in every build. The packaged
// library has them compiled away, so its headers are used instead.
#undef NDEBUG
#undef TOML_SHARED_LIB
#undef TOML_HEADER_ONLY
#define TOML_HEADER_ONLY 1
#define TOML_ENABLE_FORMATTERS 0
#define TOML_ASSERT(condition) assume(static_cast<bool>(condition))
#include <toml++/toml.h>

namespace viscobar {

namespace {

using Words = std::span<const std::string_view>;
bool is_one_of(std::string_view word, Words words) { return std::ranges::find(words, word) != words.end(); }
bool begins_with_one_of(std::string_view text, Words words) {
  return std::ranges::any_of(words, [&](std::string_view word) { return text.starts_with(word); });
}

constexpr std::string_view conflict[] = {"<<<<<<<", "=======", ">>>>>>>"};
constexpr std::string_view foreign_comment[] = {";", "//", "%", "!", "--"};
constexpr std::string_view capital_boolean[] = {"True", "False", "TRUE", "FALSE", "yes", "no"};
constexpr std::string_view nothing[] = {"None", "null", "nil", "NULL", "NA"};
constexpr std::string_view not_finite[] = {"NaN", "NAN", "Infinity", "-Infinity", "Inf", "-Inf"};

std::string_view about_line(std::string_view line) {
  if (begins_with_one_of(line, conflict)) return "a merge conflict was left here";
  if (begins_with_one_of(line, foreign_comment)) return "a comment begins with #";
  if (line.starts_with('(')) return "a table begins with its name in brackets, like [bar]";
  if (line.starts_with('<') || line.starts_with('{')) return "a file consists of [tables] and lines key = value";
  if (line.find(':') != line.npos) return "key and value are joined by =";
  return "a line has the form key = value";
}

// Advice on a value that begins like a number, by the text behind its digits, points, signs and exponent.
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
  if ((is_letter(rest[0]) || rest[0] == '_') && rest[0] != 'e' && rest[0] != 'E')
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
  if (is_letter(value[0]) || value[0] == '_' || value[0] == '-' || value[0] == '(')
    return "words and formulas stand in quotes";
  return "";
}

/// Advice on a line that is not TOML, by habits from other languages and formats: a decimal comma, // before a comment,
/// a formula without quotes. Empty if it shows none of them.
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

TextPosition position(const toml::source_region& region) { return {region.begin.line, region.begin.column}; }

// An OtherValue where it holds anything else.
TomlValue table_value(const toml::table& table);

TomlValue plain_value(const toml::node& node) {
  if (const auto* text = node.as_string()) return text->get();
  if (const auto* integer = node.as_integer()) return integer->get();
  if (const auto* number = node.as_floating_point()) return number->get();
  if (const auto* boolean = node.as_boolean()) return boolean->get();
  if (const auto* table = node.as_table()) return table_value(*table);
  if (const auto* array = node.as_array()) {
    std::vector<std::string> texts;
    std::vector<double> numbers;
    for (const toml::node& element : *array) {
      if (const auto* text = element.as_string()) texts.push_back(text->get());
      if (element.is_number()) numbers.push_back(*element.value<double>());
    }
    if (texts.size() == array->size()) return texts;
    if (numbers.size() == array->size()) return numbers;
    return OtherValue{"an array"};
  }
  return OtherValue{"a date or time"};
}

TomlValue table_value(const toml::table& table) {
  SceneTable entries;
  if (!table.is_inline() || table.empty()) return OtherValue{"a table"};
  for (const auto& [key, node] : table) {
    TomlValue value = plain_value(node);
    if (const auto number = node.value<double>(); number && node.is_number())
      entries.emplace(key.str(), *number);
    else if (auto* text = std::get_if<std::string>(&value))
      entries.emplace(key.str(), std::move(*text));
    else if (auto* numbers = std::get_if<std::vector<double>>(&value))
      entries.emplace(key.str(), std::move(*numbers));
    else
      return OtherValue{"a table"};
  }
  return entries;
}

TomlNode tree(const toml::node& node, const toml::key* key = nullptr) {
  TomlNode copy;
  if (key) copy.key = key->str();
  copy.value = plain_value(node);
  copy.value_at = position(node.source());
  copy.key_at = key ? position(key->source()) : copy.value_at;
  if (const auto* array = node.as_array()) {
    copy.kind = TomlNode::Kind::array;
    for (const toml::node& element : *array) copy.inside.push_back(tree(element));
  } else if (const auto* table = node.as_table()) {
    copy.kind = TomlNode::Kind::table;
    for (const auto& [name, value] : *table) copy.inside.push_back(tree(value, &name));
    std::stable_sort(copy.inside.begin(), copy.inside.end(), [](const TomlNode& a, const TomlNode& b) {
      return std::tie(a.key_at.line, a.key_at.column) < std::tie(b.key_at.line, b.key_at.column);
    });
  }
  return copy;
}

std::string_view line_of(std::string_view text, std::size_t number) {
  for (std::size_t k = 1; k < number; ++k) text.remove_prefix(std::min(text.find('\n'), text.size() - 1) + 1);
  return text.substr(0, text.find('\n'));
}

// Where its stream finds no memory, the library takes a number for something else: such a text is sound the next time.
toml::table parsed(std::string_view text) {
  try {
    return toml::parse(text);
  } catch (const toml::parse_error&) {
    (void)toml::parse(text);
  }
  throw std::bad_alloc();
}

}  // namespace

TomlNode parse_toml(std::string_view text) {
  check_text(text);
  try {
    return tree(parsed(text));
  } catch (const toml::parse_error& error) {
    const TextPosition at = position(error.source());
    const std::string_view advice = toml_advice(line_of(text, at.line));
    throw TextError(at, std::string(error.description()).append(advice.empty() ? "" : "; ").append(advice));
  } catch (const BrokenAssumption&) {
    throw TextError({}, "not a TOML text");
  }
}

}  // namespace viscobar

#include "input/scene_values.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "input/input_text.hpp"
#include "text/number.hpp"

namespace viscobar {

namespace {

// A number as TOML writes it, without underscores: most values of a sweep are.
std::optional<TomlValue> plain_number(std::string_view text) {
  const std::size_t digits = text.starts_with('-') ? 1 : 0;
  if (text.size() > 32 || text.find_first_not_of("0123456789.e-", digits) != text.npos) return std::nullopt;
  const std::size_t point = text.find('.'), exponent = text.find('e');
  const std::string_view whole = text.substr(digits, std::min({point, exponent, text.size()}) - digits);
  if (whole.empty() || (whole.size() > 1 && whole.front() == '0') || whole.find('-') != whole.npos) return std::nullopt;
  if (point != text.npos && (point + 1 == text.size() || text[point + 1] == 'e')) return std::nullopt;
  if (point == text.npos && exponent == text.npos) return number_in<std::int64_t>(text);
  return number_in<double>(text);
}

std::optional<TomlValue> toml_value(const std::string& text) {
  try {
    const TomlNode root = parse_toml("value = " + text);
    if (root.inside.size() == 1)
      if (const TomlNode& only = root.inside.front();
          !std::holds_alternative<OtherValue>(only.value) || only.kind != TomlNode::Kind::table)
        return only.value;
  } catch (const TextError&) {
  }
  return std::nullopt;
}

// Numbers as people write them, .5, 2. and 007, as TOML has them; what is in quotes stays.
std::string with_toml_numbers(std::string_view text) {
  std::string all;
  char quote = '\0';
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    const bool after = i + 1 < text.size() && is_digit(text[i + 1]), before = i > 0 && is_digit(text[i - 1]);
    if (quote == '\0' ? c == '"' || c == '\'' : c == quote) quote = quote == '\0' ? c : '\0';
    const bool begins = all.empty() || !(is_digit(all.back()) || is_letter(all.back()) || all.back() == '.');
    if (quote == '\0' && c == '0' && after && begins) continue;
    if (quote == '\0' && c == '.' && before != after)
      all += before ? ".0" : "0.";
    else
      all += c;
  }
  return all;
}

}  // namespace

TomlValue value_of(std::string_view text) {
  if (auto number = plain_number(text)) return *std::move(number);
  std::string bare(text);
  if (auto value = toml_value(bare)) return *std::move(value);
  if (const std::string changed = with_toml_numbers(bare); changed != bare)
    if (auto value = toml_value(changed)) return *std::move(value);
  return bare;
}

std::string_view kind_of(const TomlValue& value) {
  constexpr std::string_view kinds[] = {"a string", "a whole number", "a number", "a boolean",
                                        "",         "an array",       "an array", "a table"};
  const auto* other = std::get_if<OtherValue>(&value);
  return other ? other->what : kinds[value.index()];
}

std::optional<double> number_of(const TomlValue& value) {
  if (const auto* integer = std::get_if<std::int64_t>(&value)) return static_cast<double>(*integer);
  if (const auto* number = std::get_if<double>(&value)) return *number;
  return std::nullopt;
}

namespace {

std::string range_problem(const KeyRange& range, double value) {
  if (!std::isfinite(value)) return fmt::format("must be finite, is {}", value);
  if (value < range.low) {
    if (range.low == 0.0) return fmt::format("must not be negative, is {}", value);
    if (value <= 0.0 && range.low < 1.0) return fmt::format("must be positive, is {}", value);
    return fmt::format("must be at least {}, is {}", range.low, value);
  }
  if (value > range.high) return fmt::format("must be at most {}, is {}", range.high, value);
  return {};
}

std::string number_advice(const std::string& text) {
  const TomlValue inside = value_of(text);
  if (std::holds_alternative<std::int64_t>(inside) || std::holds_alternative<double>(inside))
    return "; leave the quotes out";
  if (std::count(text.begin(), text.end(), ',') == 1 && text.find_first_not_of("0123456789+-,eE") == text.npos)
    return "; write it without quotes, with a decimal point";
  if (text.find_first_of("*/^()") != text.npos)
    return "; formulas are for initial data, loads, and what moves the ends";
  const std::size_t after = text.find_first_not_of("0123456789+-.eE");
  if (after == text.npos && text.size() > 18) return "; it is too large";
  const bool with_unit = after != text.npos && after > 0 && (text[after] == ' ' || is_letter(text[after]));
  return with_unit ? "; units are not written: any consistent ones will do" : "";
}

std::string choice_problem(const SceneKey& key, const std::string& value) {
  const std::vector<std::string_view> names = key.choice_names();
  if (std::ranges::find(names, value) != names.end()) return {};
  const std::string quoted = fmt::format("\"{}\"", fmt::join(names, "\", \""));
  const auto nearest = meant_name(value, names);
  return fmt::format("cannot be \"{}\"; {}", value,
                     nearest ? fmt::format("nearest is \"{}\"", *nearest) : "there are " + quoted);
}

std::string formula_problem(const SceneKey& key, const TomlValue& value, const Parameters& parameters) {
  const auto number_problem = [&key](double number) {
    if (!key.range.words.empty()) return range_problem(key.range, number);
    return std::isfinite(number) ? "" : fmt::format("must be finite, is {}", number);
  };
  if (const auto number = number_of(value)) return number_problem(*number);
  if (std::holds_alternative<SceneTable>(value))
    return key.variables.size() == 1 ? "" : "is a series, of one variable; load.profile and load.history take one each";
  const auto* text = std::get_if<std::string>(&value);
  if (!text) return fmt::format("must be a number or a formula in quotes, is {}", kind_of(value));
  try {
    const Formula formula(*text, key.variables, parameters);
    if (formula.is_constant()) return number_problem(formula.constant());
  } catch (const FormulaError& error) {
    return error.what();
  }
  return {};
}

std::string list_problem(const SceneKey& key, const TomlValue& value) {
  const auto* words = std::get_if<std::vector<std::string>>(&value);
  if (!words)
    return fmt::format(
        "must be a list of strings, such as {}, is {}",
        key.choices.empty() ? "[\"bar.viscosity\", \"left.gap\"]" : fmt::format("[\"{}\"]", key.choices.front().name),
        kind_of(value));
  if (key.choices.empty()) return {};
  for (const std::string& word : *words)
    if (const std::string problem = choice_problem(key, word); !problem.empty()) return "an entry " + problem;
  return {};
}

std::string numbers_problem(const SceneKey& key, const TomlValue& value) {
  const auto numbers = numbers_of(value);
  if (!numbers)
    return fmt::format("must be a list of numbers, such as {}, is {}{}", key.example, kind_of(value),
                       std::holds_alternative<std::vector<std::string>>(value) ? " of strings" : "");
  for (const double number : *numbers)
    if (const std::string problem = range_problem(key.range, number); !problem.empty()) return "an entry " + problem;
  return {};
}

}  // namespace

std::optional<std::vector<double>> numbers_of(const TomlValue& value) {
  if (const auto* numbers = std::get_if<std::vector<double>>(&value)) return *numbers;
  const auto* words = std::get_if<std::vector<std::string>>(&value);
  return words && words->empty() ? std::optional(std::vector<double>{}) : std::nullopt;
}

std::optional<double> percentage(std::string_view text) {
  if (!text.ends_with('%')) return std::nullopt;
  text = trimmed(text.substr(0, text.size() - 1));
  const auto value = number_in<double>(text);
  return value && std::isfinite(*value) ? std::optional(*value / 100.0) : std::nullopt;
}

bool takes(KeyType type, const TomlValue& value) {
  const bool text = std::holds_alternative<std::string>(value), number = number_of(value).has_value();
  switch (type) {
    case KeyType::text:
    case KeyType::choice: return text;
    case KeyType::count:
    case KeyType::number: return number;
    case KeyType::amount: return number || text;
    case KeyType::formula: return number || text || std::holds_alternative<SceneTable>(value);
    case KeyType::list: return std::holds_alternative<std::vector<std::string>>(value);
    case KeyType::numbers: return numbers_of(value).has_value();
  }
  return false;
}

std::string problem_with(const SceneKey& key, const TomlValue& value, const Parameters& parameters) {
  const auto* text = std::get_if<std::string>(&value);
  const auto number = number_of(value);
  switch (key.type) {
    case KeyType::text:
    case KeyType::choice:
      if (!text) return fmt::format("must be a string, is {}", kind_of(value));
      return key.type == KeyType::text ? "" : choice_problem(key, *text);
    case KeyType::count:
      if (std::holds_alternative<double>(value)) return "must be a whole number, written without point or exponent";
      [[fallthrough]];
    case KeyType::number:
      if (number) return range_problem(key.range, *number);
      return fmt::format("must be a {}, is {}{}", key.type == KeyType::count ? "whole number" : "number",
                         kind_of(value), text ? number_advice(*text) : "");
    case KeyType::amount: {
      if (number) return range_problem(key.range, *number);
      if (const auto plain = text ? number_in<double>(*text) : std::nullopt) return range_problem(key.range, *plain);
      const auto share = text ? percentage(*text) : std::nullopt;
      if (!share)
        return fmt::format("must be a number, or a percentage such as \"0.01 %\", is {}",
                           text ? fmt::format("\"{}\"", *text) : std::string(kind_of(value)));
      return *share > 0.0 && *share <= 1.0 ? ""
                                           : fmt::format("must be more than 0 and at most 100 %, is \"{}\"", *text);
    }
    case KeyType::formula: return formula_problem(key, value, parameters);
    case KeyType::list: return list_problem(key, value);
    case KeyType::numbers: return numbers_problem(key, value);
  }
  return {};
}

}  // namespace viscobar

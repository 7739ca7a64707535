#include "sweep/varied_values.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <optional>

#include "input/scene_values.hpp"
#include "text/nearest_name.hpp"

namespace viscobar {

namespace {

constexpr std::size_t most_values = 1000000;  // of one key

// value 10^decades, rounded once: 1e-2 a decade on is 0.1, not 0.1 and a bit.
double shifted(double value, int decades) {
  char shortest[64];
  const auto end = std::to_chars(shortest, shortest + sizeof shortest, value, std::chars_format::scientific).ptr;
  const std::string text(shortest, end);
  const std::size_t e = text.find('e');
  const int exponent = std::stoi(text.substr(e + 1)) + decades;
  // Not by stod, which refuses subnormal numbers.
  return std::strtod(fmt::format("{}e{}", text.substr(0, e), exponent).c_str(), nullptr);
}

std::optional<double> finite_number(const TomlValue& value) {
  if (const auto* integer = std::get_if<std::int64_t>(&value)) return static_cast<double>(*integer);
  if (const auto* number = std::get_if<double>(&value); number && std::isfinite(*number)) return *number;
  return std::nullopt;
}

struct Range {
  double from = 1.0, to = 1.0;
  std::optional<std::size_t> count, per_decade;
  bool logarithmic = false;
};

/// Absent after a report.
std::optional<Range> read_range(const TomlNode& node, const Report& report) {
  static constexpr std::string_view known[] = {"from", "to", "count", "per_decade", "spacing"};
  bool sound = true;
  const auto fail = [&](TextPosition at, const std::string& message) {
    sound = false;
    report(at, message);
  };
  const auto find = [&](std::string_view name) { return entry_of(node, name); };
  const auto read_end = [&](const char* name, double& end) {
    const TomlNode* entry = find(name);
    const auto value = entry ? finite_number(entry->value) : std::nullopt;
    if (!entry) fail(node.value_at, fmt::format("the range lacks {}", name));
    if (entry && !value) fail(entry->value_at, fmt::format("{} must be a finite number", name));
    end = value.value_or(end);
  };
  const auto read_whole = [&](const char* name, std::optional<std::size_t>& whole) {
    const TomlNode* entry = find(name);
    if (!entry) return;
    const auto* value = std::get_if<std::int64_t>(&entry->value);
    if (value && *value >= 1 && static_cast<std::size_t>(*value) <= most_values)
      whole = static_cast<std::size_t>(*value);
    else
      fail(entry->value_at, fmt::format("{} must be a whole number from 1 to {}", name, most_values));
  };

  for (const TomlNode& entry : node.inside)
    if (std::ranges::find(known, entry.key) == std::end(known))
      fail(entry.key_at, fmt::format("unknown key \"{}\" of a range; {}", entry.key, instead_of(entry.key, known)));
  Range range;
  read_end("from", range.from);
  read_end("to", range.to);
  read_whole("count", range.count);
  read_whole("per_decade", range.per_decade);
  const TomlNode *count = find("count"), *per_decade = find("per_decade"), *spacing = find("spacing");
  if (!count && !per_decade && sound) fail(node.value_at, "the range lacks count or per_decade");
  if (count && per_decade) fail(per_decade->key_at, "excludes count: a range has one or the other");

  range.logarithmic = per_decade != nullptr;
  if (spacing) {
    const auto* word = std::get_if<std::string>(&spacing->value);
    if (!word || (*word != "linear" && *word != "log"))
      fail(spacing->value_at, "spacing must be \"linear\" or \"log\"");
    else if (*word == "linear" && per_decade)
      fail(spacing->value_at, "per_decade has the spacing \"log\"");
    else
      range.logarithmic = *word == "log";
  }
  if (sound && range.count == 1u && range.from != range.to)
    fail(count->value_at, "count must be at least 2, for both ends of the range");
  if (sound && range.logarithmic)
    for (const auto& [name, end] : {std::pair("from", range.from), std::pair("to", range.to)})
      if (end <= 0.0) fail(find(name)->value_at, fmt::format("{} must be positive in a logarithmic range", name));
  if (sound && range.logarithmic && !std::isnormal(range.to / range.from))
    fail(node.value_at, fmt::format("from {:.3g} to {:.3g} is more than 307 decades", range.from, range.to));
  return sound ? std::optional(range) : std::nullopt;
}

// The number of 15 digits, counted from the first one of `size`, where that is the value but for rounding: 7e-5 / 14 is
// 5e-6, not 4.9999999999999996e-6.
double rounded(double value, double size) {
  if (value == 0.0) return value;
  const auto magnitude = [](double of) { return static_cast<int>(std::floor(std::log10(std::abs(of)))); };
  const int digits = 15 + magnitude(value) - magnitude(size);
  const double near = digits > 0 ? std::strtod(fmt::format("{:.{}e}", value, digits - 1).c_str(), nullptr) : 0.0;
  return std::abs(near - value) <= 4.0 * std::numeric_limits<double>::epsilon() * std::abs(size) ? near : value;
}

std::vector<double> by_count(const Range& range) {
  const std::size_t count = *range.count;
  const auto steps = static_cast<double>(count - 1);
  const double larger = std::max(std::abs(range.from), std::abs(range.to));
  std::vector<double> values = {range.from};
  for (std::size_t k = 1; k + 1 < count; ++k) {
    const auto step = static_cast<double>(k);
    if (range.logarithmic) {
      const double value = range.from * std::pow(range.to / range.from, step / steps);
      values.push_back(rounded(value, value));
    } else {
      values.push_back(rounded(range.from * ((steps - step) / steps) + range.to * (step / steps), larger));
    }
  }
  if (count > 1) values.push_back(range.to);
  return values;
}

// From `from` towards `to`; `to` itself where the steps meet it.
std::vector<double> by_decade(const Range& range) {
  const auto each = static_cast<int>(*range.per_decade);
  const double steps = std::abs(std::log10(range.to / range.from)) * each;
  const int sign = range.to < range.from ? -1 : 1;
  std::vector<double> values;
  for (int k = 0; k <= steps * (1.0 + 1e-12) + 1e-9 && values.size() <= most_values; ++k) {
    const double whole_decades = shifted(range.from, sign * (k / each));
    values.push_back(k % each == 0 ? whole_decades : whole_decades * std::pow(10.0, sign * double(k % each) / each));
  }
  if (std::abs(steps - std::round(steps)) < 1e-9) values.back() = range.to;
  return values;
}

std::string plain_text(const TomlValue& value) {
  if (const auto* text = std::get_if<std::string>(&value)) return *text;
  if (const auto* whole = std::get_if<std::int64_t>(&value)) return fmt::format("{}", *whole);
  return fmt::format("{}", std::get<double>(value));
}

}  // namespace

const TomlNode* entry_of(const TomlNode& table, std::string_view key) {
  const auto found = std::ranges::find(table.inside, key, &TomlNode::key);
  return found == table.inside.end() ? nullptr : &*found;
}

std::string instead_of(std::string_view word, std::span<const std::string_view> known) {
  const auto nearest = nearest_name(word, known);
  return nearest ? fmt::format("nearest is \"{}\"", *nearest) : fmt::format("known are {}", fmt::join(known, ", "));
}

VariedKey varied_key(const SceneKey& key, const TomlNode& node, const Parameters& parameters, const Report& report) {
  std::vector<TomlValue> values;
  bool sound = true;
  const auto add = [&](const TomlValue& value, TextPosition at) {
    const std::string problem = problem_with(key, value, parameters);
    if (std::holds_alternative<SceneTable>(value)) {
      report(
          at,
          "is a series, which does not vary: write a scene for each, or vary a factor of it as a parameter of a formula");
      return void(sound = false);
    }
    if (problem.empty()) return values.push_back(value);
    if (sound || node.kind == TomlNode::Kind::array) report(at, problem);  // of a range the first one says enough
    sound = false;
  };
  if (key.type == KeyType::list || key.type == KeyType::numbers) {
    report(node.key_at, "is the same for all cases: it belongs into [set]");
    sound = false;
  } else if (node.kind == TomlNode::Kind::array) {
    for (const TomlNode& element : node.inside) add(element.value, element.value_at);
    if (node.inside.empty()) report(node.value_at, "is an empty list");
  } else if (node.kind == TomlNode::Kind::table) {
    const bool takes_numbers = takes(key.type, TomlValue(1.0));
    if (!takes_numbers) report(node.value_at, "takes no numbers, so give a list of its values, not a range");
    const auto range = takes_numbers ? read_range(node, report) : std::nullopt;
    if (range)
      for (const double value : range->count ? by_count(*range) : by_decade(*range)) {
        if (key.type != KeyType::count) {
          add(value, node.value_at);
        } else if (std::abs(value) > 1e15) {
          add(std::int64_t{1} << 53, node.value_at);
        } else if (const std::int64_t whole = std::llround(value);
                   values.empty() || std::get<std::int64_t>(values.back()) != whole) {
          add(whole, node.value_at);
        }
      }
  } else {
    report(node.value_at,
           "must be a list of values, or a range { from, to, count }, or { from, to, per_decade }; a single "
           "value belongs into [set]");
  }
  if (!sound) values.clear();
  // A gap is a formula that mostly is a number: as such its values have an order, and a place on an axis.
  const bool numbers =
      takes(key.type, TomlValue(1.0)) && !values.empty() &&
      std::ranges::all_of(values, [](const TomlValue& value) { return finite_number(value).has_value(); });
  const auto varied = [&](auto&& as) {
    std::vector<std::decay_t<decltype(as(values.front()))>> list;
    for (const TomlValue& value : values) list.push_back(as(value));
    return VariedKey{std::string(key.name), std::move(list)};
  };
  if (key.type == KeyType::count) return varied([](const TomlValue& value) { return std::get<std::int64_t>(value); });
  if (key.type == KeyType::number || numbers)
    return varied([](const TomlValue& value) { return *finite_number(value); });
  return varied(plain_text);
}

}  // namespace viscobar

#include "input/toml_text.hpp"

#include <algorithm>
#include <string>
#include <tuple>
#include <utility>

#include "input/toml_mistakes.hpp"

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

TextPosition position(const toml::source_region& region) { return {region.begin.line, region.begin.column}; }

TomlValue plain_value(const toml::node& node) {
  if (const auto* text = node.as_string()) return text->get();
  if (const auto* integer = node.as_integer()) return integer->get();
  if (const auto* number = node.as_floating_point()) return number->get();
  if (const auto* boolean = node.as_boolean()) return boolean->get();
  if (node.is_table()) return OtherValue{"a table"};
  if (const auto* array = node.as_array()) {
    std::vector<std::string> texts;
    for (const toml::node& element : *array) {
      const auto* text = element.as_string();
      if (!text) return OtherValue{"an array"};
      texts.push_back(text->get());
    }
    return texts;
  }
  return OtherValue{"a date or time"};
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

}  // namespace

TomlNode parse_toml_tree(std::string_view text) {
  check_text(text);
  try {
    return tree(toml::parse(text));
  } catch (const toml::parse_error& error) {
    const TextPosition at = position(error.source());
    const std::string_view advice = toml_advice(line_of(text, at.line));
    throw TextError(at, std::string(error.description()).append(advice.empty() ? "" : "; ").append(advice));
  } catch (const BrokenAssumption&) {
    throw TextError({}, "not a TOML text");
  }
}

TomlDocument parse_toml(std::string_view text) {
  TomlDocument document;
  const auto add = [&](const std::string& table, const TomlNode& node) {
    document.entries.push_back({table, node.key, node.value, node.key_at, node.value_at});
  };
  for (const TomlNode& node : parse_toml_tree(text).inside) {
    if (node.kind != TomlNode::Kind::table) {
      add("", node);
      continue;
    }
    document.tables.push_back({node.key, node.value_at});
    for (const TomlNode& entry : node.inside) add(node.key, entry);
  }
  return document;
}

}  // namespace viscobar

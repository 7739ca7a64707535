#include "input/scene_template.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <string_view>

#include "input/scene_keys.hpp"

namespace viscobar {

namespace {

/// What the scene of the template has; the other keys are commented out.
constexpr std::string_view given[] = {
    "title",    "bar.length",    "bar.viscosity",        "left.kind",        "left.gap",    "right.kind",  "right.gap",
    "time.end", "mesh.elements", "initial.displacement", "initial.velocity", "method.name", "output.every"};

bool is_given(const SceneKey& key) { return std::ranges::find(given, key.name) != std::end(given); }

bool any_given(std::string_view table) {
  return std::ranges::any_of(scene_keys(), [&](const SceneKey& key) { return key.table() == table && is_given(key); });
}

/// Lines of at most 100 characters that begin with "# ".
std::string comment(std::string_view text) {
  constexpr std::size_t width = 98;
  std::string lines;
  while (!text.empty()) {
    std::size_t end = text.size();
    if (end > width && (end = text.rfind(' ', width)) == text.npos) end = std::min(text.find(' '), text.size());
    lines += fmt::format("# {}\n", text.substr(0, end));
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  return lines;
}

std::string facts(const SceneKey& key) {
  std::string type = type_words(key), fallback = default_words(key);
  std::erase(type, '`');
  std::erase(fallback, '`');
  const bool plain = fallback.starts_with("required") || fallback == "none";
  std::string words = type + (fallback == "none" ? "" : plain ? "; " + fallback : "; default " + fallback);
  if (!key.unit.empty() && key.unit != "1") words += fmt::format("; unit: {}", key.unit);
  return words;
}

}  // namespace

std::string scene_template() {
  std::string text =
      "# A scene of viscobar. Keys that are commented out are optional. `viscobar check FILE` describes the scene,\n"
      "# `viscobar run FILE` computes it, docs/scene-file.md explains every key.\n\n";
  std::string_view table;
  for (const SceneKey& key : scene_keys()) {
    if (key.table() != table) {
      table = key.table();
      text += fmt::format("\n{}[{}]\n", any_given(table) ? "" : "#", table);
    }
    text += comment(fmt::format("{} ({})", key.meaning, facts(key)));
    text += fmt::format("{}{} = {}\n", is_given(key) ? "" : "#", key.leaf(),
                        key.example.empty() ? key.fallback : key.example);
  }
  return text;
}

}  // namespace viscobar

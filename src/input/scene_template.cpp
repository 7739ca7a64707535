#include "input/scene_template.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <string_view>

#include "input/scene_keys.hpp"

namespace viscobar {

namespace {

/// What the scene of the template says; `set` where it departs from what a bar without the key would do.
struct Example {
  std::string_view key, value;
  bool set = true;
};

constexpr bool not_set = false;
constexpr Example examples[] = {
    {"title", "\"A bar between two obstacles\""},
    {"bar.length", "1.0"},
    {"bar.viscosity", "0.01"},
    {"left.kind", "\"obstacle\""},
    {"left.gap", "0.1"},
    {"left.side", "\"below\"", not_set},
    {"left.force", "\"sin(2*t)\"", not_set},
    {"left.motion", "\"0.1*sin(2*t)\"", not_set},
    {"left.stiffness", "2.0", not_set},
    {"left.dashpot", "0.1", not_set},
    {"right.kind", "\"obstacle\""},
    {"right.gap", "0.1"},
    {"right.side", "\"below\"", not_set},
    {"right.force", "\"sin(2*t)\"", not_set},
    {"right.motion", "\"0.1*sin(2*t)\"", not_set},
    {"right.stiffness", "2.0", not_set},
    {"right.dashpot", "0.1", not_set},
    {"span.gap", "0.2", not_set},
    {"span.side", "\"below\"", not_set},
    {"initial.displacement", "\"x*(1-x)\""},
    {"initial.velocity", "\"-x*(1-x)\""},
    {"load.density", "\"sin(t*sqrt(2))*cos(2*x)\"", not_set},
    {"load.profile", "\"cos(2*x)\"", not_set},
    {"load.history", "\"sin(t*sqrt(2))\"", not_set},
    {"time.end", "6.0"},
    {"mesh.elements", "27"},
    {"mesh.mass", "\"fourth_order\"", not_set},
    {"contact.epsilon", "1e-6", not_set},
    {"contact.restitution", "0.0", not_set},
    {"method.name", "\"automatic\""},
    {"method.absolute_tolerance", "1e-9", not_set},
    {"method.step", "1e-3", not_set},
    {"accuracy.error", "1e-4", not_set},
    {"accuracy.of", "\"displacement\"", not_set},
    {"units.length", "\"m\"", not_set},
    {"units.time", "\"s\"", not_set},
    {"units.mass", "\"kg\"", not_set},
    {"units.force", "\"N\"", not_set},
    {"units.stress", "\"Pa\"", not_set},
    {"output.every", "0.01"},
    {"output.write", "[\"ends\", \"events\", \"field\", \"energy\", \"report\"]", not_set},
};

Example example(const SceneKey& key) {
  const auto* found = std::find_if(std::begin(examples), std::end(examples),
                                   [&](const Example& candidate) { return candidate.key == key.name; });
  return found == std::end(examples) ? Example{key.name, key.fallback, not_set} : *found;
}

bool any_set(std::string_view table) {
  const auto keys = scene_keys();
  return std::any_of(keys.begin(), keys.end(),
                     [&](const SceneKey& key) { return key.table() == table && example(key).set; });
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
    const auto [name, value, set] = example(key);
    if (key.table() != table) {
      table = key.table();
      text += fmt::format("\n{}[{}]\n", any_set(table) ? "" : "#", table);
    }
    text += comment(fmt::format("{} ({})", key.meaning, facts(key)));
    text += fmt::format("{}{} = {}\n", set ? "" : "#", key.leaf(), value);
  }
  return text;
}

}  // namespace viscobar

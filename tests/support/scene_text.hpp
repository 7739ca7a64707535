#pragma once

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

namespace viscobar {

/// A scene file: a bar that falls on an obstacle at its left end, with other values of its keys, and further ones.
inline std::string falling_bar_with(const std::vector<std::pair<std::string, std::string>>& changes = {}) {
  std::vector<std::pair<std::string, std::string>> keys = {
      {"bar.length", "1.0"}, {"bar.viscosity", "0.1"},      {"left.kind", "\"obstacle\""},
      {"left.gap", "0.1"},   {"initial.displacement", "0"}, {"initial.velocity", "-1"},
      {"time.end", "1.0"},   {"mesh.elements", "20"},       {"contact.epsilon", "1e-3"}};
  for (const auto& change : changes) {
    const auto same = [&](const auto& key) { return key.first == change.first; };
    if (const auto found = std::ranges::find_if(keys, same); found != keys.end())
      found->second = change.second;
    else
      keys.push_back(change);
  }
  std::string text;
  for (const auto& [key, value] : keys) text += key + " = " + value + "\n";
  return text;
}

}  // namespace viscobar

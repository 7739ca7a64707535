#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace viscobar {

/// A table of a series is written otherwise than in JSON.
inline std::string toml_of(const nlohmann::json& value) {
  if (!value.is_object()) return value.dump();
  std::string table;
  for (const auto& [key, entry] : value.items()) table += (table.empty() ? "{ " : ", ") + key + " = " + entry.dump();
  return table + " }";
}

/// The keys of a scene's description (SceneFile::description) as overrides "table.key=value".
inline std::vector<std::string> overrides_of(const std::string& description) {
  std::vector<std::string> overrides;
  const auto tables = nlohmann::json::parse(description);
  for (const auto& [table, keys] : tables.items()) {
    if (keys.is_array() && !keys.empty() && keys.front().is_object()) {  // bars in line, and their joints
      for (std::size_t k = 0; k < keys.size(); ++k)
        for (const auto& [key, value] : keys[k].items())
          overrides.push_back(table + "." + std::to_string(k + 1) + "." + key + "=" + toml_of(value));
      continue;
    }
    if (!keys.is_object()) {
      overrides.push_back(table + "=" + keys.dump());
      continue;
    }
    for (const auto& [key, value] : keys.items()) overrides.push_back(table + "." + key + "=" + toml_of(value));
  }
  return overrides;
}

}  // namespace viscobar

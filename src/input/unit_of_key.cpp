#include "input/unit_of_key.hpp"

#include "input/scene_keys.hpp"
#include "scene/end_kinds.hpp"

namespace viscobar {

std::optional<UnitPowers> unit_of_key(std::string_view key, const Scene& scene) {
  const SceneKey* row = find_scene_key(key);
  auto unit = row ? unit_powers(row->unit) : std::nullopt;
  if (key != "contact.epsilon" || !scene.span) return unit;
  if (has_end_penalty(scene)) return std::nullopt;
  ++(*unit)[0];
  return unit;
}

}  // namespace viscobar

#pragma once

#include <algorithm>
#include <iterator>
#include <optional>
#include <span>
#include <string_view>
#include <variant>

#include "viscobar/scene/scene.hpp"

namespace viscobar {

/// The node of an end under its condition. A condition that is neither of these also has a place in BarSystem.
struct EndNode {
  std::optional<double> held{};        ///< displacement of a node that does not move and is no unknown
  std::optional<Obstacle> obstacle{};  ///< a contact
};

/// A number that an end condition has, and its key in the end's table of a scene file.
struct EndNumber {
  std::string_view key, unit, meaning;
  double low, high;        ///< the values it may have
  std::string_view range;  ///< the same in words
  double& (*of)(EndCondition&);
};

/// All that is said about one alternative of EndCondition. Scene files, reports, validation and the discretisation go
/// by this table.
struct EndKind {
  std::string_view name;      ///< in a scene file
  std::string_view in_words;  ///< completes "the end is ..."
  std::string_view meaning;
  EndCondition harmless;                     ///< with numbers that no other check can take offence at
  bool sided;                                ///< true if it has a side
  std::span<const std::string_view> inputs;  ///< keys of what it may be given beside (see EndInput)
  std::span<const EndNumber> numbers;
  EndNode (*node)(const EndCondition&, double initial_displacement);
};

inline constexpr EndNumber obstacle_numbers[] = {
    {"gap", "length", "how far from u = 0 the obstacle lies", 0.0, 1e100, ">= 0",
     [](EndCondition& end) -> double& { return std::get<Obstacle>(end).gap; }},
};

inline constexpr std::string_view inputs_of_free_ends[] = {"force", "stiffness", "dashpot", "mass"};
inline constexpr std::string_view inputs_of_fixed_ends[] = {"motion"};

inline constexpr EndKind end_kinds[] = {
    {"obstacle", "an obstacle",
     "u >= -gap, or u <= gap with the side above; the reaction acts only in contact and pushes, but for the dashpot of "
     "contact.restitution, which may pull as a penalised contact opens; wants a gap",
     Obstacle{1e100}, true, inputs_of_free_ends, obstacle_numbers,
     [](const EndCondition& end, double) { return EndNode{.obstacle = std::get<Obstacle>(end)}; }},
    {"free",
     "free",
     "no stress, E u_x + eta u_xt = 0, but what force, stiffness, dashpot and mass make",
     Free{},
     false,
     inputs_of_free_ends,
     {},
     [](const EndCondition&, double) { return EndNode{}; }},
    {"fixed",
     "fixed",
     "keeps its initial displacement, unless it has a motion",
     Fixed{},
     false,
     inputs_of_fixed_ends,
     {},
     [](const EndCondition&, double initial) { return EndNode{.held = initial}; }},
};
static_assert(std::size(end_kinds) == std::variant_size_v<EndCondition>);

inline const EndKind& end_kind(const EndCondition& end) {
  return *std::ranges::find(end_kinds, end.index(), [](const EndKind& kind) { return kind.harmless.index(); });
}

/// True if an end of that kind has that key.
inline bool belongs_to_end(std::string_view kind, std::string_view key) {
  const auto* known = std::ranges::find(end_kinds, kind, &EndKind::name);
  if (known == std::end(end_kinds)) return false;
  return (known->sided && (key == "side" || key.starts_with("contact."))) ||
         std::ranges::count(known->inputs, key) > 0 || std::ranges::count(known->numbers, key, &EndNumber::key) > 0;
}

inline EndNode end_node(const EndCondition& end, double initial_displacement) {
  return end_kind(end).node(end, initial_displacement);
}

/// True if an end has an obstacle that may hold a node without mass: nothing is mounted there, and no stop has a law of
/// its own. The mass "redistributed" takes the mass of these nodes alone.
inline bool is_bare_obstacle(const EndCondition& end, const EndInput& input) {
  return is_obstacle(end) && input.stiffness == 0.0 && input.dashpot == 0.0 && input.mass == 0.0 && !input.stop;
}
inline std::size_t bare_obstacles(const Scene& scene) {
  return std::size_t{is_bare_obstacle(scene.left, scene.left_input)} +
         std::size_t{is_bare_obstacle(scene.right, scene.right_input)};
}

/// True if a contact without a law of its own keeps its restitution on every mesh: of a mass on an end, or of a rigid
/// body, with an obstacle or another rigid body. That of a node goes with its mass.
inline bool keeps_restitution(const Scene& scene) {
  const std::vector<Member>& chain = scene.chain;
  const auto heavy = [&](const EndCondition& end, const EndInput& input, bool body) {
    return is_obstacle(end) && !input.stop && (input.mass > 0.0 || body);
  };
  for (std::size_t k = 0; k + 1 < chain.size(); ++k)
    if (chain[k].joint.kind == JointKind::contact && !chain[k].joint.stop && chain[k].rigid() && chain[k + 1].rigid())
      return true;
  return heavy(scene.left, scene.left_input, !chain.empty() && chain.front().rigid()) ||
         heavy(scene.right, scene.right_input, !chain.empty() && chain.back().rigid());
}

/// True if an obstacle at an end has no law of its own.
inline bool has_end_penalty(const Scene& scene) {
  return (is_obstacle(scene.left) && !scene.left_input.stop) || (is_obstacle(scene.right) && !scene.right_input.stop);
}

/// True if epsilon is a penetration per force on a volume, and not one per stress.
inline bool is_penalty_of_span(const Scene& scene) { return scene.span && !has_end_penalty(scene); }

}  // namespace viscobar

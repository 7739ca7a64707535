#pragma once

#include <cstddef>
#include <vector>

#include "viscobar/run/run.hpp"

namespace viscobar {

/// A place where a scene may have contacts: an end with an obstacle, the span, a joint that is a contact.
struct ContactPlace {
  Where where = Where::left;
  std::size_t joint = 0;  ///< its number from 1, of a joint

  ContactAccount account(const RunAccount& of) const {
    if (joint > 0) return of.joint(joint);
    if (where == Where::span) return of.span;
    return where == Where::left ? of.left : of.right;
  }
};

/// Left, right, span, and joints from left to right.
inline std::vector<ContactPlace> contact_places(const Scene& scene) {
  std::vector<ContactPlace> all;
  if (is_obstacle(scene.left)) all.push_back({Where::left});
  if (is_obstacle(scene.right)) all.push_back({Where::right});
  if (scene.span) all.push_back({Where::span});
  for (std::size_t k = 1; k < scene.chain.size(); ++k)
    if (scene.chain[k - 1].joint.kind == JointKind::contact) all.push_back({Where::joint, k});
  return all;
}

}  // namespace viscobar

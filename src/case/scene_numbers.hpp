#pragma once

#include <optional>
#include <string_view>
#include <utility>
#include <vector>

#include "viscobar/case/case.hpp"

namespace viscobar {

/// The number with that key of a scene file, of `bar`, or of the ends of `scene`; null: there is none.
double* number_of(Bar& bar, Scene& scene, std::string_view key);
/// The same of a member of a chain, such as bar.2.modulus or joint.1.gap.
double* number_of(std::vector<Member>& chain, std::string_view key);
/// A function of its members as one of x along it, at a joint that of the left bar, at an end that of the end's member.
SpaceFunction along(std::vector<Member> chain, SpaceFunction Member::*own);
/// Number and leaf of a key of a member: 2, "modulus" of "bar.2.modulus" and the table "bar"; absent: it is none.
std::optional<std::pair<std::size_t, std::string_view>> member_key(std::string_view table, std::string_view key);
/// Tells a direction what depends on sections: dA/dp of the bar, or of each member, at a fixed part of it; empty where
/// p does not enter.
void vary_sections(Direction& along, const Case& run, const std::vector<SpaceFunction>& rates);
/// The same of a case, and its restitution.
double* number_of(Case& run, std::string_view key);

}  // namespace viscobar

#pragma once

#include <optional>
#include <string_view>

#include "scene/unit_names.hpp"

namespace viscobar {

/// Unit of the number that a key names. Under the span a reaction is a force per length of the bar, so epsilon has a
/// length more there, and none of its own where the same number serves an end.
std::optional<UnitPowers> unit_of_key(std::string_view key, const Scene& scene);

}  // namespace viscobar

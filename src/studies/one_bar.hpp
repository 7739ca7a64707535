#pragma once

#include <fmt/format.h>

#include <stdexcept>
#include <string_view>

#include "viscobar/scene/scene.hpp"

namespace viscobar {

/// Refuses a study that is of one bar.
/// @throws std::invalid_argument for several in line
inline void require_one_bar(const Scene& scene, std::string_view study) {
  if (!scene.chain.empty())
    throw std::invalid_argument(
        fmt::format("bar.1.length: {} takes one bar, and here are {} in line; `viscobar run` and `sweep` take those",
                    study, scene.chain.size()));
}

}  // namespace viscobar

#pragma once

#include <fmt/format.h>

#include <string>
#include <vector>

#include "text/number.hpp"
#include "viscobar/scene/scene.hpp"

namespace viscobar {

/// What an end is given, a phrase for each.
inline std::vector<std::string> words_of(const EndInput& input, bool obstacle) {
  std::vector<std::string> words;
  if (input.force)
    words.push_back(input.force->steady ? fmt::format("force {}", readable(input.force->value(0.0))) : "force F(t)");
  if (input.motion) words.push_back(obstacle ? "moving" : "motion d(t)");
  if (input.stiffness > 0.0) words.push_back(fmt::format("spring {} to u = 0", readable(input.stiffness)));
  if (input.dashpot > 0.0) words.push_back(fmt::format("dashpot {}", readable(input.dashpot)));
  return words;
}

}  // namespace viscobar

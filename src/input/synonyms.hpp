#pragma once

#include <optional>
#include <string_view>

#include "text/nearest_name.hpp"

namespace viscobar {

/// What viscobar calls a thing that papers and other programs call `word`: "alpha" is the viscosity, "clamped" is
/// fixed. The word itself when it is none of them.
std::string_view usual_name(std::string_view word);

/// The candidate that `word` was probably meant to be: what it means, or else the nearest by its letters.
template <class Names>
std::optional<std::string_view> meant_name(std::string_view word, const Names& candidates) {
  for (const std::string_view candidate : candidates)
    if (candidate == usual_name(word)) return candidate;
  if (const auto nearest = nearest_name(word, candidates)) return nearest;
  return nearest_name(usual_name(word), candidates);
}

}  // namespace viscobar

#pragma once

#include <optional>
#include <string_view>

#include "text/nearest_name.hpp"

namespace viscobar {

/// What viscobar calls a thing that papers and other programs call `word`: "alpha" is the viscosity, "clamped" is
/// fixed. The word itself when it is none of them.
std::string_view usual_name(std::string_view word);

/// The candidate that `word` was probably meant to be, by its letters, or else by what it means.
template <class Names>
std::optional<std::string_view> meant_name(std::string_view word, const Names& candidates) {
  if (const auto nearest = nearest_name(word, candidates)) return nearest;
  return nearest_name(usual_name(word), candidates);
}

}  // namespace viscobar

#pragma once

#include <string_view>

#include "viscobar/case/case.hpp"

namespace viscobar {

/// The number with that key of a scene file, of `bar`, or of the ends of `scene`; null: there is none.
double* number_of(Bar& bar, Scene& scene, std::string_view key);
/// The same of a case, and its restitution.
double* number_of(Case& run, std::string_view key);

}  // namespace viscobar

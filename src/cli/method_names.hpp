#pragma once

#include <string>
#include <vector>

#include "viscobar/case/case.hpp"

namespace viscobar::cli {

/// The methods that an option --methods names. @throws std::invalid_argument for an unknown one, with the nearest
std::vector<MethodName> methods_named(const std::vector<std::string>& words);

}  // namespace viscobar::cli

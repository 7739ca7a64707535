#pragma once

#include <string>
#include <string_view>

#include "viscobar/dynamics/bar_system.hpp"

namespace viscobar {

/// Why m M + c C + k K, the matrix of a step of length c / m, is not positive definite in floating-point numbers: of
/// its entries the inertia is rounded away beside what is so much larger.
std::string lost_inertia(const BarSystem& system, double m, double c, double k);

}  // namespace viscobar

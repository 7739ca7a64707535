#pragma once

#include <array>

namespace viscobar {

/// I_j = int_0^s exp(-mu (s - r)) r^j dr, j = 0 .. 5, by I_j = (s^j - j I_{j-1}) / mu, which is taken in the direction
/// in which it forgets errors.
std::array<double, 6> relaxed_powers(double mu, double s);

}  // namespace viscobar

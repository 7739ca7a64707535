#pragma once

#include <fmt/format.h>

#include <string>

#include "viscobar/dynamics/bar_system.hpp"

namespace viscobar {

/// Why m M + c C + k K, the matrix of a step of length c / m, is not positive definite in floating-point numbers: of
/// its entries the inertia is rounded away beside what is so much larger.
inline std::string lost_inertia(const BarSystem& system, double m, double c, double k) {
  const Bar& bar = system.bar();
  const double h = system.elements().finest(), inertia = m * bar.density * h * h;
  const double damping = c * bar.viscosity / inertia, elasticity = k * bar.modulus / inertia;
  const bool by_damping = damping > elasticity;
  return fmt::format("a step of {:.2g} leaves no digit of the inertia beside the {}, which is {:.1e} times as large",
                     c / m, by_damping ? "damping" : "elasticity", by_damping ? damping : elasticity);
}

}  // namespace viscobar

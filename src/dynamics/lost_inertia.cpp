#include "dynamics/lost_inertia.hpp"

#include <fmt/format.h>

namespace viscobar {

std::string lost_inertia(const BarSystem& system, double m, double c, double k) {
  const Bar& bar = system.bar();
  const double h = system.mesh().smallest(), inertia = m * bar.density * h * h;
  const double damping = c * bar.viscosity / inertia, elasticity = k * bar.modulus / inertia;
  const bool by_damping = damping > elasticity;
  return fmt::format("a step of {:.2g} leaves no digit of the inertia beside the {}, which is {:.1e} times as large",
                     c / m, by_damping ? "damping" : "elasticity", by_damping ? damping : elasticity);
}

}  // namespace viscobar

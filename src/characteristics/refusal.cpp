#include <cmath>

#include "viscobar/characteristics/characteristics.hpp"

namespace viscobar {

std::optional<Refusal> refusal(const Scene& scene, double end, const Characteristics&) {
  if (scene.bar.viscosity > 0.0) return Refusal::viscosity;
  if (scene.span) return Refusal::span;
  if (scene.left_input.stiffness != 0.0 || scene.right_input.stiffness != 0.0) return Refusal::end_springs;
  const double passages = end * std::sqrt(scene.bar.modulus / scene.bar.density) / scene.bar.length;
  if (!(passages <= Characteristics::most_passages)) return Refusal::many_steps;
  return std::nullopt;
}

}  // namespace viscobar

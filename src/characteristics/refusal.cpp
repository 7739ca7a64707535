#include <cmath>

#include "viscobar/characteristics/characteristics.hpp"

namespace viscobar {

std::optional<Refusal> refusal(const Scene& scene, double end, const Characteristics&) {
  if (scene.bar.viscosity > 0.0) return Refusal::viscosity;
  if (scene.span) return Refusal::span;
  for (const EndInput& input : {scene.left_input, scene.right_input})
    if (input.force || input.motion || input.stiffness != 0.0 || input.dashpot != 0.0) return Refusal::end_inputs;
  const double passages = end * std::sqrt(scene.bar.modulus / scene.bar.density) / scene.bar.length;
  if (!(passages <= Characteristics::most_passages)) return Refusal::many_steps;
  return std::nullopt;
}

}  // namespace viscobar

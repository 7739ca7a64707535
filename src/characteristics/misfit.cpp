#include <fmt/format.h>

#include "viscobar/characteristics/characteristics.hpp"

namespace viscobar {

std::optional<std::string> misfit(const Scene& scene, const Characteristics&) {
  if (scene.bar.viscosity > 0.0)
    return fmt::format(
        "characteristics carries waves unchanged, and bar.viscosity = {} changes them; use rigid, or one of the "
        "penalised methods",
        scene.bar.viscosity);
  if (scene.span)
    return "characteristics knows obstacles at the ends, and under a span obstacle the whole bar may touch; use "
           "fully_discrete, or one of the penalised methods";
  return std::nullopt;
}

}  // namespace viscobar

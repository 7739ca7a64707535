#pragma once

#include <compare>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "studies/precision/field.hpp"
#include "viscobar/studies/precision/precision.hpp"

namespace viscobar::precision {

/// Which semi-discrete problem a method solves.
struct System {
  enum class Law {
    penalised,  ///< at `epsilon`; 0 where there is nothing to penalise
    rigid,      ///< epsilon = 0 on massless contact nodes
    impact,     ///< the constraint of the schemes on nodes with mass
    continuous  ///< none: the bar itself
  };
  std::size_t elements = 0;
  Mass mass = Mass::consistent;
  Law law = Law::penalised;
  double epsilon = 0.0;

  auto operator<=>(const System&) const = default;
};
System system_of(const Case& run);

/// A semi-discrete problem solved exactly in time, or as well as can be.
struct SemiDiscrete {
  std::optional<Field> field;  ///< absent: see `problem`
  std::string what;
  double error = 0.0;  ///< an estimate: the difference to another method or to a coarser run
  std::string problem;
};

/// By matrix exponentials where the mesh is small, else at a relative tolerance (adaptive methods) or a step (the
/// schemes' impact) that should be finer than all that is measured against it.
struct Fineness {
  double tolerance = 1e-11, step = 0.0;
};
SemiDiscrete solve_in_time(const Case& scene, const System& system, const Fineness& fineness, double seconds);

/// The continuous problem, on each mesh.
struct Continuous {
  std::optional<PrecisionReference> reference;
  std::string problem;
  std::vector<Field> fields;
};

/// By refinement of the mesh from the finest of `meshes` on: `rigid`, on the fourth-order mass where the mesh is
/// uniform, else, under a span obstacle, the scheme, whose step is refined with the mesh.
Continuous refine(const Case& scene, std::span<const Mesh> meshes, double seconds);
Continuous closed_form(const KnownSolution& known, const Case& scene, std::span<const Mesh> meshes);
/// By characteristics, of a scene that they fit. @throws what the run does
Continuous by_characteristics(const Case& scene, std::span<const Mesh> meshes, double seconds);

}  // namespace viscobar::precision

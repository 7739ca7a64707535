#pragma once

#include <compare>
#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "studies/run_limits.hpp"
#include "viscobar/case/end_traces.hpp"
#include "viscobar/studies/precision/precision.hpp"

namespace viscobar::precision {

/// A displacement at the nodes of a mesh and the output times of a case.
struct Field {
  Mesh mesh;
  std::vector<double> u;  // K x nodes, row by row

  std::span<const double> at(std::size_t k) const { return std::span(u).subspan(k * mesh.nodes(), mesh.nodes()); }
};

/// The mesh of a case with as many elements.
inline Mesh mesh_of(Case run, std::size_t elements) {
  run.elements = elements;
  return run.mesh();
}

/// P1 interpolation between meshes of one grading; exact at nodes that they share.
void interpolate(const Mesh& from, std::span<const double> u, const Mesh& to, std::span<double> out);

/// Runs the case and keeps its displacement on each of the meshes; `done`: what the run tells at its end. @throws as
/// simulate_within()
std::vector<Field> fields_of(const Case& run, std::span<const Mesh> meshes, const RunLimits& limits,
                             Statistics* done = nullptr);

/// The same on one mesh.
inline Field field_of(const Case& run, const Mesh& mesh, const RunLimits& limits, Statistics* done = nullptr) {
  return std::move(fields_of(run, std::span(&mesh, 1), limits, done).front());
}

Field field_of(const SpaceTimeFunction& u, const Mesh& mesh, std::span<const double> times);

/// max over nodes and times after the start, on the same mesh and times. What methods make of initial data that a
/// massless node contradicts is no error of theirs.
double largest_difference(const Field& a, const Field& b);

/// fine + (fine - coarse) / (ratio - 1), where the error of `coarse` is `ratio` times that of `fine`.
Field extrapolated(const Field& fine, const Field& coarse, double ratio);

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
System system_of(const Setup& setup);

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
SemiDiscrete solve_in_time(const Case& scene, const System& system, const Fineness& fineness, const RunLimits& limits);

/// The continuous problem, on each mesh.
struct Continuous {
  std::optional<PrecisionReference> reference;
  std::string problem;
  std::vector<Field> fields;
};

/// By refinement of the mesh from `elements` on, those of the finest of `meshes`: `rigid`, on the fourth-order mass
/// where the mesh is uniform, else, under a span obstacle, the scheme, whose step is refined with the mesh.
Continuous refine(const Case& scene, std::span<const Mesh> meshes, std::size_t elements, const RunLimits& limits);
Continuous closed_form(const KnownSolution& solution, const Case& scene, std::span<const Mesh> meshes);
/// By characteristics, of a scene that they fit. @throws what the run does
Continuous by_characteristics(const Case& scene, std::span<const Mesh> meshes, const RunLimits& limits);

}  // namespace viscobar::precision

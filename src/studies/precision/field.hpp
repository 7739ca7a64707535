#pragma once

#include <span>
#include <stdexcept>
#include <vector>

#include "viscobar/case/case.hpp"
#include "viscobar/scene/scene.hpp"

namespace viscobar::precision {

/// A displacement at the nodes of a mesh and the output times of a case.
struct Field {
  Mesh mesh;
  std::vector<double> u;  // K x (J+1), row by row

  std::size_t times() const { return u.size() / mesh.nodes(); }
  std::span<const double> at(std::size_t k) const { return std::span(u).subspan(k * mesh.nodes(), mesh.nodes()); }
};

/// A run took longer than it may.
class TooLong : public std::runtime_error {
 public:
  TooLong() : std::runtime_error("takes too long") {}
};

/// Runs the case as long as the clock allows. @throws TooLong, IntegrationError, std::invalid_argument
Statistics simulate_within(double seconds, const Case& run, const BarSystem& system, Observers observers);

/// P1 interpolation between meshes of one grading; exact at nodes that they share.
void interpolate(const Mesh& from, std::span<const double> u, const Mesh& to, std::span<double> out);

/// Runs the case and keeps its displacement on each of the meshes; `done`: what the run tells at its end. @throws
/// TooLong, IntegrationError, std::invalid_argument
std::vector<Field> fields_of(const Case& run, std::span<const Mesh> meshes, double seconds, Statistics* done = nullptr);

Field field_of(const SpaceTimeFunction& u, const Mesh& mesh, std::span<const double> times);

double distance(std::span<const double> a, std::span<const double> b);

/// max over nodes and times after the start, on the same mesh and times. What methods make of initial data that a
/// massless node contradicts is no error of theirs.
double distance(const Field& a, const Field& b);

/// fine + (fine - coarse) / (ratio - 1), where the error of `coarse` is `ratio` times that of `fine`.
Field extrapolated(const Field& fine, const Field& coarse, double ratio);

}  // namespace viscobar::precision

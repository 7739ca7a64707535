#include "dynamics/gauge.hpp"

#include <fmt/format.h>

#include "dynamics/pieces.hpp"

namespace viscobar {

namespace {

Interpolant within(const Mesh& mesh, std::size_t first, std::size_t last, double x) {
  std::vector<double> nodes;
  for (std::size_t j = first; j <= last; ++j) nodes.push_back(mesh.node(j));
  Interpolant at = interpolant(nodes, x);
  at.begin += first;
  return at;
}

// Where A jumps or has a kink, u_x or u_xx jumps: a polynomial is of the nodes on one side, to the left of the place
// itself. An element that is cut by such a place has its P1 functions.
Interpolant within(const Piece& piece, double x) {
  const Mesh& mesh = piece.mesh;
  if (!piece.section) return within(mesh, 0, mesh.elements, x);
  const double close = 1e-9 * mesh.length;
  const auto breaks = [&](double after, double until) { return piece.section->next_break(after, until) < until; };
  std::size_t first = 0;
  while (first + 1 < mesh.elements && mesh.node(first + 1) < x - close) ++first;
  std::size_t last = first + 1;
  if (breaks(mesh.node(first) + close, mesh.node(last) - close)) {
    const double to = piece.section->along(first, x),
                 slope = 1.0 / (piece.section->stretch(first) * piece.section->area(x));
    return {.begin = first, .count = 2, .weights = {1.0 - to, to}, .slopes = {-slope, slope}};
  }
  while (first > 0 && !breaks(mesh.node(first - 1) + close, mesh.node(first) + close)) --first;
  while (last < mesh.elements && !breaks(mesh.node(last) - close, mesh.node(last + 1) - close)) ++last;
  return within(mesh, first, last, x);
}

}  // namespace

Gauge::Gauge(const Mesh& mesh, const Bar& bar, double x)
    : at_(within(mesh, 0, mesh.elements, x)), x_(x), modulus_(bar.modulus), viscosity_(bar.viscosity) {}

Gauge::Gauge(const Mesh& mesh, const Scene& scene, double x) : x_(x) {
  const double rounding = 1e-12 * mesh.length;  // of a sum of lengths
  for (const Piece& piece : pieces_of(scene, mesh)) {
    if (piece.rigid() || (piece.begin > 0.0 && x <= piece.begin + rounding)) continue;
    at_ = within(piece, x - piece.begin);
    at_.begin += piece.first;
    modulus_ = piece.bar.modulus, viscosity_ = piece.bar.viscosity;
  }
}

Gauge::Reading Gauge::operator()(std::span<const double> u, std::span<const double> v) const {
  const double strain = at_.slope(u), rate = viscosity_ > 0.0 ? at_.slope(v) : 0.0;
  return {at_.value(u), at_.value(v), strain, modulus_ * strain + viscosity_ * rate};
}

std::vector<Gauge> make_gauges(std::span<const double> places, const Mesh& mesh, const Scene& scene) {
  std::vector<Gauge> gauges;
  for (const double x : places) gauges.emplace_back(mesh, scene, x);
  return gauges;
}

std::vector<std::string> gauge_columns(std::span<const double> places) {
  std::vector<std::string> columns;
  for (const double x : places)
    for (const char* quantity : {"u", "v", "strain", "stress"}) columns.push_back(fmt::format("{}@{}", quantity, x));
  return columns;
}

}  // namespace viscobar

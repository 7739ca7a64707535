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

}  // namespace

Gauge::Gauge(const Mesh& mesh, const Bar& bar, double x)
    : at_(within(mesh, 0, mesh.elements, x)), x_(x), modulus_(bar.modulus), viscosity_(bar.viscosity) {}

Gauge::Gauge(const Mesh& mesh, const Scene& scene, double x) : Gauge(mesh, scene.bar, x) {
  if (scene.chain.empty()) return;
  for (const Piece& piece : pieces_of(scene, mesh)) {
    if (piece.rigid() || (piece.begin > 0.0 && !is_behind(x, piece.begin))) continue;
    at_ = within(mesh, piece.first, piece.last(), x);
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

#include "dynamics/gauge.hpp"

#include <fmt/format.h>

#include <numeric>

namespace viscobar {

namespace {

// The element around x, its right node included.
std::size_t element_of(const Mesh& mesh, double x) {
  std::size_t first = 0, end = mesh.elements;
  while (end - first > 1) {
    const std::size_t middle = std::midpoint(first, end);
    (mesh.node(middle) < x ? first : end) = middle;
  }
  return first;
}

Interpolant within(const Mesh& mesh, const VaryingSection* section, double x) {
  const double close = 1e-9 * mesh.length;
  const auto breaks = [&](double after, double until) {
    return section != nullptr && section->next_break(after, until) < until;
  };
  const std::size_t element = element_of(mesh, x - close);
  if (breaks(mesh.node(element) + close, mesh.node(element + 1) - close)) {
    const double to = section->along(element, x), slope = 1.0 / (section->stretch(element) * section->area(x));
    return {.begin = element, .count = 2, .weights = {1.0 - to, to}, .slopes = {-slope, slope}};
  }
  std::size_t first = element, last = element + 1;  // as many as six around x may be of
  while (first > 0 && element - first < 5 && !breaks(mesh.node(first - 1) + close, mesh.node(first) + close)) --first;
  while (last < mesh.elements && last - element < 6 && !breaks(mesh.node(last) - close, mesh.node(last + 1) - close))
    ++last;
  std::vector<double> nodes;
  for (std::size_t j = first; j <= last; ++j) nodes.push_back(mesh.node(j));
  Interpolant at = interpolant(nodes, x);
  at.begin += first;
  return at;
}

}  // namespace

Interpolant interpolant_of(const Piece& piece, double x) {
  Interpolant at;
  if (!piece.rigid()) at = within(piece.mesh, piece.section.get(), x);
  at.begin += piece.first;
  return at;
}

Gauge::Gauge(const Mesh& mesh, const Bar& bar, double x)
    : at_(within(mesh, nullptr, x)), x_(x), modulus_(bar.modulus), viscosity_(bar.viscosity) {}

Gauge::Gauge(const Mesh& mesh, const Scene& scene, double x) : x_(x) {
  for (const Piece& piece : pieces_of(scene, mesh)) {
    if (piece.rigid() || (piece.begin > 0.0 && !is_behind(x, piece.begin))) continue;
    at_ = interpolant_of(piece, x - piece.begin);
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

double element_stress(const Bar& bar, const Mesh& mesh, std::span<const double> u, std::span<const double> v,
                      std::size_t j) {
  const double size = mesh.element(j);
  return size > 0.0 ? (bar.modulus * (u[j + 1] - u[j]) + bar.viscosity * (v[j + 1] - v[j])) / size : 0.0;
}

}  // namespace viscobar

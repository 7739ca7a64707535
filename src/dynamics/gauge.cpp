#include "dynamics/gauge.hpp"

#include <fmt/format.h>

namespace viscobar {

namespace {

std::vector<double> nodes_of(const Mesh& mesh) {
  std::vector<double> nodes(mesh.nodes());
  for (std::size_t j = 0; j < nodes.size(); ++j) nodes[j] = mesh.node(j);
  return nodes;
}

}  // namespace

Gauge::Gauge(const Mesh& mesh, const Bar& bar, double x)
    : at_(interpolant(nodes_of(mesh), x)), x_(x), modulus_(bar.modulus), viscosity_(bar.viscosity) {}

Gauge::Reading Gauge::operator()(std::span<const double> u, std::span<const double> v) const {
  const double strain = at_.slope(u), rate = viscosity_ > 0.0 ? at_.slope(v) : 0.0;
  return {at_.value(u), at_.value(v), strain, modulus_ * strain + viscosity_ * rate};
}

std::vector<Gauge> make_gauges(std::span<const double> places, const Mesh& mesh, const Bar& bar) {
  std::vector<Gauge> gauges;
  for (const double x : places) gauges.emplace_back(mesh, bar, x);
  return gauges;
}

std::vector<std::string> gauge_columns(std::span<const double> places) {
  std::vector<std::string> columns;
  for (const double x : places)
    for (const char* quantity : {"u", "v", "strain", "stress"}) columns.push_back(fmt::format("{}@{}", quantity, x));
  return columns;
}

}  // namespace viscobar

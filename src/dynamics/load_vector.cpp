#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "viscobar/dynamics/bar_system.hpp"
#include "viscobar/dynamics/errors.hpp"

namespace viscobar {

LoadVector::LoadVector(const BarSystem& system) : system_(system) {
  if (std::holds_alternative<BarSystem::SteadyVector>(*system.load_)) return;
  weighted_.resize(system.size());
  if (std::holds_alternative<BarSystem::GeneralVector>(*system.load_)) nodal_.resize(2 * system.mesh().nodes());
}

bool LoadVector::steady() const { return weighted_.empty(); }

std::span<const double> LoadVector::at(double t) {
  if (const auto* steady = std::get_if<BarSystem::SteadyVector>(&*system_.load_)) return steady->weighted;
  if (time_ == t) return weighted_;
  ++evaluations_;
  if (const auto* separable = std::get_if<BarSystem::SeparableVector>(&*system_.load_)) {
    const double history = separable->history(t);
    if (!std::isfinite(history)) throw LoadError(t, fmt::format("the history of the load is {} at t = {}", history, t));
    std::transform(separable->weighted.begin(), separable->weighted.end(), weighted_.begin(),
                   [history](double profile) { return history * profile; });
  } else {
    const auto& general = std::get<BarSystem::GeneralVector>(*system_.load_);
    const Mesh& mesh = system_.mesh();
    const std::span<double> values(nodal_.data(), mesh.nodes()), product(nodal_.data() + mesh.nodes(), mesh.nodes());
    for (std::size_t j = 0; j < values.size(); ++j) {
      values[j] = general.density(mesh.node(j), t);
      if (!std::isfinite(values[j]))
        throw LoadError(t, fmt::format("the load is {} at x = {}, t = {}", values[j], mesh.node(j), t));
    }
    general.mass.multiply(values, product);
    std::copy_n(product.begin() + static_cast<std::ptrdiff_t>(system_.first_node()), weighted_.size(),
                weighted_.begin());
  }
  time_ = t;
  return weighted_;
}

}  // namespace viscobar
